#pragma once
/// \file
/// All fields of one yarn between two states: what is written for ParaView and summed up in tables.

#include <vector>

#include "meso/nodal_strain.h"
#include "meso/shear_zones.h"
#include "meso/strain.h"

namespace trame::meso {

/// Empty where the yarn has no mesh.
struct YarnFields {
  StrainField strain;          ///< of the tetrahedra
  NodalStrain nodal;           ///< of the vertices
  std::vector<double> D2_min;  ///< D²_min / d² of the vertices, see `non_affine_residual`
  ShearZones zones;            ///< of γ_max
};

/// `F_a`, `F_b`: of the tetrahedra, against the reference state.
[[nodiscard]] YarnFields yarn_fields(const micro::FiberMesh& fibers, const YarnMesh& mesh, const std::vector<Mat3>& F_a,
                                     const std::vector<Mat3>& F_b, const micro::FiberConfiguration& a,
                                     const micro::FiberConfiguration& b);

}  // namespace trame::meso
