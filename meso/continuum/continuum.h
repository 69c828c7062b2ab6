#pragma once
/// \file
/// Is a yarn a continuum between two states? How far its fibers move off local affine maps, how many change neighbours,
/// how much of its mesh turns inside out, and how much its strain depends on the mesh: one row per yarn.

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "meso/continuum/non_affine.h"
#include "meso/mesh/yarn_mesh.h"
#include "meso/sections/section_pairs.h"
#include "meso/strain/strain.h"

namespace trame::meso {

struct ContinuumOptions {
  Neighbourhood neighbourhood = {};
  /// Two fibers are neighbours in a section of A if an edge of its Delaunay triangulation joins them that is no longer
  /// than this (fiber distances): less than √2, since the diagonals of a square come and go with round-off.
  double longest_bond = 1.25;
  Index n_slabs = 20;  ///< along the yarn, see `mesh_difference`
};

/// Upper bounds on the members of `YarnContinuum` of the same names.
struct ContinuumLimits {
  double non_affine_95 = 0, non_affine_share = 0, exchanged = 0, flagged = 0, mesh_difference = 0;
};

/// A continuum fiber by fiber: 95 % of the fibers stay within a quarter of the fiber distance of their place (half of
/// it takes a fiber into the gap between two neighbours), disorder makes at most a quarter of the squared local strain
/// (in a hexagonal packing, a share of 0.6 is nothing but disorder), nearly all keep their neighbours and the mesh its
/// orientation, and the strain does not depend on how the yarn is meshed by more than a tenth.
inline constexpr ContinuumLimits fiber_by_fiber{
    .non_affine_95 = 0.25, .non_affine_share = 0.3, .exchanged = 0.05, .flagged = 0.01, .mesh_difference = 0.1};

/// A continuum on average over sections: fibers may trade places with their neighbours but stay within a fiber distance
/// of where they belong, most neighbours and nine tenths of the mesh survive, and the mean strain is known to a
/// quarter. Disorder is what an average is taken of, so its share is not limited.
inline constexpr ContinuumLimits on_average{.non_affine_95 = 1.0,
                                            .non_affine_share = std::numeric_limits<double>::infinity(),
                                            .exchanged = 0.3,
                                            .flagged = 0.1,
                                            .mesh_difference = 0.25};

enum class ContinuumVerdict : std::uint8_t { holds, holds_on_average, does_not_hold, too_few_fibers, nothing_to_judge };

[[nodiscard]] std::string_view text(ContinuumVerdict verdict);

/// One yarn between states A and B. NaN where there is nothing to measure: everything for fewer than three fibers, and
/// what needs a mesh where there is none.
struct YarnContinuum {
  Index yarn = 0;
  MeshStatus mesh_status = MeshStatus::ok;          ///< of the Delaunay mesh
  Index n_nodes = 0;                                ///< with enough neighbours for D²_min
  double D2_mean = 0, D2_median = 0, D2_95 = 0;     ///< D²_min / d², see `non_affine_residual`
  double non_affine_median = 0, non_affine_95 = 0;  ///< roots of these: in fiber distances
  double exchanged = 0;                             ///< see `exchanged_neighbours`
  double flagged = 0;           ///< share of the Delaunay mesh's tetrahedra that are inside out in A or B
  double typical_strain = 0;    ///< median of √(E:E) over the volume of the Delaunay mesh
  double non_affine_share = 0;  ///< non_affine_median / typical_strain: both are relative motion over a fiber distance
  double mesh_difference = 0;   ///< see `mesh_difference`; NaN also where the yarn cannot be swept
  ContinuumVerdict verdict = ContinuumVerdict::too_few_fibers;
};

/// Share of the pairs of neighbours at the stations in A that no edge of the Delaunay triangulation of the same section
/// in B joins: another fiber has come between them. `longest_bond`: of neighbours in A, m. Pairs of which one is
/// missing in B are left out; NaN without pairs.
[[nodiscard]] double exchanged_neighbours(const std::vector<SectionPair>& sections, double longest_bond);

/// Mean strain E of slabs of equal length along the yarn, weighted by reference volume, from two meshes of it: the root
/// mean square of their difference over that of their mean. A tenth of each slab, where E is largest, is left out:
/// tetrahedra that are all but inside out have strains without bound, and one of them outweighs the slab. NaN without a
/// common slab.
[[nodiscard]] double mesh_difference(const micro::FiberMesh& fibers, const YarnMesh& mesh_1, const StrainField& field_1,
                                     const YarnMesh& mesh_2, const StrainField& field_2, Index n_slabs);

/// The stronger of the two statements whose limits a row keeps. What is NaN is not held against it, but without a mesh
/// there is nothing to judge.
[[nodiscard]] ContinuumVerdict verdict(const YarnContinuum& row);

/// The verdict in plain words, with the measures that keep it from being stronger and their limits.
[[nodiscard]] std::string explanation(const YarnContinuum& row);

/// Strains of a yarn on one of its meshes; no mesh, no field.
struct StrainOnMesh {
  const YarnMesh& mesh;
  const StrainField* field = nullptr;
};

/// What is known of a yarn between two states already.
struct ContinuumEvidence {
  const micro::FiberMesh& fibers;
  Index yarn = 0;
  double fiber_distance = 0;          ///< in A, m
  const std::vector<double>& D2_min;  ///< of all nodes of the yarn, see `non_affine_residual`
  const std::vector<SectionPair>& sections;
  StrainOnMesh delaunay, swept;
};

/// Throws InputError for options out of range.
void check(const ContinuumOptions& options);

[[nodiscard]] YarnContinuum yarn_continuum(const ContinuumEvidence& evidence, const ContinuumOptions& options = {});

}  // namespace trame::meso
