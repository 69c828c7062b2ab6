#pragma once
/// \file
/// Strains of a yarn as a few numbers: their distributions over its volume.

#include "meso/strain/statistics.h"
#include "meso/strain/strain.h"

namespace trame::meso {

/// One yarn in one state B. Distributions are over the tetrahedra that are not flagged, weighted by reference volume.
struct YarnStrain {
  Index increment = 0;
  Index yarn = 0;
  Index n_tets = 0, n_flagged = 0, n_inverted = 0;  ///< all; of these without a strain; of these inside out
  Statistics axial, horizontal, vertical, gamma_max, det_F;
};

/// `increment`: number of state B. All NaN where the mesh is empty.
[[nodiscard]] YarnStrain summarise(Index increment, const YarnMesh& mesh, const StrainField& field);

}  // namespace trame::meso
