#include "micro/solve/load_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace trame::micro {

namespace {

constexpr double sliver = 0.01;  // share of an increment that is joined to the one before rather than made on its own
constexpr double cut = 0.5;      // what is left of an increment that failed
constexpr double regrowth = 2;   // of cut increments, with each that is accepted at once

struct Attempt {
  bool accepted = false;
  std::string reason{};
  std::optional<Index> worst_dof{};
  bool refused = false;   // an equilibrium that is inadmissible
  bool hopeless = false;  // smaller increments would not help
};

/// What a stage works with, and changes.
struct Tools {
  NewtonSolver& newton;
  Effects& effects;
  const LoadPathSettings& settings;
  const StageDriver& driver;
  Timers& timers;

  void log(const std::string& text) const {
    if (driver.log) driver.log(text);
  }
};

double elastic_energy(const Effects& effects, const State& state) {
  double sum = 0;
  for (const auto& effect : effects)
    if (effect->is_elastic()) sum += effect->energy(state);
  return sum;
}

/// One increment: alternates contact detection and Newton's method, until all of the prescribed motion is made, the
/// contacts of the state itself are in equilibrium, and they are stiff enough.
class EquilibriumSearch {
 public:
  EquilibriumSearch(Tools& tools, PrescribedMotion motion, double slack, State& state, IncrementReport& report)
      : tools_(tools), motion_(std::move(motion)), slack_(slack), state_(state), report_(report),
        roughness_(slack > 1 ? 1 : first) {}

  Attempt find() {
    report_.n_stiffenings = 0;
    tools_.newton.reset_reach();
    for (;;) {
      look_for_contacts();
      if (arrived_)
        if (std::optional<Attempt> end = judge()) return *end;
      if (std::optional<Attempt> end = solve()) return *end;
    }
  }

 private:
  // Contacts that come up and preloads that are raised undo an equilibrium: it is not worth much before. Whether
  // raising makes a difference is not to be told from a coarse one.
  static constexpr double first = 1e4, later = 100;  // times the tolerances

  void look_for_contacts() {
    // From then on what has been found stays, so that fibers that go to and fro meet the same contacts each time.
    constexpr int few_to_and_fro = 8;
    constexpr int few = 2;  // detours that cost less than to ask how far fibers may go
    {
      const auto guard = tools_.timers.measure(Phase::detection);
      for (const auto& effect : tools_.effects) effect->update(state_, arrived_ || n_detours_ > few_to_and_fro);
    }
    ++report_.n_geometry_updates;
    if (n_detours_ >= few) tools_.newton.set_reach(tools_.effects, state_);
    if (tools_.newton.cover_sparsity(tools_.effects))
      tools_.log(fmt::format("    new pattern: {:.3g} entries in K", tools_.newton.n_matrix_entries()));
  }

  /// At an equilibrium of the contacts known before: how the increment ends, if it does.
  std::optional<Attempt> judge() {
    constexpr double nearly = 4e-3;  // one more solution serves both what has come up and what is too soft
    const Residual r = tools_.newton.evaluate(tools_.effects, motion_, state_, false);
    report_.residual = r.relative();
    const double renewed = tools_.newton.evaluate(tools_.effects, motion_, state_, true).relative();
    tools_.log(fmt::format("    contacts looked for again: residual {:.2e}, with friction renewed {:.2e}",
                           report_.residual, renewed));
    const bool was_rough = roughness_ > 1;
    const bool settled = tools_.newton.is_equilibrium(r, slack_) &&
                         renewed <= std::max(slack_ * tools_.settings.friction_tolerance, r.relative());
    const bool stiff = renewed > nearly || is_stiff_enough();
    if (settled && stiff) {
      if (is_free()) return Attempt{.accepted = true};
      if (++n_holds_ > tools_.settings.max_holds)
        return Attempt{.reason =
                           "what the proximal term holds back does not come to rest where the stage ends; "
                           "friction, or drives that hold it, may be missing",
                       .hopeless = true};
    }
    roughness_ = stiff ? 1 : std::min(roughness_, later);
    if (!settled && !was_rough && ++n_undone_ > tools_.settings.max_geometry_updates)
      return Attempt{.reason = fmt::format("contacts do not settle (relative residual {:.1e})", report_.residual),
                     .worst_dof = r.worst_dof};
    return std::nullopt;
  }

