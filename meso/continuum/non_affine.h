#pragma once
/// \file
/// How far the fibers of a yarn move off the best affine map of their neighbourhood.

#include <vector>

#include "micro/fiber/fiber_mesh.h"

namespace trame::meso {

/// Neighbours of a node: the nodes of the same yarn that are at most so far away in state A.
struct Neighbourhood {
  /// Across the yarn, in fiber distances: between the first (1) and second (√3) neighbours of a hexagonal packing.
  double section_radius = 1.5;
  /// Along the yarn, in node spacings: the nodes before, beside and after.
  double axial_radius = 1.5;
};

/// D²_min / d² of every node of a yarn between states A and B, in the order of nodes; d is the fiber distance in A.
///
///     D²_min = min over F of (1/n) Σ_j |Δx_j^B − F Δx_j^A|²        j: the n neighbours, Δ: from the node
///
/// Falk & Langer, Phys. Rev. E 57, 7192 (1998), here as a mean over the neighbours so that nodes on the outline compare
/// with those inside. NaN for nodes with fewer than 6 neighbours, which almost any map would fit. Nodes of the yarn's
/// mesh would be neighbours too, but which diagonals it takes between layers of nodes is a matter of chance.
[[nodiscard]] std::vector<double> non_affine_residual(const micro::FiberMesh& mesh, const micro::Yarn& yarn,
                                                      const std::vector<Vec3>& r_a, const std::vector<Vec3>& r_b,
                                                      const Neighbourhood& neighbourhood = {});

}  // namespace trame::meso
