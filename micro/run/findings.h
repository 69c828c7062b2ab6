#pragma once
/// \file
/// What a user has to know of a stage's end, and how to say it.

#include <optional>
#include <string>

#include "micro/model/model.h"

namespace trame::micro {

struct CrossingCount {
  Index n = 0, n_in_order = 0;
};
/// Yarn crossings, and how many of them have the right yarn on top.
[[nodiscard]] CrossingCount count_crossings(const StageModel& model, const State& state, const Assembly& assembly);

/// Fiber ends that lie inside other fibers, where ends have no contact, but for those that a body holds together with
/// them; the first few by name.
struct BuriedEnds {
  Index n = 0;
  std::string text;
};
[[nodiscard]] BuriedEnds find_free_buried_ends(const StageModel& model, const State& state, const Assembly& assembly);

/// What a stage leaves unsaid that holds fibers back to its end; empty where it does not.
[[nodiscard]] std::string held_back(const Stage& stage, bool is_last);

/// Why a stage gave up, where, and what to try.
[[nodiscard]] std::string describe_failure(const StageModel& model, const Stage& stage, const StageOutcome& outcome);

}  // namespace trame::micro
