#include "micro/solve/step_control.h"

#include <algorithm>
#include <limits>

namespace trame::micro {

void StepControl::note_residual(double norm) {
  reduction_ = last_residual_ > 0 ? norm / last_residual_ : 1;
  last_residual_ = norm;
}

void StepControl::note_taken(double size, double alpha) {
  constexpr double next_to_nothing = 0.02;
  n_stuck_ = alpha < next_to_nothing && alpha * size < next_to_nothing * cap() ? n_stuck_ + 1 : 0;
  took_whole_step_ = alpha >= 1;
}

bool StepControl::is_held_up() const {
  constexpr int several = 3;
  return n_stuck_ == several;
}

/// A step that is hardly longer than the radius is not worth another solution.
bool DampedSoftModes::wants_damping(double size) const {
  constexpr double hardly_longer = 1.2;
  return size > hardly_longer * radius_;
}

/// The radius becomes what a line search has left of a step, and doubles with each that is taken whole. Damping goes
/// where steps have become short: near a solution it would only slow Newton's method down.
void DampedSoftModes::note_taken(double size, double alpha) {
  StepControl::note_taken(size, alpha);
  constexpr double much_shorter = 0.7, shortest = 1.0 / 64;
  if (alpha < much_shorter)
    radius_ = std::clamp(alpha * size, shortest * step_cap_, step_cap_);
  else if (took_whole_step())
    radius_ = std::min(2 * radius_, step_cap_);
  constexpr double far = 0.7, near = 0.1, kept_between = 0.25;  // far and near in radii
  damping_kept_ = size >= far * radius_ ? 1 : size < near * radius_ ? 0 : kept_between;
}

CappedSteps::CappedSteps(double step_cap)
    : StepControl(step_cap), lowest_residual_(std::numeric_limits<double>::infinity()) {}

/// Where capped steps do not lower the residual, something soft goes to and fro across the solution: shorter ones find
/// it.
void CappedSteps::note_residual(double norm) {
  StepControl::note_residual(norm);
  constexpr double lower = 0.95, shorter = 0.5, shortest = 1.0 / 16;
  constexpr int many_capped = 4;
  if (norm < lower * lowest_residual_) {
    lowest_residual_ = norm;
    n_capped_ = 0;
    radius_ = step_cap_;
  } else if (n_capped_ >= many_capped) {
    n_capped_ = 0;
    radius_ = std::max(shorter * radius_, shortest * step_cap_);
  }
}

void CappedSteps::note_taken(double size, double alpha) {
  StepControl::note_taken(size, alpha);
  if (size > cap()) ++n_capped_;
}

}  // namespace trame::micro
