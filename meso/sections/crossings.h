#pragma once
/// \file
/// Where yarns cross, seen from above.

#include <optional>
#include <vector>

#include "micro/fiber/fiber_mesh.h"

namespace trame::meso {

/// Means of the yarn's fibers at equal steps of their lengths.
[[nodiscard]] std::vector<Vec3> mean_curve(const micro::FiberMesh& mesh, const micro::FiberConfiguration& fibers,
                                           Index yarn);

struct Crossing {
  double first_fraction = 0, second_fraction = 0;  ///< along the curves, 0…1
  Vec2 position = Vec2::Zero();                    ///< in the plan
  bool above = false;                              ///< the first curve is
};

/// The first place along `p` where two curves cross seen from above.
[[nodiscard]] std::optional<Crossing> crossing(const std::vector<Vec3>& p, const std::vector<Vec3>& q);

}  // namespace trame::meso
