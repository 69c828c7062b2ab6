#pragma once
/// \file
/// What is found in yarns between two states beside their strains.

#include <array>
#include <vector>

#include "meso/analyse.h"
#include "meso/continuum.h"
#include "meso/orientation.h"
#include "meso/survey.h"

namespace trame::meso {

/// Of one yarn, whatever its mesh.
struct YarnFindings {
  Index yarn = 0;
  std::vector<SectionPair> sections;  ///< at equal distances along it
  YarnContinuum continuum;
};

/// One entry for each of `yarns`. `n_threads`: 0: all cores. Throws InputError for states that cannot be read.
[[nodiscard]] std::vector<YarnFindings> yarn_findings(const FiberStates& states, const std::vector<Index>& yarns,
                                                      const micro::FiberConfiguration& a,
                                                      const micro::FiberConfiguration& b, Index n_stations,
                                                      int n_threads = 0);

/// Shear bands on these sections, from the last state B of an analysis of the same yarns; `r_a`: node positions in its
/// state A, m.
[[nodiscard]] std::vector<std::vector<SectionBands>> yarn_bands(const Analysis& analysis,
                                                                const std::vector<YarnFindings>& findings,
                                                                const std::vector<Vec3>& r_a, int n_threads = 0);

/// In which directions strains on these sections hang together; one array for each of `band_components`.
using Orientation = std::array<std::array<double, DirectionalCorrelation::n_directions>, band_components.size()>;
[[nodiscard]] std::vector<Orientation> yarn_orientations(const Analysis& analysis,
                                                         const std::vector<YarnFindings>& findings,
                                                         const std::vector<Vec3>& r_a, int n_threads = 0);

}  // namespace trame::meso
