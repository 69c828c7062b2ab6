#include "micro/solve/newton.h"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <random>
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

NewtonSolver::NewtonSolver(const Layout& layout, const NewtonSettings& settings, int n_threads, Timers& timers)
    : layout_(layout), settings_(settings), timers_(timers), n_threads_(n_threads),
      linear_(layout, settings.precision, n_threads, settings.preconditioner),
      control_(settings.step_cap, settings.damps_soft_modes), damping_(layout.n_vectors()), force_(layout.n_dofs()),
      step_(layout.n_dofs()), inner_(layout.n_vectors()), outer_(layout.n_vectors()),
      last_step_(layout.n_vectors(), Vec3::Zero()) {
  settings_.units.resize(layout.n_vectors(), 1.0);
  reset_reach();
  for (Index j = 0; j < layout.n_nodes(); ++j) node_of_.insert(node_of_.end(), layout.n_vectors(j), j);
  owned_from_.resize(n_threads_ + 1);
  for (int t = 0; t <= n_threads_; ++t)
    owned_from_[t] = static_cast<Index>(static_cast<std::int64_t>(layout.n_nodes()) * t / n_threads_);
}

bool NewtonSolver::cover_sparsity(const Effects& effects) {
  Pattern::Builder builder;
  {
    const auto guard = timers_.measure(Phase::detection);
    for (const auto& effect : effects) effect->add_sparsity(builder);
    if (pattern_.covers(builder)) return false;
  }
  const auto guard = timers_.measure(Phase::symbolic);
  pattern_ = Pattern(layout_, std::move(builder));
  values_.resize(pattern_.n_values());
  linear_.set_pattern(pattern_);
  return true;
}

void NewtonSolver::forget() {
  pattern_ = {};
  linear_.forget();
}

void NewtonSolver::assemble(const Effects& effects, const State& state, Assembler::Tangent tangent,
                            Assembler::Stress of_forces) {
  const auto guard = timers_.measure(Phase::assembly);
#pragma omp parallel for num_threads(n_threads_) schedule(static, 1)
  for (int t = 0; t < n_threads_; ++t) {
    const Index begin = owned_from_[t], end = owned_from_[t + 1];
    std::fill(force_.begin() + layout_.first_dof(begin), force_.begin() + layout_.first_dof(end), 0.0);
    for (auto* sizes : {&inner_, &outer_})
      std::fill(sizes->begin() + layout_.first_vector(begin), sizes->begin() + layout_.first_vector(end), 0.0);
    if (tangent != Assembler::Tangent::none) {
      const auto value_limit = [&](Index node) {
        return values_.begin() + (node < layout_.n_nodes() ? pattern_.value_start(node) : pattern_.n_values());
      };
      std::fill(value_limit(begin), value_limit(end), 0.0);
    }
    Assembler assembler(layout_, &pattern_, begin, end, force_.data(), inner_.data(), values_.data(), tangent);
    // Actual forces alone know nothing of it.
    if (tangent != Assembler::Tangent::none || of_forces == Assembler::Stress::expected)
      assembler.set_last_step(last_step_.data(), of_forces);
    for (const auto& effect : effects) {
      assembler.set_magnitude(effect->is_elastic() ? inner_.data() : outer_.data());
      effect->add(state, assembler);
    }
  }
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
    for (const auto& effect : effects) grown = effect->follow(state, what) || grown;
  }
  if (grown) cover_sparsity(effects);
}

