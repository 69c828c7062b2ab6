#pragma once
/// \file
/// Strains of a series of states in one call, for tests.

#include <functional>
#include <string>
#include <vector>

#include "meso/strain_series.h"

namespace trame::meso::test {

struct AnalyseOptions {
  Index from = 0;
  std::vector<Index> to = {};
  std::vector<std::string> yarns = {};
  MeshKind mesh = MeshKind::delaunay;
  std::filesystem::path vtk_folder = {};
  int n_threads = 0;
  std::function<void(const std::vector<YarnStrain>&)> on_state = {};  ///< rows of yarns with a mesh
};

/// Of the states B only the last is kept.
struct Analysis {
  std::vector<YarnMesh> meshes;
  std::vector<YarnFields> fields;
  std::vector<YarnStrain> strains;  ///< of yarns with a mesh
  Index n_tets = 0;
};

inline Analysis analyse(const FiberStates& states, const AnalyseOptions& options) {
  const YarnComparer comparer(states,
                              {.yarns = options.yarns, .meshes = {options.mesh}, .n_threads = options.n_threads});
  Analysis analysis{comparer.meshes(options.mesh), {}, {}, comparer.n_tets(options.mesh)};
  StrainSeries series{.from = options.from, .to = options.to};
  if (!options.vtk_folder.empty()) series.vtk_folders = {options.vtk_folder};
  series.on_state = [&](const StateStrains& strains) {
    analysis.fields = strains.meshes.front().fields;
    analysis.strains.clear();
    for (const YarnStrain& row : strains.meshes.front().summaries)
      if (row.n_tets > 0) analysis.strains.push_back(row);
    if (options.on_state) options.on_state(analysis.strains);
  };
  (void)follow(comparer, series);
  return analysis;
}

}  // namespace trame::meso::test
