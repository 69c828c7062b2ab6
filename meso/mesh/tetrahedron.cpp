#include "meso/mesh/tetrahedron.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace trame::meso {

double volume(const Tet& x) { return (x[1] - x[0]).cross(x[2] - x[0]).dot(x[3] - x[0]) / 6.0; }

double circumradius(const Tet& x) {
  const Vec3 a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0];
  const Vec3 numerator = a.squaredNorm() * b.cross(c) + b.squaredNorm() * c.cross(a) + c.squaredNorm() * a.cross(b);
  const double denominator = 2 * std::abs(a.dot(b.cross(c)));
  return denominator > 0 ? numerator.norm() / denominator : std::numeric_limits<double>::infinity();
}

double circumradius(const Triangle& x) {
  const Vec2 a = x[1] - x[0], b = x[2] - x[0];
  const double twice_area = std::abs(a.x() * b.y() - a.y() * b.x());
  if (twice_area == 0) return std::numeric_limits<double>::infinity();
  return a.norm() * b.norm() * (b - a).norm() / (2 * twice_area);
}

std::array<double, 2> dihedral_range(const Tet& x) {
  double smallest = 180, largest = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) {
      // The edge from i to j, and the directions to the other two corners normal to it.
      const int k = i == 0 ? (j == 1 ? 2 : 1) : 0, l = 6 - i - j - k;
      const Vec3 edge = (x[j] - x[i]).normalized();
      const auto normal_to_edge = [&](const Vec3& v) -> Vec3 { return v - v.dot(edge) * edge; };
      const Vec3 p = normal_to_edge(x[k] - x[i]), q = normal_to_edge(x[l] - x[i]);
      const double angle = std::atan2(p.cross(q).norm(), p.dot(q)) * 180 / std::numbers::pi;
      smallest = std::min(smallest, angle);
      largest = std::max(largest, angle);
    }
  return {smallest, largest};
}

}  // namespace trame::meso
