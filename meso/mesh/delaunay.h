#pragma once
/// \file
/// Triangulations of points in the plane and in space (CGAL).

#include <array>
#include <vector>

#include "micro/core/types.h"

namespace trame::meso {

/// Counter-clockwise triangles of the Delaunay triangulation; empty where all points are on a line.
[[nodiscard]] std::vector<std::array<Index, 3>> delaunay_triangles(const std::vector<Vec2>& points);

/// Positive tetrahedra of the regular triangulation: Delaunay with the squared distance to point i reduced by
/// weights[i]. Empty where all points are in one plane.
[[nodiscard]] std::vector<std::array<Index, 4>> regular_tetrahedra(const std::vector<Vec3>& points,
                                                                   const std::vector<double>& weights);

}  // namespace trame::meso
