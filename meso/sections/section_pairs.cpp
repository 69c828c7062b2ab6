#include "meso/sections/section_pairs.h"

#include <cmath>
#include <utility>

namespace trame::meso {
namespace {

SectionPair pair_of(const micro::FiberMesh& fibers, Section in_a, const YarnSections& a, const YarnSections& b) {
  SectionPair pair{.a = std::move(in_a), .b = {}};
  pair.b = b.at_fraction(pair.a.fraction);
  pair.fiber_strain = axial_strains(fibers, pair.a, a.fibers().r, b.fibers().r);
  pair.axial_strain = side_to_centre(pair.a, pair.fiber_strain);
  return pair;
}

}  // namespace

std::vector<SectionPair> section_pairs(const micro::FiberMesh& fibers, const micro::Yarn& yarn,
                                       const micro::FiberConfiguration& a, const micro::FiberConfiguration& b,
                                       Index n) {
  const YarnSections in_a(fibers, yarn, a), in_b(fibers, yarn, b);
  std::vector<SectionPair> pairs;
  for (Section& section : in_a.series(n)) pairs.push_back(pair_of(fibers, std::move(section), in_a, in_b));
  return pairs;
}

SectionPair section_pair(const micro::FiberMesh& fibers, const YarnSections& in_a, const YarnSections& in_b,
                         double fraction) {
  return pair_of(fibers, in_a.at_fraction(fraction), in_a, in_b);
}

SectionMeans section_means(const std::vector<SectionPair>& pairs) {
  SectionMeans sum;
  Index n_axial = 0;
  for (const SectionPair& pair : pairs) {
    if (!pair.is_station() || pair.a.status != SectionStatus::ok || pair.b.status != SectionStatus::ok) continue;
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
    ++n_axial;
    sum.axial_side += pair.axial_strain.side;
    sum.axial_centre += pair.axial_strain.centre;
  }
  for (double* mean : {&sum.height_a, &sum.height_b, &sum.width_a, &sum.width_b, &sum.fill_a, &sum.fill_b,
                       &sum.lenticular_a, &sum.lenticular_b})
    *mean /= sum.n_sections;  // 0 / 0 is NaN
  for (double* mean : {&sum.axial_side, &sum.axial_centre}) *mean /= n_axial;
  const bool has_ratio = std::abs(sum.axial_centre) > 0.01 * std::abs(sum.axial_side);
  sum.side_to_centre = has_ratio ? sum.axial_side / sum.axial_centre : std::nan("");
  return sum;
}

}  // namespace trame::meso
