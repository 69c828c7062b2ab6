#pragma once
/// \file
/// From saved states to strains of yarns: meshes each yarn once, computes the strain from state A to each chosen state
/// B, sums it up and writes it for ParaView.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "meso/fiber_states.h"
#include "meso/statistics.h"
#include "meso/yarn_fields.h"
#include "meso/yarn_mesh.h"

namespace trame::meso {

/// One yarn in one state B. Distributions are over the tetrahedra that are not flagged, weighted by reference volume.
struct YarnStrain {
  Index increment = 0;
  Index yarn = 0;
  Index n_tets = 0, n_flagged = 0, n_inverted = 0;  ///< all; of these without a strain; of these inside out
  Statistics axial, horizontal, vertical, gamma_max, det_F;
};

struct AnalyseOptions {
  Index from = 0;                       ///< state A
  std::vector<Index> to = {};           ///< states B; empty: all increments
  std::vector<std::string> yarns = {};  ///< names with * and ? as wildcards; empty: all yarns
  MeshOptions mesh = {};
  std::filesystem::path vtk_folder = {};  ///< for yarns.pvd; empty: not written
  int n_threads = 0;                      ///< 0: all cores
  /// Is given the rows of each state B in turn, one per yarn with a mesh.
  std::function<void(const std::vector<YarnStrain>&)> on_state = {};
};

/// Of the states B only the last is kept.
struct Analysis {
  std::vector<YarnMesh> meshes;     ///< of the chosen yarns, in their order; also those without volume
  std::vector<YarnFields> fields;   ///< of each of `meshes`, in the last state B
  std::vector<YarnStrain> strains;  ///< in the last state B, one per yarn with a mesh
  std::filesystem::path pvd;        ///< empty where nothing was written

  [[nodiscard]] Index n_tets() const;
};

/// Indices of the yarns that match any of `patterns` (all where there are none), in the order of `yarns`. Throws
/// InputError for a pattern that matches none.
[[nodiscard]] std::vector<Index> choose_yarns(const std::vector<micro::Yarn>& yarns,
                                              const std::vector<std::string>& patterns);

/// Holds one state B at a time, however many there are. Throws InputError for increments or yarns that the states do
/// not have, for a reference state that cannot be meshed, and for a folder that cannot be written to.
[[nodiscard]] Analysis analyse(const FiberStates& states, const AnalyseOptions& options);

/// The same for the states of a run.
[[nodiscard]] inline Analysis analyse(const micro::SnapshotReader& states, const AnalyseOptions& options) {
  return analyse(RunStates(states), options);
}

}  // namespace trame::meso