  /// Whether contact is stiff enough at an equilibrium; makes it stiffer where it is not.
  bool is_stiff_enough() {
    if (report_.n_stiffenings == tools_.settings.max_stiffenings) return true;
    const double energy = elastic_energy(tools_.effects, state_);
    bool enough = true;
    for (const auto& effect : tools_.effects) enough = !effect->stiffen(state_, energy, slack_) && enough;
    if (!enough) {
      ++report_.n_stiffenings;
      tools_.log("    contact made stiffer");
    }
    return enough;
  }

  /// Whether an equilibrium is one without what holds fibers back, too; holds them where they are from now on if it is
  /// not. Where next to nothing presses at the end, what has died away since the first time is nothing as well.
  bool is_free() {
    if (slack_ > 1) return true;
    bool held = false;
    for (const auto& effect : tools_.effects) held = effect->hold_at(state_) || held;
    if (!held) return true;
    const Residual r = tools_.newton.evaluate(tools_.effects, motion_, state_, false);
    tools_.log(fmt::format("    without damping: residual {:.2e}", r.relative()));
    if (held_by_ == 0) held_by_ = r.norm();
    constexpr double looser = 10, died_away = 1e-5;
    return (tools_.newton.is_equilibrium(r, looser) && r.worst_part <= 1) || r.norm() <= died_away * held_by_;
  }

  std::optional<Attempt> solve() {
    using Status = NewtonOutcome::Status;
    constexpr int max_held_up = 3;
    const NewtonOutcome outcome =
        tools_.newton.solve(tools_.effects, motion_, slack_ * roughness_, state_, tools_.driver.log);
    report_.n_newton_iterations += outcome.n_iterations;
    report_.n_factorizations += outcome.n_factorizations;
    arrived_ = outcome.converged();
    if (arrived_) {
      motion_.motion.assign(motion_.motion.size(), 0.0);  // it has been made
      return std::nullopt;
    }
    const bool goes_on = (outcome.status == Status::travelled && ++n_detours_ <= tools_.settings.max_detours) ||
                         (outcome.status == Status::held_up && ++n_held_up_ <= max_held_up);
    if (!goes_on) {
      constexpr double near_equilibrium = 1e-3;
      const bool loses_stability = outcome.indefinite_at < near_equilibrium;
      return Attempt{
          .reason = fmt::format("{} (relative residual {:.1e}){}", describe(outcome.status), outcome.residual,
                                loses_stability ? "; stability is lost here, fibers buckle or snap through" : ""),
          .worst_dof = outcome.worst_dof};
    }
    for (double& m : motion_.motion) m *= outcome.remaining;
    for (const auto& effect : tools_.effects) effect->hold_back();
    return std::nullopt;
  }

  Tools& tools_;
  PrescribedMotion motion_;  // that remains
  double slack_;
  State& state_;
  IncrementReport& report_;
  double roughness_;      // of tolerances
  int n_detours_ = 0;     // detections because of long motions, which settle nothing
  int n_held_up_ = 0;     // detections because of forces that jump
  int n_undone_ = 0;      // equilibria that contacts found at them have undone
  int n_holds_ = 0;       // equilibria that there were with damping only
  double held_by_ = 0;    // residual without it at the first of them
  bool arrived_ = false;  // an equilibrium of the contacts known before
};

/// Why an equilibrium that a step from `start` has reached is inadmissible; empty where it is not.
std::string inadmissibility(const Effects& effects, const State& start, const State& state) {
  for (const auto& effect : effects) {
    if (!std::isfinite(effect->energy(state)))
      return fmt::format("the energy of {} became infinite or not a number", effect->name());
    if (std::string why = effect->inadmissibility(start, state); !why.empty()) return why;
  }
  return {};
}

/// Takes `state` from `start` to an equilibrium that nothing speaks against.
Attempt try_increment(Tools& tools, const PrescribedMotion& motion, double slack, const State& start, State& state,
                      IncrementReport& report) {
  Attempt attempt = EquilibriumSearch(tools, motion, slack, state, report).find();
  if (!attempt.accepted) return attempt;
  const std::string why = inadmissibility(tools.effects, start, state);
  return {.accepted = why.empty(), .reason = why, .refused = !why.empty()};
}

/// First guess of a step: vectors go on as in the last one, `ratio` times as far but none farther than `cap`.
/// Rotations stay: their prescribed parts are advanced by Newton's method.
State predict(const State& state, const State& before, double ratio, double cap) {
  double largest = 0;
  for (std::size_t v = 0; v < state.q.size(); ++v)
    largest = std::max(largest, ratio * (state.q[v] - before.q[v]).norm());
  if (largest > cap) ratio *= cap / largest;
  State predicted = state;
  for (std::size_t v = 0; v < state.q.size(); ++v) predicted.q[v] += ratio * (state.q[v] - before.q[v]);
  return predicted;
}

void begin_step(Effects& effects, const State& start, double to) {
  for (const auto& effect : effects) effect->begin_step(start, to);
}

void commit(Effects& effects, const State& state) {
  for (const auto& effect : effects) effect->commit(state);
}

}  // namespace

