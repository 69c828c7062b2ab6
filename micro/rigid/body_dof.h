#pragma once
/// \file
/// Degrees of freedom of a rigid body.

#include <cstdint>

namespace trame::micro {

/// Translation along, or rotation about, a global axis.
enum class BodyDof : std::uint8_t { x, y, z, rx, ry, rz };

}  // namespace trame::micro
