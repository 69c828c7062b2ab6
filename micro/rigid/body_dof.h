#pragma once
/// \file
/// Degrees of freedom of a rigid body.

#include <array>
#include <cstdint>
#include <string_view>

namespace trame::micro {

/// Translation along, or rotation about, a global axis.
enum class BodyDof : std::uint8_t { x, y, z, rx, ry, rz };

/// What scenes and tables call them, in their order.
inline constexpr std::array<std::string_view, 6> dof_names = {"x", "y", "z", "rx", "ry", "rz"};
inline constexpr int n_body_dofs = dof_names.size();
[[nodiscard]] constexpr std::string_view dof_name(BodyDof dof) { return dof_names[static_cast<std::size_t>(dof)]; }

}  // namespace trame::micro
