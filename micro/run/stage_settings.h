#pragma once
/// \file
/// What a stage asks of the solver, from the scene's keys.

#include <functional>

#include "micro/model/model.h"

namespace trame::micro {

[[nodiscard]] NewtonSettings newton_settings(const Scene& scene, const StageModel& model, std::function<bool()> stop);
[[nodiscard]] LoadPathSettings load_path_settings(const Scene& scene, const Stage& stage, const StageModel& model);
/// Tolerances of an increment to stage time `to` over those of equilibria: 10³ where fibers are on their way; in a
/// stage that ends at rest they fall to 1 in its second half, so that what the end has to make good is little.
[[nodiscard]] double tolerance_factor(const Stage& stage, bool is_last, double to);

}  // namespace trame::micro
