#pragma once
/// \file
/// What the report says about the run that made the states: certificates, work, time.

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "micro/scene/scene.h"
#include "micro/states/snapshot.h"

namespace trame::workflows {

/// What of summary.json the report shows; all empty without such a file.
struct RunSummary {
  std::vector<std::string> warnings;                           ///< the solver's giving up first, where it did
  std::optional<std::pair<int, int>> crossings;                ///< that agree with the pattern, and all of them
  std::vector<std::pair<std::string, std::string>> work = {};  ///< sizes and work of the solver: what, how much
  double total_seconds = 0;
  std::vector<std::pair<std::string, double>> seconds;  ///< of each phase
};
/// Throws InputError for a file that is missing or not a summary.
[[nodiscard]] RunSummary read_run_summary(const std::filesystem::path& file);

/// Whether a run has not reached the end of its scene, in words, from its last state; nothing where it has, and
/// where there is no scene.
[[nodiscard]] std::string what_is_missing(const std::optional<micro::Scene>& scene, const micro::Increment& last);

/// What a reader has to know before anything else; nothing where there is nothing.
[[nodiscard]] std::string warnings_html(const RunSummary& summary);

/// What vouches for state B, against limits of the scene.
[[nodiscard]] std::string certificates_html(const micro::FiberMesh& mesh, const std::optional<micro::Scene>& scene,
                                            const micro::Increment& b, const RunSummary& summary);

/// Sizes and work of the solver; nothing where they are not known.
[[nodiscard]] std::string work_table(const RunSummary& summary);

/// Where the run's time went; nothing where it is not known.
[[nodiscard]] std::string timing_figure(const RunSummary& summary);

}  // namespace trame::workflows
