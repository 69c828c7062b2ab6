#include "micro/weave/overlaps.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace trame::micro {

namespace {

struct Segment {
  Index fiber = 0;
  Vec3 from, to;
};

/// Nearest points of two segments (Ericson, Real-Time Collision Detection, 5.1.9).
std::pair<Vec3, Vec3> nearest_points(const Segment& p, const Segment& q) {
  const Vec3 u = p.to - p.from, v = q.to - q.from, w = p.from - q.from;
  const double a = u.squaredNorm(), e = v.squaredNorm(), b = u.dot(v), c = u.dot(w), f = v.dot(w);
  const double determinant = a * e - b * b;
  double s = determinant > 1e-12 * a * e ? std::clamp((b * f - c * e) / determinant, 0.0, 1.0) : 0;
  double t = (b * s + f) / e;
  if (t < 0 || t > 1) {
    t = std::clamp(t, 0.0, 1.0);
    s = std::clamp((b * t - c) / a, 0.0, 1.0);
  }
  return {p.from + s * u, q.from + t * v};
}

}  // namespace

std::optional<Overlap> deepest_overlap(const Assembly& assembly) {
  const FiberMesh& mesh = assembly.mesh;
  const auto is_free = [&](Index fiber) { return mesh.yarns[mesh.yarn_of_fiber[fiber]].family == YarnFamily::free; };
  std::vector<Segment> segments;
  double longest = 0, thickest = 0;
  bool any_free = false;
  for (Index f = 0; f < mesh.n_fibers(); ++f) {
    any_free = any_free || is_free(f);
    thickest = std::max(thickest, mesh.radius[f]);
    for (Index n = mesh.first_node[f]; n + 1 < mesh.first_node[f + 1]; ++n) {
      segments.push_back({f, assembly.configuration.r[n], assembly.configuration.r[n + 1]});
      longest = std::max(longest, (segments.back().to - segments.back().from).norm());
    }
  }
  if (!any_free) return std::nullopt;
  // Midpoints of two that touch are at most this far apart: in the same cell or in neighbouring ones.
  const double cell = longest + 2 * thickest;
  std::map<std::tuple<std::int64_t, std::int64_t, std::int64_t>, std::vector<std::size_t>> cells;
  const auto at = [&](const Segment& s, int axis) {
    return static_cast<std::int64_t>(std::floor(0.5 * (s.from[axis] + s.to[axis]) / cell));
  };
  std::optional<Overlap> deepest;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Segment& p = segments[i];
    const auto x = at(p, 0), y = at(p, 1), z = at(p, 2);
    for (int near = 0; near < 27; ++near) {
      const auto found = cells.find({x + near % 3 - 1, y + near / 3 % 3 - 1, z + near / 9 - 1});
      if (found == cells.end()) continue;
      for (const std::size_t j : found->second) {
        const Segment& q = segments[j];
        if (mesh.yarn_of_fiber[p.fiber] == mesh.yarn_of_fiber[q.fiber] || (!is_free(p.fiber) && !is_free(q.fiber)))
          continue;
        const auto [a, b] = nearest_points(p, q);
        const double depth = mesh.radius[p.fiber] + mesh.radius[q.fiber] - (a - b).norm();
        constexpr double worth_telling = 0.05;
        if (depth > worth_telling * std::min(mesh.radius[p.fiber], mesh.radius[q.fiber]) &&
            (!deepest || depth > deepest->depth))
          deepest = Overlap{q.fiber, p.fiber, depth, 0.5 * (a + b)};
      }
    }
    cells[{x, y, z}].push_back(i);
  }
  return deepest;
}

}  // namespace trame::micro
