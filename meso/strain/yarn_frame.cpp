#include <Eigen/Geometry>
#include <cmath>

#include "meso/strain/strain.h"

namespace trame::meso {

Mat3 yarn_frame(const Vec3& axis) {
  const Vec3 axial = axis.normalized();
  const Vec3 z = std::abs(axial.z()) < 1 - 1e-6 ? Vec3::UnitZ() : Vec3::UnitY();
  Mat3 frame;
  frame.row(0) = axial;
  frame.row(2) = (z - z.dot(axial) * axial).normalized();
  frame.row(1) = frame.row(2).transpose().cross(axial);
  return frame;
}

}  // namespace trame::meso
