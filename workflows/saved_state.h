#pragma once
/// \file
/// How a command line names a saved state.

#include <string>

#include "micro/io/snapshot.h"

namespace trame::workflows {

/// The increment that `text` names: a number, the name of a stage (its end), or "last". Throws InputError that names
/// `option`.
[[nodiscard]] Index find_state(const micro::SnapshotReader& states, const std::string& option, const std::string& text);

}  // namespace trame::workflows
