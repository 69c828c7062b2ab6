#pragma once
/// \file
/// Closed surfaces of triangles for tests.

#include <memory>
#include <utility>
#include <vector>

#include "micro/rigid/triangle_mesh.h"

namespace trame::micro::test {

using Corners = std::vector<std::vector<Vec3>>;  ///< of each triangle

/// Twelve triangles.
inline Corners box_corners(const Vec3& low, const Vec3& high) {
  const auto at = [&](int i) {
    return Vec3((i & 1 ? high : low).x(), (i & 2 ? high : low).y(), (i & 4 ? high : low).z());
  };
  constexpr int quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  Corners corners;
  for (const auto& q : quads) {
    corners.push_back({at(q[0]), at(q[1]), at(q[2])});
    corners.push_back({at(q[0]), at(q[2]), at(q[3])});
  }
  return corners;
}

/// An octahedron whose faces are divided into four, `n` times, all corners on the sphere.
inline Corners sphere_corners(double radius, int n) {
  Corners corners;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      for (const double z : {-1.0, 1.0}) {
        std::vector<Vec3> t = {x * Vec3::UnitX(), y * Vec3::UnitY(), z * Vec3::UnitZ()};
        if (x * y * z < 0) std::swap(t[1], t[2]);
        corners.push_back(t);
      }
  for (int i = 0; i < n; ++i) {
    Corners finer;
    for (const auto& t : corners) {
      const Vec3 ab = (t[0] + t[1]).normalized(), bc = (t[1] + t[2]).normalized(), ca = (t[2] + t[0]).normalized();
      finer.push_back({t[0], ab, ca});
      finer.push_back({ab, t[1], bc});
      finer.push_back({ca, bc, t[2]});
      finer.push_back({ab, bc, ca});
    }
    corners = std::move(finer);
  }
  for (auto& t : corners)
    for (Vec3& p : t) p *= radius;
  return corners;
}

inline std::shared_ptr<const TriangleMesh> mesh_of(const Corners& corners) {
  return std::make_shared<const TriangleMesh>(joined(corners));
}

}  // namespace trame::micro::test
