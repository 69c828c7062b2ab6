#pragma once
/// \file
/// What a scene will simulate, in words, before it runs.

#include <string>
#include <vector>

#include "micro/simulate.h"

namespace trame::workflows {

/// An effect that a scene calls for, and the key that does.
struct CalledEffect {
  std::string effect;
  std::string key;
};
[[nodiscard]] std::vector<CalledEffect> called_effects(const micro::Scene& scene);

/// One line: "fibers 66, nodes 1,782, …, about 30 s and 200 MB".
[[nodiscard]] std::string size_text(const micro::ModelSize& size);

/// Title, sizes, bodies, effects with the keys that call for them, stages with their drives.
[[nodiscard]] std::string scene_overview(const micro::Scene& scene, const micro::ModelSize& size);

}  // namespace trame::workflows
