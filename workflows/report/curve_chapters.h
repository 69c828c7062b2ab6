#pragma once
/// \file
/// What the report says about curves: pictures, branches, stiffness, loops.

#include <optional>
#include <string>

#include "meso/fiber_states.h"
#include "workflows/curves/branches.h"

namespace trame::workflows {

/// What the columns of curves.csv are for saved states up to `last`; nothing for older files, which lack motions.
/// Without a scene, those of the dofs that have moved.
[[nodiscard]] CurvesLayout saved_layout(const micro::SnapshotHeader& header, const std::optional<micro::Scene>& scene,
                                        const micro::Increment& last);
/// The row of a saved state.
[[nodiscard]] std::vector<double> saved_values(const CurvesLayout& layout, const micro::Increment& state);
/// The curves of saved states up to `last`, with the columns of curves.csv. None of older files, which lack motions.
[[nodiscard]] CurvesTable saved_curves(const meso::FiberStates& states, const std::optional<micro::Scene>& scene,
                                       Index last);

/// Sides of the patch first, then the driven dofs that took most work; of a weave without its weaving. `are_saved`: the
/// table is `saved_curves`. Nothing where nothing moves.
[[nodiscard]] std::string curves_html(std::vector<Curve> curves, bool is_weave, bool are_saved);

}  // namespace trame::workflows
