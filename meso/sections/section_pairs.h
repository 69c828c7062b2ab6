#pragma once
/// \file
/// Sections of a yarn in two states: the same material before and after, at equal distances along the yarn and where it
/// passes others.

#include <string>
#include <vector>

#include "meso/sections/sections.h"

namespace trame::meso {

/// The same section of a yarn in both states.
struct SectionPair {
  Section a, b;
  Section reference = {};                 ///< in the reference state; only where `compare` has filled it in
  std::string place = {};                 ///< see `places`; empty: one of the stations at equal distances
  std::vector<double> fiber_strain = {};  ///< axial strain of each of `a.fibers` from A to B, see `axial_strains`
  SideToCentre axial_strain = {};         ///< of these, over the section in A

  [[nodiscard]] bool is_station() const { return place.empty(); }
};

/// Stations in the middles of `n` pieces of equal length in A.
[[nodiscard]] std::vector<SectionPair> section_pairs(const micro::FiberMesh& fibers, const micro::Yarn& yarn,
                                                     const micro::FiberConfiguration& a,
                                                     const micro::FiberConfiguration& b, Index n);

/// A section at a fraction of the fibers' lengths.
[[nodiscard]] SectionPair section_pair(const micro::FiberMesh& fibers, const YarnSections& in_a,
                                       const YarnSections& in_b, double fraction);

/// Means over the stations that both states have.
struct SectionMeans {
  Index n_sections = 0;
  double height_a = 0, height_b = 0, width_a = 0, width_b = 0;  ///< m
  double fill_a = 0, fill_b = 0;
  double lenticular_a = 0, lenticular_b = 0;  ///< share that a lens fits better than an ellipse
  double axial_side = 0, axial_centre = 0;    ///< of the fibers' axial strain, see `side_to_centre`
  /// axial_side / axial_centre, so that sections where the centre hardly strains do not rule; NaN where the centre
  /// strains less than 1 % of the sides.
  double side_to_centre = 0;
};
/// Places are left out: they are not spread evenly.
[[nodiscard]] SectionMeans section_means(const std::vector<SectionPair>& pairs);

}  // namespace trame::meso
