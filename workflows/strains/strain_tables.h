#pragma once
/// \file
/// Strains of yarns as numbers: a CSV file, and what a terminal shows.

#include <filesystem>
#include <string>
#include <vector>

#include "meso/findings.h"
#include "workflows/csv.h"

namespace trame::workflows {

/// What an analysis found with one kind of mesh.
struct MeshedStrains {
  std::string mesh;  ///< "delaunay" or "swept"
  meso::Analysis analysis;
  std::vector<std::vector<meso::SectionBands>> bands = {};  ///< on the sections of each of the analysis's meshes
  std::vector<meso::Orientation> orientations = {};         ///< the same
};

/// strains.csv, written state by state: one line per increment and yarn with counts of tetrahedra, then mean,
/// deviation, min, quantiles and max of each quantity.
class StrainsCsv {
 public:
  /// Throws WriteError where the file cannot be made. `yarns` must outlive the object.
  StrainsCsv(const std::filesystem::path& file, const std::vector<micro::Yarn>& yarns);

  /// Throws WriteError where the file cannot be written.
  void append(const std::vector<meso::YarnStrain>& rows);

 private:
  const std::vector<micro::Yarn>& yarns_;
  CsvFile out_;
};

/// Prints what is odd about the meshes, and the strains at the last increment; with two kinds of mesh also the
/// differences of their means (second − first).
void print_strains(const std::vector<micro::Yarn>& yarns, const std::vector<MeshedStrains>& all);

}  // namespace trame::workflows
