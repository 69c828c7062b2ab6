#pragma once
/// \file
/// Convex outlines of sections: hull, extents, and whether a lens or an ellipse describes them better.

#include <algorithm>
#include <vector>

#include "micro/core/types.h"

namespace trame::meso {

/// Corners of the convex hull (CGAL), counter-clockwise; fewer than three where all points are on a line.
[[nodiscard]] std::vector<Vec2> convex_hull(const std::vector<Vec2>& points);

/// Measures of a convex outline. A lens is two circular arcs of equal radius that meet at the ends of the longer one of
/// width and thickness. Lens and ellipse are given the outline's width and thickness; residuals compare heights h(x),
/// top to bottom: √(∫(h − h_fit)² dx / ∫h² dx). All NaN where there is no outline.
struct OutlineShape {
  double area = 0;               ///< m²
  double width = 0, height = 0;  ///< horizontal and vertical extent, m
  double thickness = 0;          ///< largest h(x): less than the height where the outline leans, m
  double lens_residual = 0, ellipse_residual = 0;

  /// About as thick as wide: lens and ellipse are then all but the same circle, and which is nearer means nothing.
  [[nodiscard]] bool is_round() const { return std::min(width, thickness) > 0.75 * std::max(width, thickness); }
  [[nodiscard]] bool lenticular() const { return !is_round() && lens_residual < ellipse_residual; }
  [[nodiscard]] const char* name() const { return is_round() ? "round" : lenticular() ? "lens" : "ellipse"; }
};

/// `outline`: corners (horizontal, vertical) of a convex polygon in order, m.
[[nodiscard]] OutlineShape outline_shape(const std::vector<Vec2>& outline);

}  // namespace trame::meso
