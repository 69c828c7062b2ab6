#pragma once
/// \file
/// What the report says about curves: pictures, branches, stiffness, loops.

#include <string>

#include "meso/fiber_states.h"
#include "workflows/curves/branches.h"

namespace trame::workflows {

/// The curves of saved states up to `last`, with the columns of curves.csv. None of older files, which lack motions.
[[nodiscard]] CurvesTable saved_curves(const meso::FiberStates& states, Index last);

/// Sides of the patch first, then the driven dofs that took most work; of a weave without its weaving. `are_saved`: the
/// table is `saved_curves`. Nothing where nothing moves.
[[nodiscard]] std::string curves_html(std::vector<Curve> curves, bool is_weave, bool are_saved);

}  // namespace trame::workflows
