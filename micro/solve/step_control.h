#pragma once
/// \file
/// How long a step of Newton's method may be, from what became of those before it.

namespace trame::micro {

/// Lengths are those of the vector that moves farthest, in its unit. Along paths of equilibria what is soft is damped
/// until it stays in a ball in which the tangent is trusted, and no step is longer than `step_cap`. Without that, steps
/// are scaled down to a cap, which starts as `step_cap` and falls where capped steps do not help.
class StepControl {
 public:
  StepControl(double step_cap, bool damps_soft_modes);

  /// Before a step: what the last one has made of the norm of the residual.
  void note_residual(double norm);
  /// By so much the last step has changed it; 1 where there was none.
  [[nodiscard]] double reduction() const { return reduction_; }
  /// Part of a step of this length that may be taken.
  [[nodiscard]] double part_of(double size) const { return size <= cap() ? 1 : cap() / size; }
  /// After it: what was taken of it.
  void note_taken(double size, double alpha);

  [[nodiscard]] double cap() const { return damps_soft_modes_ ? step_cap_ : radius_; }
  /// Steps that are longer than that want damping, where there is any.
  [[nodiscard]] bool wants_damping(double size) const { return damps_soft_modes_ && size > 1.2 * radius_; }
  [[nodiscard]] double radius() const { return radius_; }
  /// Part of the damping of the last step that the next one begins with.
  [[nodiscard]] double damping_kept() const { return damping_kept_; }
  [[nodiscard]] bool took_whole_step() const { return took_whole_step_; }
  /// Whether next to nothing was taken of several steps, one after the other.
  [[nodiscard]] bool is_held_up() const { return n_stuck_ == max_stuck; }

 private:
  static constexpr int max_stuck = 3;
  double step_cap_;
  bool damps_soft_modes_;
  double radius_;  // of the ball in which the tangent is trusted, or the cap of whole steps
  double lowest_residual_, last_residual_ = 0, reduction_ = 1;
  double damping_kept_ = 1;
  int n_capped_ = 0;  // steps at the cap since the residual was lowest
  int n_stuck_ = 0;
  bool took_whole_step_ = true;
};

}  // namespace trame::micro
