#include "meso/sections/outline.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/convex_hull_2.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace trame::meso {
namespace {

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// h(x) of a convex polygon, also at its corners and at upright edges.
double height_at(const std::vector<Vec2>& outline, double x) {
  double top = -std::numeric_limits<double>::infinity(), bottom = -top;
  const auto include = [&](double y) {
    top = std::max(top, y);
    bottom = std::min(bottom, y);
  };
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec2 &a = outline[i], &b = outline[(i + 1) % outline.size()];
    if (x < std::min(a.x(), b.x()) || x > std::max(a.x(), b.x())) continue;
    if (a.x() == x) include(a.y());
    if (b.x() == x) include(b.y());
    if (a.x() != x && b.x() != x) include(a.y() + (b.y() - a.y()) * (x - a.x()) / (b.x() - a.x()));
  }
  return top - bottom;
}

/// h(x) of a lens about x = 0 with points at the ends of its longer extent.
double lens_height(double width, double thickness, double x) {
  const double chord = std::max(width, thickness), sagitta = 0.5 * std::min(width, thickness);
  const double radius = chord * chord / (8 * sagitta) + 0.5 * sagitta, depth = radius - sagitta;
  const auto leg = [&](double other) { return std::sqrt(std::max(radius * radius - other * other, 0.0)); };
  return width >= thickness ? 2 * (leg(x) - depth) : 2 * leg(std::abs(x) + depth);
}

double ellipse_height(double width, double thickness, double x) {
  return thickness * std::sqrt(std::max(1 - 4 * x * x / (width * width), 0.0));
}

}  // namespace

std::vector<Vec2> convex_hull(const std::vector<Vec2>& points) {
  using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_2;
  std::vector<Point> all, corners;
  for (const Vec2& x : points) all.emplace_back(x.x(), x.y());
  CGAL::convex_hull_2(all.begin(), all.end(), std::back_inserter(corners));
  std::vector<Vec2> hull;
  for (const Point& x : corners) hull.emplace_back(x.x(), x.y());
  return hull;
}

OutlineShape outline_shape(const std::vector<Vec2>& outline) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  if (outline.size() < 3) return {nan, nan, nan, nan, nan, nan};
  OutlineShape shape;
  Vec2 lowest = outline[0], highest = outline[0];
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec2& next = outline[(i + 1) % outline.size()];
    shape.area += 0.5 * cross(outline[i] - outline[0], next - outline[0]);
    lowest = lowest.cwiseMin(next);
    highest = highest.cwiseMax(next);
  }
  shape.area = std::abs(shape.area);
  shape.width = highest.x() - lowest.x();
  shape.height = highest.y() - lowest.y();
  // h(x) is linear between corners.
  for (const Vec2& corner : outline) shape.thickness = std::max(shape.thickness, height_at(outline, corner.x()));
  constexpr int n = 200;  // midpoints
  double lens = 0, ellipse = 0, squares = 0;
  for (int i = 0; i < n; ++i) {
    const double x = ((i + 0.5) / n - 0.5) * shape.width, h = height_at(outline, lowest.x() + 0.5 * shape.width + x);
    lens += std::pow(h - lens_height(shape.width, shape.thickness, x), 2);
    ellipse += std::pow(h - ellipse_height(shape.width, shape.thickness, x), 2);
    squares += h * h;
  }
  shape.lens_residual = std::sqrt(lens / squares);
  shape.ellipse_residual = std::sqrt(ellipse / squares);
  return shape;
}

}  // namespace trame::meso
