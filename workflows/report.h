#pragma once
/// \file
/// What a run leaves for people and programs that do not read states: curves.csv and summary.json.

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "micro/simulate.h"

namespace trame::workflows {

/// A line for each increment: stage, time within it (0…1), strains and forces (N) of the warp and weft sides.
[[nodiscard]] std::string curves_csv(const std::vector<micro::CurvePoint>& curve);

/// "done", "interrupted", "gave_up" or "cannot_write".
[[nodiscard]] std::string status_text(micro::SimulationSummary::Status status);

/// Sizes, work, accuracy, energies (J), wall-clock times (s) by phase and memory (bytes) of a run.
/// `alpha` is the ratio of the command line, null where none was given.
[[nodiscard]] nlohmann::json summary_json(const std::string& scene, std::optional<double> alpha,
                                          const micro::SimulationSummary& summary);

}  // namespace trame::workflows
