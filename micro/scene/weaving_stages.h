#pragma once
/// \file
/// The stages of a weave that names none: how it is woven, chosen from its geometry.

#include "micro/scene/scene.h"

namespace trame::micro {

/// separate, relax and settle. Needs the weave, the types of its fibers and their materials.
///
/// - Yarns are parted by a third of a fiber radius an increment.
/// - Yarn ends may move inward against a pull of 5·10⁻⁵ E A of a yarn while yarns are parted, of a tenth of that after.
/// - Damping, of loose fibers that would go far, is 10⁻² E A/L; it ends with each stage but the first.
/// - Fibers are rods until they settle, as what their types say.
[[nodiscard]] std::vector<Stage> weaving_stages(const Scene& scene);

}  // namespace trame::micro
