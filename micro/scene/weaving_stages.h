#pragma once
/// \file
/// The stages of a weave that names none: how it is woven, chosen from its geometry.

#include "micro/scene/scene.h"

namespace trame::micro {

/// separate, relax and settle. Needs the weave, the types of its fibers and their materials.
///
/// - Yarns are parted by a third of a fiber radius an increment.
/// - Yarn ends may move inward against a pull of 5·10⁻⁵ E A of a yarn while yarns are parted, of a tenth of that after.
/// - Damping is .1 E A/L while yarns are parted, whose loose fibers would go far; in the other stages it begins with
///   .03 E A/L and ends with the stage.
/// - Fibers are rods until they settle, as what their types say.
[[nodiscard]] std::vector<Stage> weaving_stages(const Scene& scene);

}  // namespace trame::micro
