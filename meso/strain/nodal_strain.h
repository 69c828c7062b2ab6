#pragma once
/// \file
/// Strains recovered at the vertices of a yarn's mesh, from those of the tetrahedra around each.

#include <vector>

#include "meso/strain/strain.h"

namespace trame::meso {

/// One entry per vertex of the mesh, in the yarn frame of A; NaN where all tetrahedra around are flagged.
struct NodalStrain {
  std::vector<Mat3> E;
  std::vector<Vec3> principal;    ///< of E, largest first
  std::vector<double> gamma_max;  ///< E_I − E_III: that of the mean strain, not the mean of the tetrahedra's
  std::vector<double> det_F;
  std::vector<Index> flagged;  ///< 1: no strain
};

/// Means over the tetrahedra around a vertex that are not flagged, weighted by reference volume. Linear fields come out
/// exact where the tetrahedra lie evenly around the vertex, and on the surface with the value half a mesh cell inside.
/// A linear fit to the patch (Zienkiewicz & Zhu, Int. J. Numer. Meth. Eng. 33, 1992) would be exact there too, but a
/// yarn's surface is where fibers are least regular: on woven patches it differs three to four times as much between
/// the Delaunay and the swept mesh (data/measurements/meso_nodal_recovery.csv), so the mean it is.
[[nodiscard]] NodalStrain nodal_strain(const YarnMesh& mesh, const StrainField& field);

}  // namespace trame::meso
