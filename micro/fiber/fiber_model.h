#pragma once
/// \file
/// What a fiber is made of, and how it is modelled.

#include <cstdint>
#include <string>

namespace trame::micro {

/// Linear elastic material, isotropic or transversely isotropic about the fiber axis (L).
struct Material {
  std::string name;
  double young_modulus_axial = 0;       ///< E_L, Pa
  double young_modulus_transverse = 0;  ///< E_T, Pa (= E_L when isotropic)
  double shear_modulus_axial = 0;       ///< G_LT, Pa (= E/2(1+ν) when isotropic)
  double poisson_ratio_axial = 0;       ///< ν_LT, −1 < ν < 0.5
  double poisson_ratio_transverse = 0;  ///< ν_TT
  double density = 0;                   ///< kg/m³; 0: not known

  bool operator==(const Material&) const = default;
};

/// Kinematics of a fiber: 9-dof enriched beam, or stretch-and-bend rod.
enum class FiberModel : std::uint8_t { enriched, rod };

enum class FiberEnd : std::uint8_t { start, end };

}  // namespace trame::micro
