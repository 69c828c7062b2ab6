#pragma once
/// \file
/// What sections along a yarn show between two states: shapes, axial strain at the sides and in the centre, shear
/// bands.

#include <array>
#include <vector>

#include "meso/sections.h"
#include "meso/shear_bands.h"
#include "meso/strain.h"

namespace trame::meso {

/// The same section of a yarn in both states: the middle of one of `n` pieces of equal length in A.
struct SectionPair {
  Section a, b;
  SideToCentre axial_strain;  ///< of the fibers from A to B, over the section in A
};

[[nodiscard]] std::vector<SectionPair> section_pairs(const micro::FiberMesh& fibers, const micro::Yarn& yarn,
                                                     const micro::FiberConfiguration& a,
                                                     const micro::FiberConfiguration& b, Index n);

/// Means over the sections that both states have.
struct SectionMeans {
  Index n_sections = 0;
  double height_a = 0, height_b = 0, width_a = 0, width_b = 0;  ///< m
  double fill_a = 0, fill_b = 0;
  double lenticular_a = 0, lenticular_b = 0;  ///< share that a lens fits better than an ellipse
  /// Mean side strain over mean centre strain, so that sections where the centre hardly strains do not rule; NaN where
  /// the centre strains less than 1 % of the sides.
  double side_to_centre = 0;
};
[[nodiscard]] SectionMeans section_means(const std::vector<SectionPair>& pairs);

/// What bands are looked for in; of strains with a sign, the size.
enum class BandComponent : std::uint8_t { axial, horizontal, vertical, horizontal_vertical, gamma_max };
inline constexpr std::array band_components = {BandComponent::axial, BandComponent::horizontal, BandComponent::vertical,
                                               BandComponent::horizontal_vertical, BandComponent::gamma_max};
/// Name as of the arrays in `yarns_vtk`.
[[nodiscard]] const char* text(BandComponent component);
/// Of every tetrahedron, ≥ 0; NaN where flagged.
[[nodiscard]] std::vector<double> magnitudes(const StrainField& field, BandComponent component);

/// Bands of one component on the cut of the mesh in A at one section.
struct SectionBands {
  Index station = 0;  ///< index of the section
  BandComponent component = BandComponent::gamma_max;
  std::vector<ShearBand> bands;  ///< largest first
};

/// For each section that is there and each component. `r_a`: node positions in A, m.
[[nodiscard]] std::vector<SectionBands> survey_bands(const YarnMesh& mesh, const StrainField& field,
                                                     const std::vector<Vec3>& r_a,
                                                     const std::vector<SectionPair>& sections,
                                                     const ShearBandOptions& options = {});

}  // namespace trame::meso
