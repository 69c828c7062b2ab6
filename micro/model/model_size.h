#pragma once
/// \file
/// How large a scene is, before it runs.

#include <vector>

#include "micro/scene/scene.h"

namespace trame::micro {

struct ModelSize {
  Index n_fibers = 0, n_nodes = 0, n_bodies = 0;
  std::int64_t n_dofs = 0;  ///< of the stage with most of them
  std::vector<std::int64_t> n_dofs_per_stage;
};
[[nodiscard]] ModelSize model_size(const Scene& scene);

}  // namespace trame::micro
