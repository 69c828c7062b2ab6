#pragma once
/// \file
/// A periodic cell as it goes on: fibers without a seam through several copies of it, and where the cell is in them.
/// Lengths in m.

#include <array>
#include <optional>

#include "micro/states/cell_copies.h"

namespace trame::workflows {

struct ContinuedCell {
  micro::FiberMesh mesh;
  micro::FiberConfiguration fibers;
};

/// The fibers through all copies (cell_copies.h): along their period they go on as one, across it each copy has fibers
/// and yarns of its own, in the order in which they lie side by side.
[[nodiscard]] ContinuedCell continued_cell(const micro::FiberMesh& mesh, const micro::FiberConfiguration& fibers,
                                           const micro::Periods& periods, const micro::Copies& copies);

/// Corners of the parallelogram that is one cell, in turn, at z = 0: its sides are where fibers start, and a period
/// farther on; of a strip, which has edges, as far as its fibers reach. Nothing where there is no period.
[[nodiscard]] std::optional<std::array<Vec3, 4>> cell_outline(const micro::FiberMesh& mesh,
                                                              const micro::FiberConfiguration& fibers,
                                                              const micro::Periods& periods);

}  // namespace trame::workflows
