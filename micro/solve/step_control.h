#pragma once
/// \file
/// How long a step of Newton's method may be, from what became of those before it.

namespace trame::micro {

/// Lengths are those of the vector that moves farthest, in its unit.
class StepControl {
 public:
  explicit StepControl(double step_cap) : step_cap_(step_cap), radius_(step_cap) {}
  virtual ~StepControl() = default;

  /// Before a step: what the last one has made of the norm of the residual.
  virtual void note_residual(double norm);
  /// After it: what was taken of it.
  virtual void note_taken(double size, double alpha);

  /// The longest step.
  [[nodiscard]] virtual double cap() const = 0;
  /// Steps that are longer want damping.
  [[nodiscard]] virtual bool wants_damping(double size) const = 0;
  /// Part of the damping of the last step that the next one begins with.
  [[nodiscard]] virtual double damping_kept() const = 0;
  /// Whether the factor of an earlier tangent is worth a trial.
  [[nodiscard]] virtual bool may_use_old_factor() const = 0;

  /// How far what is soft may go.
  [[nodiscard]] double radius() const { return radius_; }
  /// By so much the last step has changed the residual; 1 where there was none.
  [[nodiscard]] double reduction() const { return reduction_; }
  /// Part of a step of this length that may be taken.
  [[nodiscard]] double part_of(double size) const { return size <= cap() ? 1 : cap() / size; }
  /// Whether next to nothing was taken of several steps, one after the other.
  [[nodiscard]] bool is_held_up() const;

 protected:
  [[nodiscard]] bool took_whole_step() const { return took_whole_step_; }

  double step_cap_;
  double radius_;

 private:
  double last_residual_ = 0, reduction_ = 1;
  int n_stuck_ = 0;
  bool took_whole_step_ = true;
};

/// For paths of equilibria: what is soft is damped until it stays in a ball in which the tangent is trusted, and no
/// step is longer than `step_cap`.
class DampedSoftModes final : public StepControl {
 public:
  using StepControl::StepControl;
  void note_taken(double size, double alpha) override;
  [[nodiscard]] double cap() const override { return step_cap_; }
  [[nodiscard]] bool wants_damping(double size) const override;
  [[nodiscard]] double damping_kept() const override { return damping_kept_; }
  [[nodiscard]] bool may_use_old_factor() const override { return true; }

 private:
  double damping_kept_ = 1;
};

/// Where fibers travel far, held back by a proximal term, and single ones that are free to go would run ahead into
/// others: whole steps are scaled down to a cap, which starts as `step_cap` and falls where capped steps do not help.
class CappedSteps final : public StepControl {
 public:
  explicit CappedSteps(double step_cap);
  void note_residual(double norm) override;
  void note_taken(double size, double alpha) override;
  [[nodiscard]] double cap() const override { return radius_; }
  [[nodiscard]] bool wants_damping(double) const override { return false; }
  [[nodiscard]] double damping_kept() const override { return 1; }
  /// Contacts come and go with every step that was not taken whole: the last factor will not do.
  [[nodiscard]] bool may_use_old_factor() const override { return took_whole_step(); }

 private:
  double lowest_residual_;
  int n_capped_ = 0;  // steps at the cap since the residual was lowest
};

}  // namespace trame::micro
