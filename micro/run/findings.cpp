#include "micro/run/findings.h"

#include <fmt/format.h>

#include <algorithm>

#include "micro/contact/fiber_ends.h"

namespace trame::micro {

CrossingCount count_crossings(const StageModel& model, const State& state, const Assembly& assembly) {
  CrossingCount count;
  for (const YarnCrossing& c : ordered_crossings(assembly)) {
    ++count.n;
    count.n_in_order += smallest_separation(model.field, state, c).value_or(-1) > 0;
  }
  return count;
}

BuriedEnds find_free_buried_ends(const StageModel& model, const State& state, const Assembly& assembly) {
  const auto tied = [&](Index fiber, std::optional<FiberEnd> end, Index body) {
    return std::any_of(assembly.ties.begin(), assembly.ties.end(),
                       [&](const EndTie& t) { return t.fiber == fiber && t.body == body && (!end || t.end == *end); });
  };
  const auto ends = find_buried_ends(model.field, state, [&](Index fiber, FiberEnd end, Index other) {
    return std::any_of(assembly.ties.begin(), assembly.ties.end(),
                       [&](const EndTie& t) { return t.fiber == other && tied(fiber, end, t.body); });
  });
  constexpr std::size_t n_named = 3;
  BuriedEnds found{static_cast<Index>(ends.size()), {}};
  for (std::size_t i = 0; i < std::min(ends.size(), n_named); ++i)
    found.text +=
        fmt::format("{}the {} of fiber {} in {}", i > 0 ? ", " : "", ends[i].end == FiberEnd::start ? "start" : "end",
                    ends[i].fiber, model.field.describe(ends[i].inside, ends[i].s));
  if (ends.size() > n_named) found.text += fmt::format(", and {} more", ends.size() - n_named);
  return found;
}

std::string held_back(const Stage& stage, bool is_last) {
  if (stage.proximal_end == 0) return {};
  if (!stage.separate_yarns)
    return fmt::format(
        "stage {}: a proximal term (proximal_end = {:g}) holds fibers back to the end, and changes the forces of "
        "increments on the way",
        stage.name, stage.proximal_end);
  if (!is_last) return {};
  return fmt::format(
      "stage {} is the last one and ends while yarns are being parted, not in equilibrium: contact has not taken over "
      "yet, and a proximal term holds fibers back",
      stage.name);
}

std::string describe_failure(const StageModel& model, const Stage& stage, const StageOutcome& outcome) {
  const std::string what =
      fmt::format("stage {} at stage time {:.4f}: {}", stage.name, outcome.stage_time, outcome.reason);
  const std::string end = outcome.hopeless ? "" : "; the smallest allowed increment failed";
  if (!outcome.worst_dof) return what + end;
  return what + ", near " + model.describe_dof(*outcome.worst_dof) + end +
         ". Try more increments in this stage, a larger proximal term, a larger solver.max_newton_iterations or a "
         "softer contact.penalty";
}

}  // namespace trame::micro
