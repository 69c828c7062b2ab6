#pragma once
/// \file
/// What states there are to choose from.

#include "meso/fiber_states.h"

namespace trame::workflows {

/// Prints one line per state: number, stage, time in it; for a run also contact elements and the load: the first
/// columns of curves.csv; of older files the largest external force on a body. Then the yarns.
void print_states(const meso::FiberStates& states);

}  // namespace trame::workflows
