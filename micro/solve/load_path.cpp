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

/// Whether contact is stiff enough at an equilibrium; makes it stiffer where it is not.
bool is_stiff_enough(Tools& tools, double slack, const State& state, IncrementReport& report) {
  if (report.n_stiffenings == tools.settings.max_stiffenings) return true;
  const double energy = elastic_energy(tools.effects, state);
  bool enough = true;
  for (const auto& effect : tools.effects) enough = !effect->stiffen(state, energy, slack) && enough;
  if (!enough) {
    ++report.n_stiffenings;
    tools.log("    contact made stiffer");
  }
  return enough;
}

/// Whether an equilibrium is one without what holds fibers back, too; holds them at `state` from now on where it is
/// not. Where next to nothing presses at the end, what has died away since `first`, the residual of the first time (0
/// until then), is nothing as well.
bool is_free(Tools& tools, const PrescribedMotion& motion, double slack, const State& state, double& first) {
  if (slack > 1) return true;
  bool held = false;
  for (const auto& effect : tools.effects) held = effect->hold_at(state) || held;
  if (!held) return true;
  const Residual r = tools.newton.evaluate(tools.effects, motion, state, false);
  tools.log(fmt::format("    without damping: residual {:.2e}", r.relative()));
  if (first == 0) first = r.norm();
  constexpr double looser = 10, died_away = 1e-5;
  return (tools.newton.is_equilibrium(r, looser) && r.worst_part <= 1) || r.norm() <= died_away * first;
}

/// One increment: alternates contact detection and Newton's method, until all of the prescribed motion is made, the
/// contacts of the state itself are in equilibrium, and they are stiff enough.
Attempt find_equilibrium(Tools& tools, PrescribedMotion motion, double slack, State& state,
                         IncrementReport& report) {
  auto& [newton, effects, settings, driver, timers] = tools;
  constexpr int max_held_up = 3;
  constexpr const char* restless =
      "what the proximal term holds back does not come to rest where the stage ends; friction, or drives that hold it, "
      "may be missing";
  // From then on what has been found stays, so that fibers that go to and fro meet the same contacts each time.
  constexpr int few_to_and_fro = 8;
  int n_detours = 0;     // detections because of long motions, which settle nothing
  int n_held_up = 0;     // detections because of forces that jump
  int n_undone = 0;      // equilibria that contacts found at them have undone
  int n_holds = 0;       // equilibria that there were with damping only
  double held_by = 0;    // residual without it at the first of them
  bool arrived = false;  // an equilibrium of the contacts known before
  // Contacts that come up and preloads that are raised undo an equilibrium: it is not worth much before. Whether
  // raising makes a difference is not to be told from a coarse one.
  constexpr double first = 1e4, later = 100;  // times the tolerances
  double roughness = slack > 1 ? 1 : first;
  report.n_stiffenings = 0;
  newton.reset_reach();
  for (;;) {
    {
      const auto guard = timers.measure(Phase::detection);
      for (const auto& effect : effects) effect->update(state, arrived || n_detours > few_to_and_fro);
    }
    ++report.n_geometry_updates;
    constexpr int few = 2;  // detours that cost less than to ask
    if (n_detours >= few) newton.set_reach(effects, state);
    if (newton.cover_sparsity(effects))
      tools.log(fmt::format("    new pattern: {:.3g} entries in K", newton.n_matrix_entries()));
    if (arrived) {
      const Residual r = newton.evaluate(effects, motion, state, false);
      report.residual = r.relative();
      const double renewed = newton.evaluate(effects, motion, state, true).relative();
      tools.log(fmt::format("    contacts looked for again: residual {:.2e}, with friction renewed {:.2e}",
                            report.residual, renewed));
      const bool was_rough = roughness > 1;
      const bool settled =
          newton.is_equilibrium(r, slack) && renewed <= std::max(slack * settings.friction_tolerance, r.relative());
      // One more solution serves both what has come up and what is too soft.
      constexpr double nearly = 1e-2;
      const bool stiff = renewed > nearly || is_stiff_enough(tools, slack, state, report);
      if (settled && stiff) {
        if (is_free(tools, motion, slack, state, held_by)) return {.accepted = true};
        if (++n_holds > settings.max_holds) return {.reason = restless, .hopeless = true};
      }
      roughness = stiff ? 1 : std::min(roughness, later);
      if (!settled && !was_rough && ++n_undone > settings.max_geometry_updates)
        return {.reason = fmt::format("contacts do not settle (relative residual {:.1e})", report.residual),
                .worst_dof = r.worst_dof};
    }
    const NewtonOutcome outcome = newton.solve(effects, motion, slack * roughness, state, driver.log);
    report.n_newton_iterations += outcome.n_iterations;
    report.n_factorizations += outcome.n_factorizations;
    arrived = outcome.converged();
    if (arrived) {
      motion.motion.assign(motion.motion.size(), 0.0);  // it has been made
    } else if ((outcome.status == NewtonOutcome::Status::travelled && ++n_detours <= settings.max_detours) ||
               (outcome.status == NewtonOutcome::Status::held_up && ++n_held_up <= max_held_up)) {
      for (double& m : motion.motion) m *= outcome.remaining;
      for (const auto& effect : effects) effect->hold_back();
    } else {
      return {.reason = fmt::format("{} (relative residual {:.1e})", describe(outcome.status), outcome.residual),
              .worst_dof = outcome.worst_dof};
    }
  }
}

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
Attempt try_increment(Tools& tools, const PrescribedMotion& motion, double slack, const State& start,
                      State& state, IncrementReport& report) {
  Attempt attempt = find_equilibrium(tools, motion, slack, state, report);
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
