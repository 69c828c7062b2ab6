#include "micro/solve/newton.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace trame::micro {

std::string_view describe(NewtonOutcome::Status status) {
  switch (status) {
    case NewtonOutcome::Status::converged: return "converged";
    case NewtonOutcome::Status::travelled: return "motion up to the limit between two contact detections";
    case NewtonOutcome::Status::held_up: return "forces that jump";
    case NewtonOutcome::Status::too_many_iterations: return "no convergence within the allowed iterations";
    case NewtonOutcome::Status::not_a_number: return "a force or stiffness became infinite or not a number";
    case NewtonOutcome::Status::not_positive_definite: return "the tangent is singular";
    case NewtonOutcome::Status::stopped: return "stopped from outside";
  }
  return "";
}

NewtonSolver::NewtonSolver(const Layout& layout, NewtonSettings settings, int n_threads, Timers& timers, Region region)
    : layout_(layout), settings_(std::move(settings)), n_threads_(n_threads), region_(std::move(region)),
      timers_(timers), system_(layout, n_threads, timers, region_),
      finder_(system_, settings_.linear, n_threads, timers), last_step_(layout.n_vectors(), Vec3::Zero()) {
  settings_.units.resize(layout.n_vectors(), 1.0);
  reset_reach();
}

bool NewtonSolver::cover_sparsity(const Effects& effects) {
  if (!system_.cover_sparsity(effects)) return false;
  finder_.take_pattern();
  return true;
}

void NewtonSolver::forget() {
  system_.forget_pattern();
  finder_.forget();
}

void NewtonSolver::set_reach(const Effects& effects, const State& state) {
  constexpr double longest = 100;  // times the usual
  std::vector<double> reach(layout_.n_vectors(), std::numeric_limits<double>::infinity());
  for (const auto& effect : effects) effect->limit_reach(state, reach);
  for (Index v = 0; v < layout_.n_vectors(); ++v) {
    const double usual = settings_.units[v];
    unit_[v] = usual * std::clamp(reach[v] / (settings_.travel_cap * usual), 1.0, longest);
  }
}

void NewtonSolver::reset_reach() { unit_ = settings_.units; }

/// Lets what moves with the fibers follow them. Couplings that come up on the way go into the pattern.
void NewtonSolver::follow(Effects& effects, const State& state, Effect::Follow what) {
  bool grown = false;
  {
    const auto guard = timers_.measure(Phase::detection);
    for (const auto& effect : effects) grown = effect->follow(state, what, region_) || grown;
  }
  if (grown) cover_sparsity(effects);
}

Residual NewtonSolver::between(const PrescribedMotion& prescribed, Index vector_begin, Index vector_end) const {
  const std::vector<double>&force = system_.force(), &inner = system_.inner(), &outer = system_.outer();
  Residual::Kind forces, moments;
  double inner_forces = 0, inner_moments = 0;
  for (Index v = vector_begin; v < vector_end; ++v) {
    Residual::Kind& kind = system_.is_position(v) ? forces : moments;
    for (Index d = 3 * v; d < 3 * v + 3; ++d)
      if (!prescribed.fixed[d]) kind.norm += force[d] * force[d];
    kind.scale += outer[v] * outer[v];
    (system_.is_position(v) ? inner_forces : inner_moments) += inner[v] * inner[v];
  }
  if (forces.scale + moments.scale == 0) {  // nothing but fibers
    forces.scale = inner_forces;
    moments.scale = inner_moments;
  }
  for (double* square : {&forces.norm, &forces.scale, &moments.norm, &moments.scale}) *square = std::sqrt(*square);
  const double by_moments = moments.scale / settings_.longest_arm, by_forces = forces.scale * settings_.shortest_arm;
  forces.scale = std::max(forces.scale, by_moments);
  moments.scale = std::max(moments.scale, by_forces);
  return {forces, moments};
}

