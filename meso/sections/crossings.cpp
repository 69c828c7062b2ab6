#include "meso/sections/crossings.h"

#include <algorithm>
#include <cstddef>

#include "meso/sections/sections.h"

namespace trame::meso {

std::vector<Vec3> mean_curve(const micro::FiberMesh& mesh, const micro::FiberConfiguration& fibers, Index yarn) {
  constexpr int n = 80;
  const YarnSections sections(mesh, mesh.yarns[yarn], fibers);
  std::vector<Vec3> curve;
  for (int i = 0; i <= n; ++i) curve.push_back(sections.mean_position(i / double(n)));
  return curve;
}

std::optional<Crossing> crossing(const std::vector<Vec3>& p, const std::vector<Vec3>& q) {
  for (std::size_t i = 0; i + 1 < p.size(); ++i)
    for (std::size_t j = 0; j + 1 < q.size(); ++j) {
      const Vec2 along = (p[i + 1] - p[i]).head<2>(), across = (q[j + 1] - q[j]).head<2>();
      const Vec2 apart = (q[j] - p[i]).head<2>();
      const double determinant = along.x() * across.y() - along.y() * across.x();
      if (determinant == 0) continue;
      const double t = (apart.x() * across.y() - apart.y() * across.x()) / determinant;
      const double u = (apart.x() * along.y() - apart.y() * along.x()) / determinant;
      // Round-off must not let a crossing at a common end of two pieces slip between them.
      constexpr double slack = 1e-9;
      if (std::min(t, u) < -slack || std::max(t, u) > 1 + slack) continue;
      const double z_p = p[i].z() + t * (p[i + 1] - p[i]).z(), z_q = q[j].z() + u * (q[j + 1] - q[j]).z();
      return Crossing{(double(i) + t) / double(p.size() - 1), (double(j) + u) / double(q.size() - 1),
                      p[i].head<2>() + t * along, z_p > z_q};
    }
  return std::nullopt;
}

}  // namespace trame::meso
