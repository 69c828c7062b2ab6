#pragma once
/// \file
/// What a run leaves for people and programs that do not read states: curves.csv and summary.json.

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "micro/simulate.h"
#include "workflows/curves/curves_table.h"

namespace trame::workflows {

/// The curves of a run. A stage that ended before its first increment has no row.
[[nodiscard]] CurvesTable curves_table(const micro::Scene& scene, const micro::SimulationSummary& summary);

/// "done", "interrupted", "gave_up" or "cannot_write".
[[nodiscard]] std::string status_text(micro::SimulationSummary::Status status);

/// Sizes, work, accuracy, energies (J), wall-clock times (s) by phase and memory (bytes) of a run.
/// `alpha` is the ratio of the command line, null where none was given.
[[nodiscard]] nlohmann::json summary_json(const std::string& scene, std::optional<double> alpha,
                                          const micro::SimulationSummary& summary);

}  // namespace trame::workflows
