#include "micro/rigid/surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace trame::micro {

namespace {

/// A sphere of this radius, or, with an axis, a cylinder: `from_center` is normal to that.
SurfaceView view_round(const Vec3& from_center, double radius, const Vec3* axis) {
  const double d = from_center.norm();
  SurfaceView seen;
  seen.distance = d - radius;
  if (d == 0) {
    if (axis) seen.normal = axis->unitOrthogonal();
    return seen;
  }
  seen.normal = from_center / d;
  seen.curvature = 1 / d;
  seen.curved = Mat3::Identity() - seen.normal * seen.normal.transpose();
  if (axis) seen.curved -= *axis * axis->transpose();
  return seen;
}

SurfaceView view_cylinder(const Surface& s, const Vec3& y) {
  const double along = s.direction.dot(y);
  if (s.half_length > 0 && std::abs(along) > s.half_length)
    return view_round(y - std::copysign(s.half_length, along) * s.direction, s.radius, nullptr);
  return view_round(y - along * s.direction, s.radius, &s.direction);
}

SurfaceView view_box(const Surface& s, const Vec3& y) {
  const Vec3 beyond = y.cwiseAbs() - s.half_size;
  SurfaceView seen;
  if ((beyond.array() <= 0).all()) {  // inside: the nearest face
    int face = 0;
    seen.distance = beyond.maxCoeff(&face);
    seen.normal = std::copysign(1.0, y[face]) * Vec3::Unit(face);
    return seen;
  }
  Vec3 out = Vec3::Zero();
  for (int d = 0; d < 3; ++d)
    if (beyond[d] > 0) {
      out[d] = std::copysign(beyond[d], y[d]);
      seen.curved(d, d) = 1;
    }
  seen.distance = out.norm();
  seen.normal = out / seen.distance;
  seen.curved -= seen.normal * seen.normal.transpose();
  // Nothing is curved beside a face.
  if ((beyond.array() > 0).count() > 1) seen.curvature = 1 / seen.distance;
  return seen;
}

SurfaceView view_mesh(const Surface& s, const Vec3& y) {
  const TriangleMesh::Nearest nearest = s.mesh->nearest(y / s.unit);
  const Vec3 away = y - s.unit * nearest.foot;
  const double d = away.norm(), side = away.dot(nearest.normal) < 0 ? -1 : 1;
  if (nearest.feature == TriangleMesh::Feature::face || d == 0)
    return {away.dot(nearest.normal), nearest.normal, 0, Mat3::Zero()};
  SurfaceView seen{side * d, side / d * away, side / d, Mat3::Identity()};
  seen.curved -= seen.normal * seen.normal.transpose() + nearest.edge * nearest.edge.transpose();
  return seen;
}

}  // namespace

bool Surface::operator==(const Surface& other) const {
  const auto numbers = [](const Surface& s) {
    return std::tie(s.shape, s.center, s.direction, s.radius, s.half_length, s.half_size, s.inside, s.unit);
  };
  return numbers(*this) == numbers(other) && (mesh && other.mesh ? *mesh == *other.mesh : mesh == other.mesh);
}

SurfaceView view(const Surface& s, const Vec3& x) {
  const Vec3 y = x - s.center;
  SurfaceView seen;
  switch (s.shape) {
    case SurfaceShape::plane: seen = {s.direction.dot(y), s.direction, 0, Mat3::Zero()}; break;
    case SurfaceShape::cylinder: seen = view_cylinder(s, y); break;
    case SurfaceShape::sphere: seen = view_round(y, s.radius, nullptr); break;
    case SurfaceShape::box: seen = view_box(s, y); break;
    case SurfaceShape::mesh: seen = view_mesh(s, y); break;
  }
  if (s.inside) {
    seen.distance = -seen.distance;
    seen.normal = -seen.normal;
    seen.curvature = -seen.curvature;
  }
  return seen;
}

Surface scaled(Surface s, double factor) {
  s.center *= factor;
  s.half_size *= factor;
  for (double* length : {&s.radius, &s.half_length, &s.unit}) *length *= factor;
  return s;
}

double smallest_radius_of_curvature(const Surface& s) {
  switch (s.shape) {
    case SurfaceShape::plane: break;
    case SurfaceShape::box:
    case SurfaceShape::mesh: return 0;
    case SurfaceShape::cylinder:
    case SurfaceShape::sphere: return s.inside ? std::numeric_limits<double>::infinity() : s.radius;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace trame::micro
