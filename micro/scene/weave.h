#pragma once
/// \file
/// Part of reading a scene: its weave.

#include "micro/scene/keys.h"
#include "micro/scene/pattern.h"
#include "micro/scene/scene.h"

namespace trame::micro {

/// "2/2" or "3/1/1/1": an even number of floats of a twill.
[[nodiscard]] Kind<std::vector<Index>> twill_floats();

/// Rows of 0 and 1.
[[nodiscard]] Kind<WeavePattern> pattern_matrix();

/// Reads [weave]. Needs the fiber types of `scene`.
[[nodiscard]] Weave read_weave(const SceneValue& table, const Scene& scene);

/// Names of a weave's yarns: warp/1 … then weft/1 …
[[nodiscard]] std::vector<std::string> yarn_names(const Weave& weave);

/// Names of the bodies that a weave makes: an end of each yarn, a side of the patch for each end of each yarn system.
[[nodiscard]] std::vector<std::string> weave_body_names(const Weave& weave);

}  // namespace trame::micro