Residual NewtonSolver::residual(const PrescribedMotion& prescribed) const {
  const std::vector<double>& force = system_.force();
  const auto [round_off_of_forces, round_off_of_moments] = finder_.round_off();
  Residual r = between(prescribed, 0, layout_.n_vectors());
  double worst = 0;
  for (std::size_t d = 0; d < force.size(); ++d) {
    if (prescribed.fixed[d] || std::abs(force[d]) <= worst) continue;
    worst = std::abs(force[d]);
    r.worst_dof = static_cast<Index>(d);
  }
  const auto not_a_number = std::find_if(force.begin(), force.end(), [](double f) { return !std::isfinite(f); });
  if (not_a_number != force.end()) {
    r.forces.norm = std::numeric_limits<double>::quiet_NaN();
    r.worst_dof = static_cast<Index>(not_a_number - force.begin());
    return r;
  }
  constexpr double tolerance = 0.01;  // of what a part gets from outside
  for (const NewtonSettings::Part& part : settings_.parts) {
    const Residual own = between(prescribed, part.begin, part.end);
    const auto of = [&](const Residual::Kind& kind, double negligible, double round_off) {
      return kind.norm / (tolerance * kind.scale + std::max(negligible, round_off));
    };
    r.worst_part = std::max({r.worst_part, of(own.forces, part.negligible, round_off_of_forces),
                             of(own.moments, part.negligible * settings_.shortest_arm, round_off_of_moments)});
  }
  return r;
}

double NewtonSolver::excess(const Residual& r, double slack) const {
  const auto of = [&](const Residual::Kind& kind, double round_off) {
    return kind.norm / std::max({slack * settings_.force_tolerance * kind.scale, settings_.force_floor, round_off});
  };
  const auto [round_off_of_forces, round_off_of_moments] = finder_.round_off();
  return std::max(of(r.forces, round_off_of_forces), of(r.moments, round_off_of_moments));
}

Residual NewtonSolver::evaluate(Effects& effects, const PrescribedMotion& prescribed, const State& state,
                                bool renewed) {
  follow(effects, state, renewed ? Effect::Follow::renewal : Effect::Follow::iteration);
  system_.assemble(effects, state, last_step_, Assembler::Tangent::none);
  return residual(prescribed);
}

StepProblem NewtonSolver::problem(const Solution& at, const State& state, double tolerance) const {
  return {.effects = at.effects,
          .prescribed = at.prescribed,
          .remaining = at.remaining,
          .state = state,
          .last_step = last_step_,
          .renews_limits = renews_limits_,
          .tolerance = tolerance,
          .control = *at.control,
          .unit = unit_};
}

bool NewtonSolver::seen_unstable(Effects& effects, const PrescribedMotion& prescribed, const State& state) {
  if (!finder_.linear().has_factor()) return false;
  follow(effects, state, Effect::Follow::iteration);
  std::fill(last_step_.begin(), last_step_.end(), Vec3::Zero());
  return finder_.finds_negative_curvature(effects, prescribed, state, last_step_);
}

/// trial_ = `state` and `alpha` of the step.
void NewtonSolver::try_step(const State& state, double alpha) {
  retract(layout_, state, finder_.step(), alpha, trial_);
  for (Index v = 0; v < layout_.n_vectors(); ++v)
    last_step_[v] = alpha * layout_.change(v, Eigen::Map<const Vec3>(finder_.step().data() + 3 * v));
}

double NewtonSolver::slope(const PrescribedMotion& prescribed) const {
  double sum = 0;
  for (std::size_t d = 0; d < system_.force().size(); ++d)
    if (!prescribed.fixed[d]) sum += system_.force()[d] * finder_.step()[d];
  return sum;
}

/// The length of a step at which the slope of the potential along it has nearly vanished, with the forces that were to
/// be expected: stretch by the square of a step, which the next step takes back, says nothing of its length. Where it
/// has turned upward steeply at `alpha`: regula falsi on the slope between the longest step known to be downhill and
/// the shortest known to be too long. Where the potential falls ever more steeply, which says nothing of how far:
/// doubled as long as it goes on falling, up to `longest`.
double NewtonSolver::line_search(Solution& at, const State& state, double alpha, double longest, double slope_at_zero) {
  constexpr int max_trials = 6;
  constexpr double nearly_vanished = 0.8;  // of the first slope: Newton's steps are good, what is far too long is not
  constexpr double shortest_share = 0.1, longest_share = 0.7, half = 0.5;  // of the range, for the next trial
  const auto slope_at = [&](double length) {
    try_step(state, length);
    follow(at.effects, trial_, finder_.is_unsymmetric() ? Effect::Follow::renewed_trial : Effect::Follow::trial);
    system_.assemble(at.effects, trial_, last_step_, Assembler::Tangent::none, Assembler::Stress::expected);
    return slope(at.prescribed);
  };
  double low = 0, low_slope = slope_at_zero, high = alpha;
  for (int trial = 0; trial < max_trials; ++trial) {
    const double s = slope_at(alpha);
    if (trial == 0 && s < 0) {
      while (s < slope_at_zero && 2 * alpha <= longest && slope_at(2 * alpha) < 0) alpha *= 2;
      return alpha;
    }
    if (std::abs(s) <= nearly_vanished * std::abs(slope_at_zero)) return alpha;
    if (s < 0) {
      low = alpha;
      low_slope = s;
    } else {
      high = alpha;  // infinite and undefined slopes too
    }
    const double guess = std::isfinite(s) && s > 0 ? -low_slope / (s - low_slope) : half;
    alpha = low + std::clamp(guess, shortest_share, longest_share) * (high - low);
  }
  return low > 0 ? low : alpha;
}

