#include "micro/rigid/surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

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

}  // namespace

SurfaceView view(const Surface& s, const Vec3& x) {
  const Vec3 y = x - s.center;
  SurfaceView seen;
  switch (s.shape) {
    case SurfaceShape::plane: seen = {s.direction.dot(y), s.direction, 0, Mat3::Zero()}; break;
    case SurfaceShape::cylinder: seen = view_cylinder(s, y); break;
    case SurfaceShape::sphere: seen = view_round(y, s.radius, nullptr); break;
    case SurfaceShape::box: seen = view_box(s, y); break;
  }
  if (s.inside) {
    seen.distance = -seen.distance;
    seen.normal = -seen.normal;
    seen.curvature = -seen.curvature;
  }
  return seen;
}

double smallest_radius_of_curvature(const Surface& s) {
  switch (s.shape) {
    case SurfaceShape::plane: break;
    case SurfaceShape::box: return 0;
    case SurfaceShape::cylinder:
    case SurfaceShape::sphere: return s.inside ? std::numeric_limits<double>::infinity() : s.radius;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace trame::micro
