#pragma once
/// \file
/// Measures of triangles and tetrahedra.

#include <array>

#include "micro/core/types.h"

namespace trame::meso {

using Tet = std::array<Vec3, 4>;
using Triangle = std::array<Vec2, 3>;

/// Signed volume: positive where the fourth corner is on the side to which the first three turn counter-clockwise.
[[nodiscard]] double volume(const Tet& x);

/// Radius of the sphere through the corners; infinity for a flat tetrahedron.
[[nodiscard]] double circumradius(const Tet& x);

/// Radius of the circle through the corners; infinity for a flat triangle.
[[nodiscard]] double circumradius(const Triangle& x);

/// Smallest and largest angle between two faces, degrees.
[[nodiscard]] std::array<double, 2> dihedral_range(const Tet& x);

}  // namespace trame::meso