NewtonOutcome NewtonSolver::solve(Effects& effects, const PrescribedMotion& prescribed, double slack, State& state,
                                  const Log& log) {
  const bool moves = std::any_of(prescribed.motion.begin(), prescribed.motion.end(), [](double m) { return m != 0; });
  Solution at{effects, prescribed, slack, moves ? 1.0 : 0.0, 0, nullptr};
  if (settings_.damps_soft_modes)
    at.control = std::make_unique<DampedSoftModes>(settings_.step_cap);
  else
    at.control = std::make_unique<CappedSteps>(settings_.step_cap);
  std::fill(last_step_.begin(), last_step_.end(), Vec3::Zero());
  finder_.begin();
  NewtonOutcome outcome;
  outcome.status = iterate(at, state, outcome, log);
  outcome.n_iterations = at.n_iterations;
  outcome.n_factorizations = finder_.n_factorizations();
  outcome.n_linear_iterations = finder_.n_linear_iterations();
  outcome.remaining = at.remaining;
  return outcome;
}

NewtonOutcome::Status NewtonSolver::iterate(Solution& at, State& state, NewtonOutcome& outcome, const Log& log) {
  using Status = NewtonOutcome::Status;
  constexpr int max_renewals = 12;
  constexpr double round_off = 0.01;  // a capped step may be as long as the cap of the travel
  const State start = state;
  for (;; ++at.n_iterations) {
    // Limits of friction go with the forces, but do not run after them for ever.
    renews_limits_ = settings_.renews_limits && at.n_iterations < max_renewals;
    const Residual r = evaluate(at.effects, at.prescribed, state, renews_limits_);
    outcome.residual = r.relative();
    outcome.worst_dof = r.worst_dof;
    if (!std::isfinite(r.norm())) return Status::not_a_number;
    if (log)
      log(fmt::format("    iteration {:2d}  residual {:.2e}{}", at.n_iterations, outcome.residual,
                      finder_.is_indefinite() ? "  (indefinite)" : ""));
    if (at.remaining == 0 && is_equilibrium(r, at.slack)) return Status::converged;
    if (at.n_iterations == settings_.max_iterations) return Status::too_many_iterations;
    if (settings_.stop()) return Status::stopped;
    const bool has_step = make_step(at, r, state, log);
    if (finder_.is_indefinite()) outcome.indefinite_at = std::min(outcome.indefinite_at, r.relative());
    if (!has_step) {
      const auto& values = system_.values();
      const bool finite = std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
      return finite ? Status::not_positive_definite : Status::not_a_number;
    }
    // A force that jumps holds up line searches: contacts have come or gone, which is looked for anew.
    const bool held_up = at.control->is_held_up();
    const double travel = largest(unit_, [&](Index v) { return (state.q[v] - start.q[v]).norm(); }).size;
    const bool restless = !held_up && settle_restless_fibers(at, settings_.travel_cap - travel, state, log);
    if (held_up || restless || travel > (1 + round_off) * settings_.travel_cap) {
      ++at.n_iterations;
      return held_up ? Status::held_up : Status::travelled;
    }
  }
}

