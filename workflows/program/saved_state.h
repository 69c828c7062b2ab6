#pragma once
/// \file
/// How a command line names a saved state.

#include <string>

#include "meso/fiber_states.h"

namespace trame::workflows {

/// The state that `text` names: a number, the name of a stage (its end), or "last". Throws InputError that names
/// `option`, or the states where there is none yet.
[[nodiscard]] Index find_state(const meso::FiberStates& states, const std::string& option, const std::string& text);

}  // namespace trame::workflows
