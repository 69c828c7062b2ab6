#pragma once
/// \file
/// What states there are to choose from, and how a command line names one.

#include <string>

#include "meso/fiber_states.h"

namespace trame::workflows {

/// The state that `text` names: a number, the name of a stage (its end), or "last". Throws InputError that names
/// `option`.
[[nodiscard]] Index find_state(const meso::FiberStates& states, const std::string& option, const std::string& text);

/// Prints one line per state: number, stage, time in it; for a run also contact elements and the load: distances of the
/// patch's sides and mean pulling forces on them, or without sides the largest external force on a body. Then the
/// yarns.
void print_states(const meso::FiberStates& states);

}  // namespace trame::workflows