/// Fibers that the last step has moved far, with all else held where it is; nothing where they are not few.
std::optional<NewtonSolver::Restless> NewtonSolver::restless_fibers(const PrescribedMotion& prescribed) const {
  constexpr double far = 0.03;                        // in units
  constexpr double among_those_that_move_most = 0.1;  // of the longest
  constexpr int few = 8;                              // one of so many
  const auto went = [&](Index v) { return last_step_[v].norm(); };
  const double most = largest(unit_, went).size;
  if (most < far) return std::nullopt;
  const auto is_restless = [&](const NewtonSettings::Part& part) {
    for (Index v = part.begin; v < part.end; ++v)
      if (went(v) / unit_[v] >= among_those_that_move_most * most) return true;
    return false;
  };
  Restless restless{.held = {std::vector<char>(layout_.n_dofs(), 1), std::vector<double>(layout_.n_dofs(), 0.0)}};
  std::vector<char> is_free(layout_.n_nodes(), 0);
  for (const NewtonSettings::Part& part : settings_.parts) {
    if (!is_restless(part)) continue;
    restless.fibers.push_back(part);
    if (few * restless.fibers.size() > settings_.parts.size()) return std::nullopt;
    for (Index v = part.begin; v < part.end; ++v) is_free[system_.node_of(v)] = 1;
    std::copy(prescribed.fixed.begin() + 3 * part.begin, prescribed.fixed.begin() + 3 * part.end,
              restless.held.fixed.begin() + 3 * part.begin);
  }
  if (restless.fibers.empty()) return std::nullopt;
  restless.region = Region(std::move(is_free));
  return restless;
}

/// Few fibers that snap while the others hardly move find an equilibrium between the others as they are, by iterations
/// that cost next to nothing beside those of all: nonlinear elimination. Returns whether they have gone up to
/// `travel_left`.
bool NewtonSolver::settle_restless_fibers(Solution& at, double travel_left, State& state, const Log& log) {
  constexpr double costly = 1e10;  // flops of a factorisation
  constexpr int max_iterations = 20;
  if (at.remaining > 0 || travel_left <= 0 || n_factor_flops() < costly || !region_.is_everywhere()) return false;
  std::optional<Restless> restless = restless_fibers(at.prescribed);
  if (!restless) return false;
  NewtonSettings settings = settings_;
  settings.linear = {};
  settings.max_iterations = max_iterations;
  settings.travel_cap = travel_left;
  settings.renews_limits = false;
  NewtonSolver solver(layout_, std::move(settings), n_threads_, timers_, std::move(restless->region));
  solver.unit_ = unit_;
  solver.cover_sparsity(at.effects);
  const NewtonOutcome outcome = solver.solve(at.effects, restless->held, at.slack, state, {});
  if (log)
    log(fmt::format("      {} restless fibers by themselves: {} iterations, {}", restless->fibers.size(),
                    outcome.n_iterations, describe(outcome.status)));
  for (const NewtonSettings::Part& fiber : restless->fibers)  // nothing is left of the step's stretch
    std::fill(last_step_.begin() + fiber.begin, last_step_.begin() + fiber.end, Vec3::Zero());
  return outcome.status == NewtonOutcome::Status::travelled;
}

/// Goes on from `state`, at which there is the residual r. False where the tangent is singular.
bool NewtonSolver::make_step(Solution& at, const Residual& r, State& state, const Log& log) {
  // As exact as the step deserves: far from the solution its nonlinearity is the larger error. Fibers that bodies take
  // far along must not be distorted by a part of that.
  constexpr double with_motion = 1e-5, below_excess = 0.1, finest = 1e-4;
  const double tolerance =
      at.remaining > 0 ? with_motion : std::clamp(below_excess / excess(r, at.slack), finest, coarsest_step);
  constexpr double nothing = 1e-12;  // of the motion
  StepControl& control = *at.control;
  control.note_residual(r.norm());
  const double n_entries = n_factor_entries();
  if (!finder_.find(problem(at, state, tolerance))) return false;
  if (log && n_factor_entries() != n_entries)
    log(fmt::format("      new order, {}: {:.3g} entries, {:.3g} flops",
                    finder_.linear().has_two_levels() ? "two levels" : "one level", n_factor_entries(),
                    n_factor_flops()));
  const Largest step = largest(unit_, finder_.step());
  double alpha = control.part_of(step.size);
  // With a prescribed motion under way, or friction that goes with the normal force, the potential may rise along the
  // step: nothing to search.
  if (const double downhill = slope(at.prescribed); at.remaining == 0 && downhill < 0)
    alpha = line_search(at, state, alpha, control.cap() / step.size, downhill);
  control.note_taken(step.size, alpha);
  finder_.ease_damping(control.damping_kept());
  if (log)
    log(fmt::format(
        "      largest step {:.2e} (vector {}), taken {:.2f} of it; {} factorisations, {} linear iterations so far",
        step.size, step.vector, alpha, finder_.n_factorizations(), finder_.n_linear_iterations()));
  try_step(state, alpha);
  std::swap(state, trial_);
  at.remaining = alpha >= 1 ? 0.0 : at.remaining * (1 - alpha);
  if (at.remaining < nothing) at.remaining = 0;
  return true;
}

}  // namespace trame::micro
