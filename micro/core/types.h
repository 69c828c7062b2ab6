#pragma once
/// \file
/// Small vectors and matrices shared by every module.

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <limits>
#include <vector>

namespace trame {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// Index of a fiber, yarn, node, body …; containers stay below 2^31 entries.
using Index = std::int32_t;

}  // namespace trame
