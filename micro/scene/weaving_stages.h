#pragma once
/// \file
/// The stages of a weave that names none: how it is woven, chosen from its geometry.

#include "micro/scene/scene.h"

namespace trame::micro {

/// separate, relax and settle. Needs the weave, the types of its fibers and their materials.
///
/// - Yarns are parted by a third of a fiber radius an increment.
/// - Yarn ends may move inward against a pull of 5·10⁻⁵ E A of a yarn while yarns are parted, of a tenth of that after.
/// - Damping is 10⁻³ E A/L for yarns of up to a dozen fibers, and 10⁻² for more, whose loose fibers go farther; it ends
///   with each stage but the first.
/// - Fibers are rods until they settle, as what their types say.
[[nodiscard]] std::vector<Stage> weaving_stages(const Scene& scene);

/// Their damping: of fibers that get loose.
[[nodiscard]] double weaving_damping(const Weave& weave);

}  // namespace trame::micro
