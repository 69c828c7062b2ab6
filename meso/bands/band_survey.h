#pragma once
/// \file
/// Shear bands on sections along a yarn, and the directions in which strain hangs together on them.

#include <array>
#include <memory>
#include <vector>

#include "meso/bands/orientation.h"
#include "meso/bands/shear_bands.h"
#include "meso/sections/section_pairs.h"
#include "meso/strain/strain.h"

namespace trame::meso {

/// What bands are looked for in; of strains with a sign, the size.
enum class BandComponent : std::uint8_t { axial, horizontal, vertical, horizontal_vertical, gamma_max };
inline constexpr std::array band_components = {BandComponent::axial, BandComponent::horizontal, BandComponent::vertical,
                                               BandComponent::horizontal_vertical, BandComponent::gamma_max};
/// Name as of the arrays in `yarns_vtk`.
[[nodiscard]] const char* text(BandComponent component);
/// Of every tetrahedron, with its sign; NaN where flagged.
[[nodiscard]] std::vector<double> values_of(const StrainField& field, BandComponent component);
/// Of every tetrahedron, ≥ 0; NaN where flagged.
[[nodiscard]] std::vector<double> magnitudes(const StrainField& field, BandComponent component);

/// Bands of one component on the cut of the mesh in A at one section.
struct SectionBands {
  Index station = 0;  ///< index of the section
  BandComponent component = BandComponent::gamma_max;
  std::vector<ShearBand> bands;        ///< largest first
  std::shared_ptr<const YarnCut> cut;  ///< that they lie on
  Eigen::ArrayXX<Index> region = {};   ///< of its pixels: k + 1 in bands[k], 0 elsewhere
};

/// For each section that is there and each component. `r_a`: node positions in A, m.
[[nodiscard]] std::vector<SectionBands> survey_bands(const YarnMesh& mesh, const StrainField& field,
                                                     const std::vector<Vec3>& r_a,
                                                     const std::vector<SectionPair>& sections,
                                                     const ShearBandOptions& options = {},
                                                     double pixels_per_distance = default_pixels_per_distance);

/// In which directions strains hang together: one array for each of `band_components`; NaN where there is nothing.
using Orientation = std::array<std::array<double, DirectionalCorrelation::n_directions>, band_components.size()>;

/// On the cuts of `bands` that belong to stations of `sections`, not to places.
[[nodiscard]] Orientation survey_orientation(const StrainField& field, const std::vector<SectionPair>& sections,
                                             const std::vector<SectionBands>& bands);

}  // namespace trame::meso
