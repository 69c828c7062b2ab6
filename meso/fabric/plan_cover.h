#pragma once
/// \file
/// How much of a piece of a plane strips cover.

#include <vector>

#include "micro/core/types.h"

namespace trame::meso {

/// All points within `half_width` of the straight line from p to q.
struct Strip {
  Vec2 p = Vec2::Zero(), q = Vec2::Zero();
  double half_width = 0;
};

/// Share of the parallelogram corner + u a + v b, 0 ≤ u, v ≤ 1, that the strips cover, by n_a × n_b points in the
/// middles of equal parts of it: what lies along a strip's edge is known to a part.
[[nodiscard]] double plan_cover(const std::vector<Strip>& strips, const Vec2& corner, const Vec2& a, const Vec2& b,
                                Index n_a, Index n_b);

}  // namespace trame::meso
