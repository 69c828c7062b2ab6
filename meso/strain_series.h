#pragma once
/// \file
/// Strains from one state to many, one at a time: for ParaView, for tables, and for comparisons of some of them.

#include <filesystem>
#include <functional>
#include <vector>

#include "meso/comparison.h"
#include "micro/states/cell_copies.h"

namespace trame::meso {

struct StrainSeries {
  Index from = 0;                   ///< state A
  std::vector<Index> to = {};       ///< states B in turn; empty: all increments
  std::vector<Index> compare = {};  ///< those of them that everything is wanted of
  /// Of yarns.pvd, for each mesh of the settings; empty: not written.
  std::vector<std::filesystem::path> vtk_folders = {};
  micro::Copies copies = micro::one_cell;                  ///< of a periodic cell, in yarns.pvd
  std::function<void(const StateStrains&)> on_state = {};  ///< is given each state in turn
};

/// Holds one state B at a time, however many there are. Returns the comparisons, in the order of `to`. Throws
/// InputError for increments that there are not and for a folder that cannot be written to.
[[nodiscard]] std::vector<Comparison> follow(const YarnComparer& comparer, const StrainSeries& series);

}  // namespace trame::meso
