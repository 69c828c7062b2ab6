#include "micro/solve/load_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace trame::micro {

namespace {

struct Attempt {
  bool accepted = false;
  std::string reason;
  Index worst_dof = 0;
};

/// One increment: alternates contact detection and Newton's method until the state is in equilibrium with its own geometry. After two
/// detections the particles in contact stay and only directions follow: where a contact sits at the joint of two elements, whose
/// tangents differ a little, or between two kinds of contact, it would go to and fro for ever.
Attempt try_increment(NewtonSolver& newton, const Effects& effects, const LoadPathSettings& settings,
                      const StageDriver& driver, Timers& timers, PrescribedMotion motion, double slack, State& state,
                      IncrementReport& report) {
  Index worst_dof = 0;
  int n_detours = 0;  // detections because of long motions, which settle nothing
  for (int update = 0; update <= settings.max_geometry_updates; ++update) {
    {
      const auto guard = timers.measure(Phase::detection);
      const auto what = update < 2 ? Effect::Update::everything : Effect::Update::directions;
      for (const auto& effect : effects) effect->update(state, what);
    }
    if (newton.announce(effects) && driver.log)
      driver.log(fmt::format("    new pattern: {:.3g} entries in K", newton.n_matrix_entries()));
    if (update > 0) {
      const Residual r = newton.evaluate(effects, motion, state);
      report.residual = r.relative();
      worst_dof = r.worst_dof;
      if (driver.log) driver.log(fmt::format("    geometry {:2d}   residual {:.2e}", update, report.residual));
      if (report.residual <= slack * settings.geometry_tolerance || r.norm <= newton.force_floor()) return {true, "", 0};
      if (update == settings.max_geometry_updates) break;
    }
    ++report.n_geometry_updates;
    const NewtonOutcome outcome = newton.solve(effects, motion, slack, state, driver.log);
    report.n_newton_iterations += outcome.n_iterations;
    report.n_factorizations += outcome.n_factorizations;
    if (outcome.status == NewtonOutcome::Status::travelled && ++n_detours <= settings.max_detours) {
      for (double& m : motion.motion) m *= outcome.remaining;
      // A particle at the joint of two elements may go to and fro and throw its fiber each time: then particles stay here too.
      update = n_detours > settings.max_detours / 2 ? 1 : -1;
      continue;
    }
    if (!outcome.converged())
      return {false, fmt::format("{} (relative residual {:.1e})", describe(outcome.status), outcome.residual),
              outcome.worst_dof};
    std::fill(motion.motion.begin(), motion.motion.end(), 0.0);  // it has been made
  }
  return {false, fmt::format("contact geometry does not settle (relative residual {:.1e})", report.residual), worst_dof};
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

}  // namespace

StageOutcome run_stage(NewtonSolver& newton, const Effects& effects, const LoadPathSettings& settings,
                       const StageDriver& driver, Timers& timers, State& state) {
  const double nominal = 1.0 / settings.n_increments;
  double time = 0, size = nominal, last_size = nominal;
  State before = state;  // the accepted state before `state`
  int n_accepted = 0;
  IncrementReport report;
  auto clock = Timers::Clock::now();
  while (time < 1) {
    // A last increment that would be a sliver is joined to the one before.
    const double to = time + 1.01 * size >= 1 ? 1 : time + size;
    if (driver.log) driver.log(fmt::format("  stage time {:.4f} -> {:.4f}", time, to));
    for (const auto& effect : effects) effect->begin_step(state, to);
    // A first guess that led to a cut is not tried again, and what happens in a stage's first increment is like no other.
    State trial = report.n_cuts == 0 && n_accepted > 1
                      ? predict(state, before, (to - time) / last_size, settings.prediction_cap)
                      : state;
    const Attempt attempt =
        try_increment(newton, effects, settings, driver, timers, driver.motion(trial, time, to), driver.slack(to), trial, report);
    if (!attempt.accepted) {
      ++report.n_cuts;
      size = 0.5 * (to - time);
      if (driver.log) driver.log(fmt::format("  cut: {}", attempt.reason));
      if (size < settings.min_increment)
        return {StageOutcome::Status::gave_up, attempt.reason, time, attempt.worst_dof};
      continue;
    }
    for (const auto& effect : effects) effect->commit(trial);
    ++n_accepted;
    before = std::exchange(state, std::move(trial));
    last_size = to - time;
    time = to;
    report.stage_time = time;
    report.seconds = std::chrono::duration<double>(Timers::Clock::now() - clock).count();
    const bool go_on = driver.accepted(state, report);
    if (report.n_cuts == 0) size = std::min(nominal, 2 * size);
    report = {};
    clock = Timers::Clock::now();
    if (!go_on && time < 1) return {StageOutcome::Status::interrupted, "", time, 0};
  }
  return {StageOutcome::Status::done, "", 1, 0};
}

}  // namespace trame::micro
