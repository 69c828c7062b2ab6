#pragma once
/// \file
/// What a user of the results has to know, in sentences.

#include <optional>
#include <string>
#include <vector>

#include "micro/simulate.h"
#include "workflows/accuracy/estimate.h"

namespace trame::workflows {

/// Above which share of the results an estimated error is worth a warning.
inline constexpr double estimate_to_warn_of = 0.1;
/// Overlap of two fibers, in radii, that is worth one whatever the energy in it.
inline constexpr double penetration_to_warn_of = 0.2;

/// The warnings of the simulation, and those that its results call for: crossings that do not agree with the weave,
/// fibers that lie deep in each other, an estimated error above `estimate_to_warn_of` with its parts. `error` is the
/// relative error as summary.json has it, empty where it is not known.
[[nodiscard]] std::vector<std::string> all_warnings(const micro::SimulationSummary& summary,
                                                    const PosterioriEstimate& estimate, std::optional<double> error);

}  // namespace trame::workflows
