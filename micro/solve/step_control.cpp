#include "micro/solve/step_control.h"

#include <algorithm>
#include <limits>

namespace trame::micro {

StepControl::StepControl(double step_cap, bool damps_soft_modes)
    : step_cap_(step_cap), damps_soft_modes_(damps_soft_modes), radius_(step_cap),
      lowest_residual_(std::numeric_limits<double>::infinity()) {}

/// Where capped steps do not lower the residual, something soft goes to and fro across the solution: shorter ones find
/// it.
void StepControl::note_residual(double norm) {
  reduction_ = last_residual_ > 0 ? norm / last_residual_ : 1;
  last_residual_ = norm;
  if (damps_soft_modes_) return;
  constexpr double lower = 0.95, shortest = 1.0 / 16;
  constexpr int many_capped = 4;
  if (norm < lower * lowest_residual_) {
    lowest_residual_ = norm;
    n_capped_ = 0;
    radius_ = step_cap_;
  } else if (n_capped_ >= many_capped) {
    n_capped_ = 0;
    radius_ = std::max(0.5 * radius_, shortest * step_cap_);
  }
}

void StepControl::note_taken(double size, double alpha) {
  constexpr double next_to_nothing = 0.02;
  n_stuck_ = alpha < next_to_nothing && alpha * size < next_to_nothing * cap() ? n_stuck_ + 1 : 0;
  took_whole_step_ = alpha >= 1;
  if (size > cap()) ++n_capped_;
  if (!damps_soft_modes_) return;
  constexpr double shortest = 1.0 / 64, far = 0.7, near = 0.1;  // far and near in radii
  if (alpha < 0.7)
    radius_ = std::clamp(alpha * size, shortest * step_cap_, step_cap_);
  else if (took_whole_step_)
    radius_ = std::min(2 * radius_, step_cap_);
  damping_kept_ = size >= far * radius_ ? 1 : size < near * radius_ ? 0 : 0.25;
}

}  // namespace trame::micro
