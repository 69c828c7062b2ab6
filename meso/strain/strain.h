#pragma once
/// \file
/// Strain of a yarn as a continuum, one value per tetrahedron (deal.II, linear simplices).

#include <memory>
#include <vector>

#include "meso/mesh/yarn_mesh.h"

namespace trame::meso {

/// Deformation gradients F = ∂x/∂X on a yarn's mesh, X in the reference state.
class DeformationGradient {
 public:
  /// Keeps what depends on the reference state only.
  explicit DeformationGradient(const YarnMesh& mesh);
  ~DeformationGradient();
  DeformationGradient(DeformationGradient&&) noexcept;

  /// F of every tetrahedron; `r`: positions of the nodes of the fiber mesh, m. Nothing is thrown for inverted ones.
  [[nodiscard]] std::vector<Mat3> operator()(const std::vector<Vec3>& r) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Green-Lagrange strain E = ½(FᵀF − I).
[[nodiscard]] Mat3 green_lagrange(const Mat3& F);

/// Rows: axial, horizontal, vertical, right-handed and orthonormal. Axial is `axis`; vertical is the global z made
/// normal to it (the global y where the axis is along z).
[[nodiscard]] Mat3 yarn_frame(const Vec3& axis);

/// A tetrahedron whose smallest principal stretch against the reference state is less than this has collapsed: its
/// fibers lie all but in one plane, on the way to change places. What it does from there on has strains without bound
/// (E ~ 1/λ²), and a few of them outweigh a yarn: data/measurements/meso_collapse_limit.csv has figures.
inline constexpr double collapse_stretch = 0.2;

/// Why a tetrahedron has no strain.
enum TetFlag : Index {
  tet_good = 0,
  tet_inverted = 1,  ///< det F ≤ 0 in A or in B (or no axis): fibers have changed places
  tet_collapsed = 2  ///< det F > 0, but the smallest principal stretch is below `collapse_stretch` in A or in B
};

/// Strain between two states A and B, in A's geometry and in the yarn frame of A: index 0 axial, 1 horizontal, 2
/// vertical. NaN where flagged.
struct StrainField {
  std::vector<Mat3> E;                  ///< E_AB = ½(F_ABᵀ F_AB − I), F_AB = F_B F_A⁻¹
  std::vector<Vec3> principal;          ///< E_I ≥ E_II ≥ E_III
  std::vector<double> gamma_max;        ///< E_I − E_III
  std::vector<double> det_F;            ///< of F_AB
  std::vector<Index> flagged;           ///< a `TetFlag`
  Index n_flagged = 0, n_inverted = 0;  ///< of all; of one kind
};

/// `F_a`, `F_b`: of every tetrahedron of `mesh`, against the reference state. `tangent_a`: dr/ds at the nodes of the
/// fiber mesh in state A; the axis of a tetrahedron is the mean over its corners.
[[nodiscard]] StrainField strain_between(const YarnMesh& mesh, const std::vector<Mat3>& F_a,
                                         const std::vector<Mat3>& F_b, const std::vector<Vec3>& tangent_a);

}  // namespace trame::meso
