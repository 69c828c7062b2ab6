#pragma once
/// \file
/// Enriched beams that move as rods do: a coarse space of the system.

#include "micro/fiber/fiber_field.h"
#include "micro/solve/coarse_space.h"

namespace trame::micro {

/// At `state`, with (δr, δθ) at the joints of elements: sections turn with θ there, δg_α = δθ × g_α, and so do
/// tangents, δr' = δθ × r'. Between joints δr is the cubic through them across the fiber, linear along it, and sections
/// turn as the cubic does, with the mean of the twists. Bodies and rods are as they are.
[[nodiscard]] CoarseSpace rod_space(const FiberField& field, const State& state);

}  // namespace trame::micro
