#include "workflows/picture/display.h"

#include <X11/Xlib.h>

namespace trame::workflows {

bool display_answers() {
  Display* display = XOpenDisplay(nullptr);
  if (display == nullptr) return false;
  XCloseDisplay(display);
  return true;
}

}  // namespace trame::workflows
