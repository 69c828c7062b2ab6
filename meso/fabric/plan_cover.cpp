#include "meso/fabric/plan_cover.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace trame::meso {

double plan_cover(const std::vector<Strip>& strips, const Vec2& corner, const Vec2& a, const Vec2& b, Index n_a,
                  Index n_b) {
  Eigen::Matrix2d parts;  // columns: the sides of one
  parts << a / n_a, b / n_b;
  const Eigen::Matrix2d to_parts = parts.inverse();
  std::vector<bool> covered(static_cast<std::size_t>(n_a) * static_cast<std::size_t>(n_b), false);
  for (const Strip& strip : strips) {
    const Vec2 p = to_parts * (strip.p - corner), q = to_parts * (strip.q - corner);
    const Vec2 reach = strip.half_width * to_parts.rowwise().norm();
    const auto first = [&](int d) { return std::max<Index>(0, Index(std::floor(std::min(p[d], q[d]) - reach[d]))); };
    const auto last = [&](int d, Index n) {
      return std::min<Index>(n - 1, Index(std::floor(std::max(p[d], q[d]) + reach[d])));
    };
    const Vec2 along = strip.q - strip.p;
    const double length2 = along.squaredNorm(), limit2 = strip.half_width * strip.half_width;
    for (Index i = first(0); i <= last(0, n_a); ++i)
      for (Index j = first(1); j <= last(1, n_b); ++j) {
        const Vec2 x = corner + parts * Vec2(i + 0.5, j + 0.5) - strip.p;
        const double t = length2 > 0 ? std::clamp(x.dot(along) / length2, 0.0, 1.0) : 0;
        if ((x - t * along).squaredNorm() <= limit2)
          covered[static_cast<std::size_t>(i) * static_cast<std::size_t>(n_b) + static_cast<std::size_t>(j)] = true;
      }
  }
  return double(std::count(covered.begin(), covered.end(), true)) / double(covered.size());
}

}  // namespace trame::meso
