#pragma once
/// \file
/// Fibers that lie in each other before anything runs.

#include <optional>

#include "micro/weave/flat_start.h"

namespace trame::micro {

struct Overlap {
  Index fiber_a = 0, fiber_b = 0;
  double depth = 0;  ///< R_a + R_b less the distance of the axes
  Vec3 place = Vec3::Zero();
};

/// The deepest overlap of two fibers of different yarns, bundles or single fibers, deeper than 5 % of a radius; but for
/// yarns of the weave among each other: those that cross shall overlap, and neighbours are checked as a scene is read.
/// Fibers are taken as polygons through their nodes.
[[nodiscard]] std::optional<Overlap> deepest_overlap(const Assembly& assembly);

}  // namespace trame::micro
