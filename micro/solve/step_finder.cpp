#include "micro/solve/step_finder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

namespace trame::micro {

namespace {

using Truncated = LinearSolver::Truncated;

constexpr int max_iterations = 50;  // of conjugate gradients behind a new factor

/// How exactly steps that rub are solved for (Eisenstat and Walker's second choice): what the last one has left of the
/// residual tells how good the tangent is. Without friction inexact steps bend slender fibers so that they stretch,
/// which costs many iterations more.
double forcing_term(const StepControl& control) {
  constexpr double safety = 0.3;
  return std::min(safety * control.reduction() * control.reduction(), coarsest_step);
}

/// Iterations behind an indefinite tangent may end early; with a motion to be made they have to finish.
bool may_end_early(const StepProblem& problem) { return problem.remaining == 0; }

}  // namespace

StepFinder::StepFinder(TangentSystem& system, LinearSettings settings, int n_threads, Timers& timers)
    : system_(system), settings_(std::move(settings)), timers_(timers),
      linear_(system.layout(), settings_.precision, n_threads, settings_.preconditioner),
      damping_(system.layout().n_vectors()), step_(system.layout().n_dofs()) {}

void StepFinder::begin() {
  indefinite_ = false;
  std::fill(damping_.begin(), damping_.end(), 0.0);
  n_factorizations_ = n_linear_iterations_ = 0;
}

void StepFinder::ease_damping(double kept) {
  for (double& d : damping_) d *= kept;
}

/// The last factor is tried first, even that of another pattern: a few iterations on it cost less than a new one. Where
/// the tangent is not positive definite, the factor is that of its projection, and the iterations behind it may end
/// early; with a motion to be made, the projection stands for the tangent. A factor that does not do in single
/// precision is replaced by one in double.
bool StepFinder::find(const StepProblem& problem) {
  n_affordable_ = affordable_iterations();
  set_up(problem, Assembler::Tangent::exact);
  const int before = n_factorizations_;
  if (!find_undamped(problem, problem.control.may_use_old_factor())) return false;
  // Damping changes little: a factor that is new serves on.
  if (n_factorizations_ > before) n_affordable_ = max_iterations;
  constexpr int max_raises = 3;
  for (int n = 0; n < max_raises && raise_damping(problem); ++n) {
    step_ = load_;
    if (!find_undamped(problem, true)) return false;
  }
  for (std::size_t d = 0; d < step_.size(); ++d)
    if (problem.prescribed.fixed[d]) step_[d] = problem.remaining * problem.prescribed.motion[d];
  return true;
}

/// The system of the free dofs, with the damping there is; step_ is its right-hand side.
void StepFinder::set_up(const StepProblem& problem, Assembler::Tangent tangent) {
  constexpr double a_few = 8;  // of rounded numbers
  system_.assemble(problem.effects, problem.state, problem.last_step, tangent);
  const auto [forces, moments] = system_.diagonal_forces(problem.state);
  round_off_ = {a_few * std::numeric_limits<double>::epsilon() * forces,
                a_few * std::numeric_limits<double>::epsilon() * moments};
  for (std::size_t d = 0; d < step_.size(); ++d) step_[d] = -system_.force()[d];
  system_.impose(problem.prescribed, problem.remaining, step_);
  system_.hold_loose_bodies(step_, problem.control.radius(), problem.unit);
  for (std::size_t v = 0; v < damping_.size(); ++v)
    if (damping_[v] > 0) system_.add_to_diagonal(static_cast<Index>(v), damping_[v]);
  load_ = step_;
  // An indefinite tangent is left downhill, which there is with limits of friction that stay.
  unsymmetric_.clear();
  if (!problem.renews_limits || problem.remaining > 0 || indefinite_) return;
  for (const auto& effect : problem.effects) effect->add_unsymmetric(problem.state, unsymmetric_);
  unsymmetric_.change_each([&](Index v, const Vec3& value) { return system_.layout().force_on_dofs(v, value); });
  unsymmetric_.leave_out(problem.prescribed.fixed);
}

/// The exact tangent is set up.
bool StepFinder::find_undamped(const StepProblem& problem, bool try_old_factor) {
  if (try_old_factor && linear_.has_factor() && find_with_old_factor(problem)) return true;
  if (!indefinite_ && find_with_new_factor(problem)) return true;
  indefinite_ = true;
  return find_with_projection(problem);
}

/// A factorisation costs as much as so many readings of the factor; behind new ones of two levels there are a few
/// iterations to come.
int StepFinder::affordable_iterations() const {
  constexpr double to_come = 6, fewest = 4, most = 15;
  const double readings =
      linear_.n_factor_flops() / (LinearSolver::flops_per_entry * std::max(1.0, linear_.n_factor_entries()));
  return static_cast<int>(std::clamp(readings + (linear_.has_two_levels() ? to_come : 0), fewest, most));
}

bool StepFinder::find_with_old_factor(const StepProblem& problem) {
  constexpr int enough = 3;  // iterations before negative curvature, for a step that is worth its while
  const std::optional<int> n =
      solve(problem, n_affordable_,
            indefinite_ && may_end_early(problem) ? Truncated::at_negative_curvature : Truncated::never);
  if (linear_.met_negative_curvature()) {
    indefinite_ = true;
    if (n && *n < enough) step_ = load_;
    return n && *n >= enough;
  }
  if (n) indefinite_ = false;
  return n.has_value();
}

/// Two levels may be slow; that does not make a tangent indefinite.
bool StepFinder::find_with_new_factor(const StepProblem& problem) {
  while (factorize(problem)) {
    if (solve(problem, max_iterations, Truncated::never)) return true;
    if (!linear_.has_two_levels() || linear_.met_negative_curvature()) return false;
    linear_.refine();
  }
  return false;
}

/// What only contact holds against sliding is loose in the projection. As it is but a preconditioner, it may be made a
/// little stiffer all over; then the iterations tell whether the tangent itself is singular. What weak couplings leave
/// out may be all that holds soft modes, so they come before that.
bool StepFinder::find_with_projection(const StepProblem& problem) {
  constexpr double first_shift = 1e-8, last_shift = 1e-4, growth = 100;
  do {
    const double stiffest = linear_.is_complete() ? last_shift : 0;
    for (double shift = 0; shift <= stiffest; shift = shift == 0 ? first_shift : growth * shift) {
      set_up(problem, Assembler::Tangent::projected);
      system_.scale_diagonal(1 + shift);
      if (!factorize(problem)) continue;
      if (may_end_early(problem)) set_up(problem, Assembler::Tangent::exact);
      if (solve(problem, max_iterations, may_end_early(problem) ? Truncated::at_any_limit : Truncated::never))
        return true;
    }
  } while (linear_.refine());
  return false;
}

std::optional<int> StepFinder::solve(const StepProblem& problem, int limit, Truncated truncated) {
  const auto guard = timers_.measure(Phase::solve);
  const std::optional<int> n = unsymmetric_.empty()
                                   ? linear_.solve(system_.values(), step_, problem.tolerance, limit, truncated)
                                   : linear_.solve(system_.values(), unsymmetric_, step_,
                                                   std::max(problem.tolerance, forcing_term(problem.control)), limit);
  n_linear_iterations_ += n.value_or(limit);
  return n;
}

bool StepFinder::factorize(const StepProblem& problem) {
  {
    const auto guard = timers_.measure(Phase::symbolic);
    if (settings_.coarse_space)
      linear_.analyze(system_.values(), [&] { return settings_.coarse_space(problem.state); });
    else
      linear_.analyze(system_.values());
  }
  const auto guard = timers_.measure(Phase::factorization);
  ++n_factorizations_;
  return linear_.factorize(system_.values());
}

/// Where a step is longer than the trust radius, something soft wants to go far: adds to the damping of the vectors
/// that move most (Levenberg and Marquardt's method), as much as holds them back and hardly anything else: a soft mode
/// of stiffness k = s·K s / s·s gets μ = k (‖s‖ / radius − 1). False if the step is short enough.
/// Of a step along which bodies are moved farther than the cap, only a part will be taken: that is what counts.
bool StepFinder::raise_damping(const StepProblem& problem) {
  constexpr double among_those_that_move_most = 0.5;  // of the radius
  const std::span<const double> unit = problem.unit;
  const StepControl& control = problem.control;
  const PrescribedMotion& prescribed = problem.prescribed;
  const double part = control.part_of(problem.remaining * largest(unit, prescribed.motion).size),
               longest = part * largest(unit, step_).size;
  if (!control.wants_damping(longest)) return false;
  std::vector<Index> far;
  double work = 0, squares = 0;
  for (Index v = 0; v < system_.layout().n_vectors(); ++v) {
    const Eigen::Map<const Vec3> step(step_.data() + 3 * v), load(load_.data() + 3 * v);
    if (prescribed.fixed[3 * v] || prescribed.fixed[3 * v + 1] || prescribed.fixed[3 * v + 2] ||
        part * step.norm() <= among_those_that_move_most * control.radius() * unit[v])
      continue;
    far.push_back(v);
    work += load.dot(step);
    squares += step.squaredNorm() / (unit[v] * unit[v]);
  }
  if (work <= 0) return false;
  const double more = work / squares * (longest / control.radius() - 1);
  for (const Index v : far) {
    damping_[v] += more / (unit[v] * unit[v]);
    system_.add_to_diagonal(v, more / (unit[v] * unit[v]));
  }
  return true;
}

bool StepFinder::finds_negative_curvature(const Effects& effects, const PrescribedMotion& prescribed,
                                          const State& state, std::span<const Vec3> at_rest) {
  // Behind the factor of a projection it takes more; but there it is worth more. Behind two levels it takes more, too.
  constexpr int behind_a_projection = 100, behind_two_levels = 24, behind_a_factor = 12;
  const int limit = indefinite_ ? behind_a_projection : linear_.has_two_levels() ? behind_two_levels : behind_a_factor;
  system_.assemble(effects, state, at_rest, Assembler::Tangent::exact);
  // Any load that no symmetry makes blind to a direction, the same in every run.
  std::minstd_rand random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (double& load : step_) load = uniform(random);
  system_.impose(prescribed, 0, step_);
  const auto guard = timers_.measure(Phase::solve);
  return linear_.finds_negative_curvature(system_.values(), step_, limit);
}

}  // namespace trame::micro
