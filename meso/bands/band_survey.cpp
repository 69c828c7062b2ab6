#include "meso/bands/band_survey.h"

#include <cmath>
#include <utility>

#include "meso/bands/strain_cut.h"

namespace trame::meso {

const char* text(BandComponent component) {
  switch (component) {
    case BandComponent::axial: return "E_axial";
    case BandComponent::horizontal: return "E_horizontal";
    case BandComponent::vertical: return "E_vertical";
    case BandComponent::horizontal_vertical: return "E_horizontal_vertical";
    case BandComponent::gamma_max: return "gamma_max";
  }
  return "";
}

std::vector<double> values_of(const StrainField& field, BandComponent component_of) {
  if (component_of == BandComponent::gamma_max) return field.gamma_max;
  const bool shear = component_of == BandComponent::horizontal_vertical;
  const int i = shear ? 1 : static_cast<int>(component_of), j = shear ? 2 : i;
  return component(field, i, j);
}

std::vector<double> magnitudes(const StrainField& field, BandComponent component) {
  std::vector<double> values = values_of(field, component);
  for (double& x : values) x = std::abs(x);
  return values;
}

std::vector<SectionBands> survey_bands(const YarnMesh& mesh, const StrainField& field, const std::vector<Vec3>& r_a,
                                       const std::vector<SectionPair>& sections, const ShearBandOptions& options,
                                       double pixels_per_distance) {
  std::vector<SectionBands> result;
  if (mesh.tets.empty()) return result;
  for (std::size_t k = 0; k < sections.size(); ++k) {
    if (sections[k].a.status != SectionStatus::ok) continue;
    const auto cut =
        std::make_shared<const YarnCut>(cut_yarn(mesh, r_a, section_plane(sections[k].a), pixels_per_distance));
    for (const BandComponent component : band_components) {
      ShearBands found = find_shear_bands(*cut, magnitudes(field, component), options);
      result.push_back({static_cast<Index>(k), component, std::move(found.bands), cut, std::move(found.region)});
    }
  }
  return result;
}

Orientation survey_orientation(const StrainField& field, const std::vector<SectionPair>& sections,
                               const std::vector<SectionBands>& bands) {
  std::array<DirectionalCorrelation, band_components.size()> correlations;
  for (const SectionBands& on : bands)
    if (sections[on.station].is_station())
      correlations[static_cast<std::size_t>(on.component)].add(sample(*on.cut, magnitudes(field, on.component)),
                                                               on.cut->fiber_distance / on.cut->pixel);
  Orientation result;
  for (std::size_t k = 0; k < result.size(); ++k) result[k] = correlations[k].values();
  return result;
}

}  // namespace trame::meso