Residual NewtonSolver::between(const PrescribedMotion& prescribed, Index vector_begin, Index vector_end) const {
  Residual::Kind forces, moments;
  double inner_forces = 0, inner_moments = 0;
  for (Index v = vector_begin; v < vector_end; ++v) {
    Residual::Kind& kind = is_position(v) ? forces : moments;
    for (Index d = 3 * v; d < 3 * v + 3; ++d)
      if (!prescribed.fixed[d]) kind.norm += force_[d] * force_[d];
    kind.scale += outer_[v] * outer_[v];
    (is_position(v) ? inner_forces : inner_moments) += inner_[v] * inner_[v];
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
  Residual r = between(prescribed, 0, layout_.n_vectors());
  double worst = 0;
  for (std::size_t d = 0; d < force_.size(); ++d) {
    if (prescribed.fixed[d] || std::abs(force_[d]) <= worst) continue;
    worst = std::abs(force_[d]);
    r.worst_dof = static_cast<Index>(d);
  }
  const auto not_a_number = std::find_if(force_.begin(), force_.end(), [](double f) { return !std::isfinite(f); });
  if (not_a_number != force_.end()) {
    r.forces.norm = std::numeric_limits<double>::quiet_NaN();
    r.worst_dof = static_cast<Index>(not_a_number - force_.begin());
    return r;
  }
  constexpr double tolerance = 0.01;  // of what a part gets from outside
  for (const NewtonSettings::Part& part : settings_.parts) {
    const Residual own = between(prescribed, part.begin, part.end);
    const auto of = [&](const Residual::Kind& kind, double negligible, double round_off) {
      return kind.norm / (tolerance * kind.scale + std::max(negligible, round_off));
    };
    r.worst_part = std::max({r.worst_part, of(own.forces, part.negligible, round_off_.forces.norm),
                             of(own.moments, part.negligible * settings_.shortest_arm, round_off_.moments.norm)});
  }
  return r;
}

Residual NewtonSolver::evaluate(Effects& effects, const PrescribedMotion& prescribed, const State& state,
                                bool renewed) {
  follow(effects, state, renewed ? Effect::Follow::renewal : Effect::Follow::iteration);
  assemble(effects, state, Assembler::Tangent::none);
  return residual(prescribed);
}

/// Turns values_ and step_ (= −force) into the system of the free dofs: prescribed motion goes to the right-hand side,
/// its rows and columns become those of the identity, with 0 on their right-hand side. Prescribed dofs stand in body
/// nodes, which come first: their couplings to fibers are in their own columns, those among bodies in columns of
/// bodies.
void NewtonSolver::impose(const PrescribedMotion& prescribed, double remaining) {
  Index n_body_nodes = 0;
  for (Index j = 0; j < layout_.n_nodes(); ++j)
    for (Index d = layout_.first_dof(j); d < layout_.first_dof(j + 1); ++d)
      if (prescribed.fixed[d]) n_body_nodes = j + 1;
  for (Index j = 0; j < n_body_nodes; ++j) {
    const Index height = pattern_.column_height(j), first = layout_.first_dof(j);
    for (Index c = 0; c < 3 * layout_.n_vectors(j); ++c) {
      double* column = values_.data() + pattern_.value_start(j) + static_cast<std::size_t>(c) * height;
      const Index dc = first + c;
      Index at = 0;
      for (const Index i : pattern_.rows(j))
        for (Index r = 0; r < 3 * layout_.n_vectors(i); ++r, ++at) {
          const Index dr = layout_.first_dof(i) + r;
          if (dr <= dc) continue;  // the upper part of the diagonal block is not used
          if (prescribed.fixed[dc]) step_[dr] -= column[at] * remaining * prescribed.motion[dc];
          if (prescribed.fixed[dr]) step_[dc] -= column[at] * remaining * prescribed.motion[dr];
          if (prescribed.fixed[dc] || prescribed.fixed[dr]) column[at] = 0;
        }
      if (prescribed.fixed[dc]) column[c] = 1;
    }
  }
  for (std::size_t d = 0; d < step_.size(); ++d)
    if (prescribed.fixed[d]) step_[d] = 0;
}

/// How exactly steps that rub are solved for (Eisenstat and Walker's second choice): what the last one has left of the
/// residual tells how good the tangent is. Without friction inexact steps bend slender fibers so that they stretch,
/// which costs many iterations more.
double NewtonSolver::forcing_term() const {
  constexpr double safety = 0.3, coarsest = 0.02;
  return std::min(safety * control_.reduction() * control_.reduction(), coarsest);
}

/// Solves for the step from `state`, up to `tolerance` of its energy. The last factor is tried first, even that of
/// another pattern: a few iterations on it cost less than a new one. Where the tangent is not positive definite, the
/// factor is that of its projection, and the iterations behind it may end early; with a motion to be made, which they
/// have to finish, the projection stands for the tangent. A factor that does not do in single precision is replaced by
/// one in double.
bool NewtonSolver::find_step(Effects& effects, const PrescribedMotion& prescribed, const State& state, double remaining,
                             double tolerance, bool try_old_factor, NewtonOutcome& outcome) {
  using Truncated = LinearSolver::Truncated;
  constexpr int max_iterations = 50;
  // A factorisation costs as much as so many readings of the factor; behind new ones of two levels there are about six
  // iterations to come.
  const double affordable = n_factor_flops() / (LinearSolver::flops_per_entry * std::max(1.0, n_factor_entries())) +
                            (linear_.has_two_levels() ? 6 : 0);
  const int max_iterations_with_old_factor = static_cast<int>(std::clamp(affordable, 4.0, 15.0));
  const bool may_end_early = remaining == 0;
  const auto solve = [&](int limit, Truncated truncated) {
    const auto guard = timers_.measure(Phase::solve);
    const std::optional<int> n =
        unsymmetric_.empty() ? linear_.solve(values_, step_, tolerance, limit, truncated)
                             : linear_.solve(values_, unsymmetric_, step_, std::max(tolerance, forcing_term()), limit);
    outcome.n_linear_iterations += n.value_or(limit);
    return n;
  };
  const auto factorize = [&] {
    {
      const auto guard = timers_.measure(Phase::symbolic);
      if (settings_.coarse_space)
        linear_.analyze(values_, [&] { return settings_.coarse_space(state); });
      else
        linear_.analyze(values_);
    }
    const auto guard = timers_.measure(Phase::factorization);
    ++outcome.n_factorizations;
    return linear_.factorize(values_);
  };
  const auto set_up = [&](Assembler::Tangent tangent) {
    assemble(effects, state, tangent);
    round_off_ = estimated_round_off(state);
    for (std::size_t d = 0; d < force_.size(); ++d) step_[d] = -force_[d];
    impose(prescribed, remaining);
    hold_loose_bodies();
    for (Index v = 0; v < layout_.n_vectors(); ++v)
      if (damping_[v] > 0) add_to_diagonal(v, damping_[v]);
    load_ = step_;
    // An indefinite tangent is left downhill, which there is with limits of friction that stay.
    unsymmetric_.clear();
    if (!renews_limits_ || remaining > 0 || indefinite_) return;
    for (const auto& effect : effects) effect->add_unsymmetric(state, unsymmetric_);
    unsymmetric_.leave_out(prescribed.fixed);
  };
  const auto find_with_old_factor = [&] {
    constexpr int enough = 3;  // iterations before negative curvature, for a step that is worth its while
    const std::optional<int> n =
        solve(max_iterations_with_old_factor,
              indefinite_ && may_end_early ? Truncated::at_negative_curvature : Truncated::never);
    if (linear_.met_negative_curvature()) {
      indefinite_ = true;
      if (n && *n < enough) step_ = load_;
      return n && *n >= enough;
    }
    if (n) indefinite_ = false;
    return n.has_value();
  };
  // Two levels may be slow; that does not make a tangent indefinite.
  const auto find_with_new_factor = [&] {
    while (factorize()) {
      if (solve(max_iterations, Truncated::never)) return true;
      if (!linear_.has_two_levels() || linear_.met_negative_curvature()) return false;
      linear_.refine();
    }
    return false;
  };
  // What only contact holds against sliding is loose in the projection. As it is but a preconditioner, it may be made
  // a little stiffer all over; then the iterations tell whether the tangent itself is singular.
  const auto find_with_projection = [&] {
    constexpr double first_shift = 1e-8, last_shift = 1e-4;
    do {
      for (double shift = 0; shift <= last_shift; shift = shift == 0 ? first_shift : 100 * shift) {
        set_up(Assembler::Tangent::projected);
        scale_diagonal(1 + shift);
        if (factorize()) {
          if (may_end_early) set_up(Assembler::Tangent::exact);
          if (solve(max_iterations, may_end_early ? Truncated::at_any_limit : Truncated::never)) return true;
        }
      }
    } while (linear_.refine());
    return false;
  };
  // The exact tangent of `state` is set up.
  const auto find = [&](bool old_factor) {
    if (old_factor && linear_.has_factor() && find_with_old_factor()) return true;
    if (!indefinite_ && find_with_new_factor()) return true;
    indefinite_ = true;
    return find_with_projection();
  };
  set_up(Assembler::Tangent::exact);
  if (!find(try_old_factor)) return false;
  constexpr int max_raises = 3;
  for (int n = 0; n < max_raises && raise_damping(prescribed, remaining); ++n) {
    step_ = load_;
    if (!find(true)) return false;
  }
  for (std::size_t d = 0; d < step_.size(); ++d)
    if (prescribed.fixed[d]) step_[d] = remaining * prescribed.motion[d];
  return true;
}

/// Where a step is longer than the trust radius, something soft wants to go far: adds to the damping of the vectors
/// that move most (Levenberg and Marquardt's method), as much as holds them back and hardly anything else: a soft mode
/// of stiffness k = s·K s / s·s gets μ = k (‖s‖ / radius − 1). False if the step is short enough.
/// Of a step along which bodies are moved farther than the cap, only a part will be taken: that is what counts.
bool NewtonSolver::raise_damping(const PrescribedMotion& prescribed, double remaining) {
  const auto longest_of = [&](const auto& vectors) {
    return largest([&](Index v) { return Eigen::Map<const Vec3>(vectors.data() + 3 * v).norm(); }).size;
  };
  const double part = control_.part_of(remaining * longest_of(prescribed.motion)),
               longest = part * longest_of(step_);
  if (!control_.wants_damping(longest)) return false;
  std::vector<Index> far;
  double work = 0, squares = 0;
  for (Index v = 0; v < layout_.n_vectors(); ++v) {
    const Eigen::Map<const Vec3> step(step_.data() + 3 * v), load(load_.data() + 3 * v);
    if (prescribed.fixed[3 * v] || prescribed.fixed[3 * v + 1] || prescribed.fixed[3 * v + 2] ||
        part * step.norm() <= 0.5 * control_.radius() * unit_[v])
      continue;
    far.push_back(v);
    work += load.dot(step);
    squares += step.squaredNorm() / (unit_[v] * unit_[v]);
  }
  if (work <= 0) return false;
  const double more = work / squares * (longest / control_.radius() - 1);
  for (const Index v : far) {
    damping_[v] += more / (unit_[v] * unit_[v]);
    add_to_diagonal(v, more / (unit_[v] * unit_[v]));
  }
  return true;
}

void NewtonSolver::scale_diagonal(double factor) {
  for (Index j = 0; j < layout_.n_nodes(); ++j) {
    double* diagonal = values_.data() + pattern_.value_start(j);
    for (Index c = 0; c < 3 * layout_.n_vectors(j); ++c, diagonal += pattern_.column_height(j) + 1) *diagonal *= factor;
  }
}

void NewtonSolver::add_to_diagonal(Index vector, double stiffness) {
  const Index j = node_of_[vector], c = 3 * (vector - layout_.first_vector(j));
  double* diagonal =
      values_.data() + pattern_.value_start(j) + static_cast<std::size_t>(c) * (pattern_.column_height(j) + 1);
  for (int d = 0; d < 3; ++d, diagonal += pattern_.column_height(j) + 1) *diagonal += stiffness;
}

/// Dofs of bodies that nothing resists, as those of a plate that touches nothing yet: they go as far as the cap where
/// step_, still the load, drives them.
void NewtonSolver::hold_loose_bodies() {
  for (const Index rotation : layout_.rotation_vectors()) {
    const Index j = node_of_[rotation], height = pattern_.column_height(j);
    for (Index c = 0; c < 3 * layout_.n_vectors(j); ++c) {
      double& diagonal = values_[pattern_.value_start(j) + static_cast<std::size_t>(c) * (height + 1)];
      if (diagonal != 0) continue;
      const double load = std::abs(step_[layout_.first_dof(j) + c]);
      diagonal = load > 0 ? load / (control_.radius() * unit_[layout_.first_vector(j) + c / 3]) : 1;
    }
  }
}

bool NewtonSolver::seen_unstable(Effects& effects, const PrescribedMotion& prescribed, const State& state) {
  if (!linear_.has_factor()) return false;
  // Behind the factor of a projection it takes more; but there it is worth more. Behind two levels it takes more, too.
  const int max_iterations = indefinite_ ? 100 : linear_.has_two_levels() ? 24 : 12;
  follow(effects, state, Effect::Follow::iteration);
  std::fill(last_step_.begin(), last_step_.end(), Vec3::Zero());
  assemble(effects, state, Assembler::Tangent::exact);
  // Any load that no symmetry makes blind to a direction, the same in every run.
  std::minstd_rand random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (double& load : step_) load = uniform(random);
  impose(prescribed, 0);
  const auto guard = timers_.measure(Phase::solve);
  return linear_.finds_negative_curvature(values_, step_, max_iterations);
}

/// Norms of the round-off in forces and moments, from the diagonal of the tangent: ε ‖K_ii q_i‖, a few times over.
Residual NewtonSolver::estimated_round_off(const State& state) const {
  constexpr double a_few = 8;
  double forces = 0, moments = 0;
  for (Index j = 0; j < layout_.n_nodes(); ++j) {
    const double* column = values_.data() + pattern_.value_start(j);
    const Index first = layout_.first_dof(j);
    for (Index c = 0; c < layout_.first_dof(j + 1) - first; ++c, column += pattern_.column_height(j)) {
      const double force = column[c] * state.q[(first + c) / 3][(first + c) % 3];
      (c < 3 ? forces : moments) += force * force;
    }
  }
  Residual r;
  r.forces.norm = a_few * std::numeric_limits<double>::epsilon() * std::sqrt(forces);
  r.moments.norm = a_few * std::numeric_limits<double>::epsilon() * std::sqrt(moments);
  return r;
}

/// trial_ = `state` and `alpha` of the step.
void NewtonSolver::try_step(const State& state, double alpha) {
  retract(layout_, state, step_, alpha, trial_);
  for (Index v = 0; v < layout_.n_vectors(); ++v) last_step_[v] = alpha * Eigen::Map<const Vec3>(step_.data() + 3 * v);
}

double NewtonSolver::slope(const PrescribedMotion& prescribed) const {
  double sum = 0;
  for (std::size_t d = 0; d < force_.size(); ++d)
    if (!prescribed.fixed[d]) sum += force_[d] * step_[d];
  return sum;
}

/// The length of a step at which the slope of the potential along it has nearly vanished, with the forces that were to
/// be expected: stretch by the square of a step, which the next step takes back, says nothing of its length. Where it
/// has turned upward steeply at `alpha`: regula falsi on the slope between the longest step known to be downhill and
/// the shortest known to be too long, at most six trials. Where the potential falls ever more steeply, which says
/// nothing of how far: doubled as long as it goes on falling, up to `longest`.
double NewtonSolver::line_search(Effects& effects, const State& state, double alpha, double longest,
                                 double slope_at_zero, const PrescribedMotion& prescribed) {
  const double accepted = 0.8 * std::abs(slope_at_zero);
  const auto slope_at = [&](double length) {
    try_step(state, length);
    follow(effects, trial_, unsymmetric_.empty() ? Effect::Follow::trial : Effect::Follow::renewed_trial);
    assemble(effects, trial_, Assembler::Tangent::none, Assembler::Stress::expected);
    return slope(prescribed);
  };
  double low = 0, low_slope = slope_at_zero, high = alpha;
  for (int trial = 0; trial < 6; ++trial) {
    const double s = slope_at(alpha);
    if (trial == 0 && s < 0) {
      while (s < slope_at_zero && 2 * alpha <= longest && slope_at(2 * alpha) < 0) alpha *= 2;
      return alpha;
    }
    if (std::abs(s) <= accepted) return alpha;
    if (s < 0) {
      low = alpha;
      low_slope = s;
    } else {
      high = alpha;  // infinite and undefined slopes too
    }
    const double guess = std::isfinite(s) && s > 0 ? -low_slope / (s - low_slope) : 0.5;
    alpha = low + std::clamp(guess, 0.1, 0.7) * (high - low);
  }
  return low > 0 ? low : alpha;
}

template <typename Change>
NewtonSolver::Largest NewtonSolver::largest(const Change& change) const {
  Largest result;
  for (Index v = 0; v < layout_.n_vectors(); ++v) {
    const double size = change(v) / unit_[v];
    if (size > result.size) result = {size, v};
  }
  return result;
}

NewtonOutcome NewtonSolver::solve(Effects& effects, const PrescribedMotion& prescribed, double slack, State& state,
                                  const std::function<void(const std::string&)>& log) {
  NewtonOutcome outcome;
  double remaining = 1;  // part of the prescribed motion still to be made
  if (std::all_of(prescribed.motion.begin(), prescribed.motion.end(), [](double m) { return m == 0; })) remaining = 0;
  indefinite_ = false;
  std::fill(damping_.begin(), damping_.end(), 0.0);
  const State start = state;
  std::fill(last_step_.begin(), last_step_.end(), Vec3::Zero());
  control_ = {settings_.step_cap, settings_.damps_soft_modes};
  constexpr int max_renewals = 12;
  for (;; ++outcome.n_iterations) {
    // Limits of friction go with the forces, but do not run after them for ever.
    renews_limits_ = outcome.n_iterations < max_renewals;
    const Residual r = evaluate(effects, prescribed, state, renews_limits_);
    outcome.residual = r.relative();
    outcome.worst_dof = r.worst_dof;
    if (!std::isfinite(r.norm())) {
      outcome.status = NewtonOutcome::Status::not_a_number;
      return outcome;
    }
    if (log)
      log(fmt::format("    iteration {:2d}  residual {:.2e}{}", outcome.n_iterations, outcome.residual,
                      indefinite_ ? "  (indefinite)" : ""));
    if (remaining == 0 && is_equilibrium(r, slack)) return outcome;
    if (outcome.n_iterations == settings_.max_iterations) {
      outcome.status = NewtonOutcome::Status::too_many_iterations;
      return outcome;
    }
    if (settings_.stop()) {
      outcome.status = NewtonOutcome::Status::stopped;
      return outcome;
    }

    control_.note_residual(r.norm());
    // As exact as the step deserves: far from the solution its nonlinearity is the larger error. Fibers that bodies
    // take far along must not be distorted by a part of that.
    const double tolerance = remaining > 0 ? 1e-5 : std::clamp(0.1 / excess(r, slack), 1e-4, 0.02);
    const double n_entries = n_factor_entries();
    // Where fibers travel, contacts come and go with every step that was not taken whole: the last factor will not do.
    const bool try_old_factor = settings_.damps_soft_modes || control_.took_whole_step();
    if (!find_step(effects, prescribed, state, remaining, tolerance, try_old_factor, outcome)) {
      const bool finite = std::all_of(values_.begin(), values_.end(), [](double v) { return std::isfinite(v); });
      outcome.status = finite ? NewtonOutcome::Status::not_positive_definite : NewtonOutcome::Status::not_a_number;
      return outcome;
    }
    if (log && n_factor_entries() != n_entries)
      log(fmt::format("      new order, {}: {:.3g} entries, {:.3g} flops",
                      linear_.has_two_levels() ? "two levels" : "one level", n_factor_entries(), n_factor_flops()));
    const Largest step = largest([&](Index v) { return Eigen::Map<const Vec3>(step_.data() + 3 * v).norm(); });
    double alpha = control_.part_of(step.size);
    // With a prescribed motion under way, or friction that goes with the normal force, the potential may rise along the
    // step: nothing to search.
    if (const double downhill = slope(prescribed); remaining == 0 && downhill < 0)
      alpha = line_search(effects, state, alpha, control_.cap() / step.size, downhill, prescribed);
    control_.note_taken(step.size, alpha);
    for (double& d : damping_) d *= control_.damping_kept();
    if (log)
      log(fmt::format(
          "      largest step {:.2e} (vector {}), taken {:.2f} of it; {} factorisations, {} linear iterations so far",
          step.size, step.vector, alpha, outcome.n_factorizations, outcome.n_linear_iterations));
    try_step(state, alpha);
    std::swap(state, trial_);
    remaining = alpha >= 1 ? 0.0 : remaining * (1 - alpha);
    if (remaining < 1e-12) remaining = 0;
    // A force that jumps holds up line searches: contacts have come or gone, which is looked for anew. A capped step
    // may be as long as the cap of the travel: round-off shall not decide.
    const bool held_up = control_.is_held_up();
    if (held_up ||
        largest([&](Index v) { return (state.q[v] - start.q[v]).norm(); }).size > 1.01 * settings_.travel_cap) {
      ++outcome.n_iterations;
      outcome.remaining = remaining;
      outcome.status = held_up ? NewtonOutcome::Status::held_up : NewtonOutcome::Status::travelled;
      return outcome;
    }
  }
}

}  // namespace trame::micro
