#pragma once
/// \file
/// Whether pictures can be drawn: VTK here draws through X11 only, and ends the process where there is no X server.

namespace trame::workflows {

/// Whether the X server that DISPLAY names answers.
[[nodiscard]] bool display_answers();

}  // namespace trame::workflows
