#include "meso/sections/places.h"

#include <algorithm>
#include <cstddef>
#include <optional>

#include "meso/sections/sections.h"

namespace trame::meso {
namespace {

/// Means of the yarn's fibers at equal steps of their lengths.
std::vector<Vec3> mean_curve(const micro::FiberMesh& mesh, const micro::FiberConfiguration& fibers, Index yarn) {
  constexpr int n = 80;
  const YarnSections sections(mesh, mesh.yarns[yarn], fibers);
  std::vector<Vec3> curve;
  for (int i = 0; i <= n; ++i) curve.push_back(sections.mean_position(i / double(n)));
  return curve;
}

struct Crossing {
  double fraction = 0;  ///< along the first curve
  bool above = false;   ///< the first is
};

/// Where two curves cross seen from above.
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
      return Crossing{(double(i) + t) / double(p.size() - 1), z_p > z_q};
    }
  return std::nullopt;
}

/// The crossings, and half-way between neighbours.
std::vector<Place> with_middles(const std::vector<Place>& crossings) {
  std::vector<Place> result;
  for (const Place& place : crossings) {
    if (!result.empty()) result.push_back({0.5 * (result.back().fraction + place.fraction), "between"});
    result.push_back(place);
  }
  return result;
}

}  // namespace

std::vector<Place> places(const micro::FiberMesh& mesh, const micro::FiberConfiguration& fibers, Index yarn,
                          std::size_t most) {
  const micro::YarnFamily family = mesh.yarns[yarn].family;
  if (family == micro::YarnFamily::free) return {};
  const std::vector<Vec3> curve = mean_curve(mesh, fibers, yarn);
  std::vector<Place> crossings;
  for (Index other = 0; other < static_cast<Index>(mesh.yarns.size()); ++other) {
    if (mesh.yarns[other].family == family || mesh.yarns[other].family == micro::YarnFamily::free) continue;
    if (const auto found = crossing(curve, mean_curve(mesh, fibers, other)))
      crossings.push_back({found->fraction, (found->above ? "over " : "under ") + mesh.yarns[other].name});
  }
  if (crossings.empty()) return {};
  std::sort(crossings.begin(), crossings.end(), [](const Place& p, const Place& q) { return p.fraction < q.fraction; });
  std::vector<Place> all = with_middles(crossings);
  if (all.size() <= most) return all;
  const auto first = all.begin() + static_cast<std::ptrdiff_t>((all.size() - most) / 2);
  return {first, first + static_cast<std::ptrdiff_t>(most)};
}

}  // namespace trame::meso
