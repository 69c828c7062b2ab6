#pragma once
/// \file
/// Rigid surfaces that bodies carry: planes, cylinders, spheres, boxes and meshes, as signed distances.

#include <cstdint>
#include <memory>

#include "micro/core/types.h"
#include "micro/rigid/triangle_mesh.h"

namespace trame::micro {

enum class SurfaceShape : std::uint8_t {
  plane,     ///< without end; fibers are on the side of its normal
  cylinder,  ///< about an axis; without end, or with rounded ends
  sphere,
  box,  ///< with edges along the axes of its body
  mesh  ///< closed, of triangles
};

/// A surface in the frame of its body. Fibers are outside of it, or `inside`: then cylinder, sphere and mesh are
/// hollow.
struct Surface {
  SurfaceShape shape = SurfaceShape::plane;
  Vec3 center = Vec3::Zero();      ///< a point of a plane; the origin of a mesh
  Vec3 direction = Vec3::UnitZ();  ///< unit: normal of a plane, axis of a cylinder; where a touching sphere goes
  double radius = 0;               ///< of a cylinder or sphere
  double half_length = 0;          ///< of a cylinder between the centres of its rounded ends; 0: without end
  Vec3 half_size = Vec3::Zero();   ///< of a box
  bool inside = false;
  std::shared_ptr<const TriangleMesh> mesh = {};
  double unit = 1;  ///< of a mesh: what 1 in its coordinates stands for

  bool operator==(const Surface& other) const;
};

/// A surface as it is seen from a point x: the signed distance φ(x), positive where fibers may be, and its derivatives
///   ∇φ = n,   ∇∇φ = κ A,   ∇∇∇φ·y = −κ² ((n·y) A + A y nᵀ + n yᵀA),
/// A the projector onto the directions in which parallel surfaces are curved. Of each shape that is all: seen from
/// anywhere it is a plane (κ = 0), a cylinder or a sphere; box and mesh have these as faces, edges and corners.
struct SurfaceView {
  double distance = 0;
  Vec3 normal = Vec3::UnitZ();
  double curvature = 0;
  Mat3 curved = Mat3::Zero();

  [[nodiscard]] Mat3 hessian() const { return curvature * curved; }
  [[nodiscard]] Mat3 hessian_change_along(const Vec3& y) const {
    const Vec3 ay = curved * y;
    return -curvature * curvature * (normal.dot(y) * curved + ay * normal.transpose() + normal * ay.transpose());
  }
  /// The same in the frame in which the body's axes are the columns of `rotation`.
  [[nodiscard]] SurfaceView turned(const Mat3& rotation) const {
    return {distance, rotation * normal, curvature, rotation * curved * rotation.transpose()};
  }
};
/// `x` in the frame of the body. On an axis or at a centre, from where all directions are alike, some normal.
[[nodiscard]] SurfaceView view(const Surface& surface, const Vec3& x);

/// Of `factor` times the size, as seen in another unit of length.
[[nodiscard]] Surface scaled(Surface surface, double factor);

/// The smallest radius of curvature that the surface turns towards fibers; 0 of edges, infinite of a plane.
[[nodiscard]] double smallest_radius_of_curvature(const Surface& surface);

}  // namespace trame::micro
