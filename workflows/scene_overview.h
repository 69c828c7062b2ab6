#pragma once
/// \file
/// What a scene will simulate, in words, before it runs.

#include <string>
#include <vector>

#include "micro/cost_estimate.h"
#include "micro/simulate.h"

namespace trame::workflows {

/// An effect that a scene calls for, and the key that does; of keys that the scene leaves out, their default.
struct CalledEffect {
  micro::PricedEffect kind{};
  std::string effect;
  std::string key;
};
[[nodiscard]] std::vector<CalledEffect> called_effects(const micro::Scene& scene);

/// One line: "30 fibers, 810 nodes, …; about 30 s and 200 MB".
[[nodiscard]] std::string size_text(const micro::ModelSize& size, const micro::CostEstimate& cost);

/// Sizes, bodies, effects with their cost and the keys that call for them, stages with their drives.
[[nodiscard]] std::string scene_overview(const micro::Scene& scene, const micro::ModelSize& size,
                                         const micro::CostEstimate& cost);

/// What of the start may not be what was meant, a sentence: fibers that lie in each other. Empty where there is
/// nothing.
[[nodiscard]] std::string start_warning(const micro::Scene& scene);

}  // namespace trame::workflows
