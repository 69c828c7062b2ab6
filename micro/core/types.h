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

/// Precision of a matrix factor. Single halves its memory and more than halves its time; conjugate gradients in double
/// precision make up for it within a few iterations unless the matrix is very badly conditioned (long slender fibers
/// without contact). Automatic takes single for factors that do not fit into a cache, and double where single fails.
enum class FactorPrecision : std::uint8_t { automatic, single_precision, double_precision };

/// What stands for the matrix in conjugate gradients: its factor; or, of enriched beams, their factors one by one and
/// that of a matrix of rods; automatic takes what costs less.
enum class Preconditioner : std::uint8_t { automatic, factor, two_level };

}  // namespace trame
