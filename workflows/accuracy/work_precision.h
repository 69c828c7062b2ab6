#pragma once
/// \file
/// Work-precision diagram of a study: error over CPU time, a line for each knob, the Pareto front marked.

#include <string>

#include "workflows/accuracy/study.h"

namespace trame::workflows {

/// gnuplot commands, which set neither terminal nor output; empty where no case has an error to draw.
[[nodiscard]] std::string work_precision_script(const Study& study);

}  // namespace trame::workflows
