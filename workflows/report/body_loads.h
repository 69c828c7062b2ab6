#pragma once
/// \file
/// What the report says about rigid bodies of scenes that have no sides: where they are and what pulls at them.

#include <string>

#include "meso/fiber_states.h"

namespace trame::workflows {

/// Motion of each body since state 0 and the force and moment on it in state `last`. Nothing where the states have no
/// bodies.
[[nodiscard]] std::string bodies_html(const meso::FiberStates& states, Index last);

}  // namespace trame::workflows