void begin_at(Effects& effects, const State& state, double to) {
  begin_step(effects, state, to);
  for (const auto& effect : effects) effect->update(state);
}

StageOutcome run_stage(NewtonSolver& newton, Effects& effects, const LoadPathSettings& settings,
                       const StageDriver& driver, Timers& timers, StagePosition& position, State& state) {
  Tools tools{newton, effects, settings, driver, timers};
  const double nominal = 1.0 / settings.n_increments;
  auto& [time, next_size, last_size, n_accepted, before] = position;
  if (n_accepted == 0) position = {0, nominal, nominal, 0, state};
  double size = next_size;
  IncrementReport report;
  Attempt failure;  // the last one since `state`, but a refused equilibrium says more than that smaller increments
                    // found none
  auto clock = Timers::Clock::now();
  while (time < 1) {
    const double to = time + (1 + sliver) * size >= 1 ? 1 : time + size;
    tools.log(fmt::format("  stage time {:.4f} -> {:.4f}", time, to));
    begin_step(effects, state, to);
    // A first guess that led to a cut is not tried again, and what happens in a stage's first increment is like no
    // other.
    State trial = report.n_cuts == 0 && n_accepted > 1
                      ? predict(state, before, (to - time) / last_size, settings.prediction_cap)
                      : state;
    const PrescribedMotion motion = driver.motion(trial, time, to);
    const Attempt attempt = try_increment(tools, motion, driver.slack(to), state, trial, report);
    if (attempt.refused || !failure.refused) failure = attempt;
    if (!attempt.accepted && driver.stop()) return {.status = StageOutcome::Status::interrupted, .stage_time = time};
    if (!attempt.accepted) {
      ++report.n_cuts;
      size = cut * (to - time);
      tools.log(fmt::format("  cut: {}", attempt.reason));
      if (attempt.hopeless || size < settings.min_increment)
        return {.status = StageOutcome::Status::gave_up,
                .reason = failure.reason,
                .stage_time = time,
                .worst_dof = failure.worst_dof,
                .hopeless = attempt.hopeless};
      continue;
    }
    report.unstable = newton.seen_unstable(effects, motion, trial);
    if (report.unstable) tools.log("    this equilibrium is unstable");
    commit(effects, trial);
    newton.forget();
    ++n_accepted;
    before = std::exchange(state, std::move(trial));
    last_size = to - time;
    time = to;
    report.stage_time = time;
    report.seconds = std::chrono::duration<double>(Timers::Clock::now() - clock).count();
    next_size = size = report.n_cuts == 0 ? std::min(nominal, regrowth * size) : size;
    const bool go_on = driver.accepted(state, report);
    report = {};
    failure = {};
    clock = Timers::Clock::now();
    if (!go_on && time < 1) return {.status = StageOutcome::Status::interrupted, .stage_time = time};
  }
  return {.status = StageOutcome::Status::done, .stage_time = 1};
}

}  // namespace trame::micro
