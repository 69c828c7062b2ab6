#pragma once
/// \file
/// The step of Newton's method: from the tangent at a state to the change of all unknowns.

#include <functional>

#include "micro/solve/linear_solver.h"
#include "micro/solve/step_control.h"
#include "micro/solve/tangent_system.h"

namespace trame::micro {

/// Of a step's energy: what is left of it where the step's own nonlinearity is the larger error.
inline constexpr double coarsest_step = 0.02;

/// How linear systems are solved.
struct LinearSettings {
  FactorPrecision precision = FactorPrecision::double_precision;
  Preconditioner preconditioner = Preconditioner::factor;
  std::function<CoarseSpace(const State&)> coarse_space{};  ///< of two levels; may be empty
};

/// What a step is to be found from.
struct StepProblem {
  const Effects& effects;
  const PrescribedMotion& prescribed;
  double remaining;  ///< part of the prescribed motion still to be made
  const State& state;
  std::span<const Vec3> last_step;  ///< change of all vectors that has led to `state`
  bool renews_limits;               ///< of friction, with each iteration
  double tolerance;                 ///< of the step's energy
  const StepControl& control;
  std::span<const double> unit;  ///< of each vector: what counts as far
};

class StepFinder {
 public:
  StepFinder(TangentSystem& system, LinearSettings settings, int n_threads, Timers& timers);

  /// The system has a new pattern.
  void take_pattern() { linear_.set_pattern(system_.pattern()); }
  void forget() { linear_.forget(); }
  void keep(Archive& archive) { linear_.keep(archive); }

  /// A solution begins: nothing is damped, no tangent of it is known.
  void begin();
  /// Finds the step, with what is soft damped as `control` wants it. False where the tangent is singular.
  [[nodiscard]] bool find(const StepProblem& problem);
  /// The step that was found, of all dofs.
  [[nodiscard]] const std::vector<double>& step() const { return step_; }
  /// A part of the damping stays for the next step.
  void ease_damping(double kept);

  /// Whether a direction of negative curvature is found on the exact tangent at `state`, which is at rest, by a few
  /// conjugate gradients behind the factor at hand. False says nothing.
  [[nodiscard]] bool finds_negative_curvature(const Effects& effects, const PrescribedMotion& prescribed,
                                              const State& state, std::span<const Vec3> at_rest);

  /// Whether the last tangent was not positive definite.
  [[nodiscard]] bool is_indefinite() const { return indefinite_; }
  /// Whether the last step's tangent had terms of friction that are not symmetric.
  [[nodiscard]] bool is_unsymmetric() const { return !unsymmetric_.empty(); }
  /// Norms of the round-off in forces and in moments at the last tangent's state.
  [[nodiscard]] std::pair<double, double> round_off() const { return round_off_; }
  [[nodiscard]] const LinearSolver& linear() const { return linear_; }

  // Since `begin`.
  [[nodiscard]] int n_factorizations() const { return n_factorizations_; }
  [[nodiscard]] int n_linear_iterations() const { return n_linear_iterations_; }

 private:
  void set_up(const StepProblem& problem, Assembler::Tangent tangent);
  [[nodiscard]] bool find_undamped(const StepProblem& problem, bool try_old_factor);
  [[nodiscard]] bool find_with_old_factor(const StepProblem& problem);
  [[nodiscard]] bool find_with_new_factor(const StepProblem& problem);
  [[nodiscard]] bool find_with_projection(const StepProblem& problem);
  [[nodiscard]] std::optional<int> solve(const StepProblem& problem, int max_iterations,
                                         LinearSolver::Truncated truncated);
  [[nodiscard]] bool factorize(const StepProblem& problem);
  [[nodiscard]] bool raise_damping(const StepProblem& problem);
  [[nodiscard]] int affordable_iterations() const;

  TangentSystem& system_;
  LinearSettings settings_;
  Timers& timers_;
  LinearSolver linear_;
  UnsymmetricTerms unsymmetric_;  // of the system that has just been solved
  bool indefinite_ = false;
  int n_affordable_ = 0;  // iterations behind an old factor, in this step
  std::pair<double, double> round_off_;
  std::vector<double> damping_;      // of each vector: stiffness that holds it back
  std::vector<double> load_, step_;  // right-hand side and solution
  int n_factorizations_ = 0, n_linear_iterations_ = 0;
};

}  // namespace trame::micro
