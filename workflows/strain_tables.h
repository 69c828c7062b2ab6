#pragma once
/// \file
/// Strains of yarns as numbers: a CSV file, and what a terminal shows.

#include <filesystem>
#include <string>
#include <vector>

#include "meso/analyse.h"

namespace trame::workflows {

/// What an analysis found with one kind of mesh.
struct MeshedStrains {
  std::string mesh;  ///< "delaunay" or "swept"
  meso::Analysis analysis;
};

/// One line per increment and yarn: counts of tetrahedra, then mean, deviation, min and max of each quantity. Throws
/// InputError where the file cannot be written.
void write_strains_csv(const std::filesystem::path& file, const std::vector<micro::Yarn>& yarns,
                       const meso::Analysis& analysis);

/// Prints what is odd about the meshes, and the strains at increment `last`; with two kinds of mesh also the
/// differences of their means (second − first).
void print_strains(const std::vector<micro::Yarn>& yarns, const std::vector<MeshedStrains>& all, Index last);

}  // namespace trame::workflows
