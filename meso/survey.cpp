#include "meso/survey.h"

#include <cmath>
#include <utility>

#include "meso/strain_cut.h"

namespace trame::meso {

std::vector<SectionPair> section_pairs(const micro::FiberMesh& fibers, const micro::Yarn& yarn,
                                       const micro::FiberConfiguration& a, const micro::FiberConfiguration& b,
                                       Index n) {
  const YarnSections in_a(fibers, yarn, a), in_b(fibers, yarn, b);
  std::vector<SectionPair> pairs;
  for (Section& section : in_a.series(n)) {
    SectionPair& pair = pairs.emplace_back();
    pair.a = std::move(section);
    pair.b = in_b.at_fraction(pair.a.fraction);
    pair.axial_strain = side_to_centre(pair.a, axial_strains(fibers, pair.a, a.r, b.r));
  }
  return pairs;
}

SectionMeans section_means(const std::vector<SectionPair>& pairs) {
  SectionMeans sum;
  double side = 0, centre = 0;
  for (const SectionPair& pair : pairs) {
    if (pair.a.status != SectionStatus::ok || pair.b.status != SectionStatus::ok) continue;
    ++sum.n_sections;
    sum.height_a += pair.a.shape.height;
    sum.height_b += pair.b.shape.height;
    sum.width_a += pair.a.shape.width;
    sum.width_b += pair.b.shape.width;
    sum.fill_a += pair.a.fill;
    sum.fill_b += pair.b.fill;
    sum.lenticular_a += pair.a.shape.lenticular() ? 1 : 0;
    sum.lenticular_b += pair.b.shape.lenticular() ? 1 : 0;
    if (pair.axial_strain.n_side == 0 || pair.axial_strain.n_centre == 0) continue;
    side += pair.axial_strain.side;
    centre += pair.axial_strain.centre;
  }
  for (double* mean : {&sum.height_a, &sum.height_b, &sum.width_a, &sum.width_b, &sum.fill_a, &sum.fill_b,
                       &sum.lenticular_a, &sum.lenticular_b})
    *mean /= sum.n_sections;  // 0 / 0 is NaN
  sum.side_to_centre = std::abs(centre) > 0.01 * std::abs(side) ? side / centre : std::nan("");
  return sum;
}

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

std::vector<double> magnitudes(const StrainField& field, BandComponent component_of) {
  if (component_of == BandComponent::gamma_max) return field.gamma_max;
  const bool shear = component_of == BandComponent::horizontal_vertical;
  const int i = shear ? 1 : static_cast<int>(component_of), j = shear ? 2 : i;
  std::vector<double> values = component(field, i, j);
  for (double& x : values) x = std::abs(x);
  return values;
}

std::vector<SectionBands> survey_bands(const YarnMesh& mesh, const StrainField& field, const std::vector<Vec3>& r_a,
                                       const std::vector<SectionPair>& sections, const ShearBandOptions& options) {
  std::vector<SectionBands> result;
  if (mesh.tets.empty()) return result;
  for (std::size_t k = 0; k < sections.size(); ++k) {
    if (sections[k].a.status != SectionStatus::ok) continue;
    const YarnCut cut = cut_yarn(mesh, r_a, section_plane(sections[k].a));
    for (const BandComponent component : band_components)
      result.push_back(
          {static_cast<Index>(k), component, find_shear_bands(cut, magnitudes(field, component), options).bands});
  }
  return result;
}

}  // namespace trame::meso
