#pragma once
/// \file
/// The weft-to-warp ratio of a biaxial test, set from outside the scene.

#include "micro/scene/scene.h"

namespace trame::workflows {

/// `scene` with the weft strains of its last stage at `alpha` times the warp strain: every strain drive along y gets
/// alpha times the value of the strain drives along x. Throws InputError unless alpha is finite, the stage has strain
/// drives along both, and those along x agree.
[[nodiscard]] micro::Scene with_weft_ratio(micro::Scene scene, double alpha);

}  // namespace trame::workflows
