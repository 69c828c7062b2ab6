#pragma once
/// \file
/// Strains of yarns as numbers: a CSV file, and what a terminal shows.

#include <filesystem>
#include <vector>

#include "meso/comparison.h"
#include "workflows/program/csv.h"

namespace trame::workflows {

/// strains.csv, written state by state: one line per increment and yarn with a mesh, with counts of tetrahedra, then
/// mean, deviation, min, quantiles and max of each quantity.
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

/// Prints what is odd about the meshes, and the strains; with two kinds of mesh also the differences of their means
/// (second − first).
void print_strains(const std::vector<micro::Yarn>& yarns, const meso::Comparison& comparison);

}  // namespace trame::workflows
