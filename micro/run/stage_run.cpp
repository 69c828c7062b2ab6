#include "micro/run/stage_run.h"

#include <fmt/format.h>

#include <utility>

#include "micro/run/findings.h"
#include "micro/run/record.h"
#include "micro/run/stage_settings.h"

namespace trame::micro {

namespace {

class StageRun {
 public:
  StageRun(RunContext& run, std::size_t index)
      : run_(run), index_(index), stage_(run.scene.stages[index]),
        model_(run.scene, run.assembly, stage_, run.state.stage_start),
        newton_(model_.layout, newton_settings(run.scene, model_, [&run] { return run.stop_requested(); }),
                run.state.summary.n_threads, run.state.summary.timers) {
    run.log(fmt::format("stage {}: {} dofs", stage_.name, model_.layout.n_dofs()));
  }

  void begin() {
    run_.state.gauge.begin_stage(model_, run_.state.last_point.side_strain);
    run_.state.energy.begin_stage(model_);
    at_ = {{}, model_.start, model_.body_forces(model_.start)};
    run_.state.summary.stage_starts.push_back(
        curve_point(0, model_.start, model_.loads_at_start(run_.state.stage_start)));
  }

  /// What was begun with the stage is there again.
  void resume(const Resumption& resumption) {
    run_.state.stage_start.forget_contacts();
    at_ = take_up_stage(resumption, model_, newton_);
    run_.continuation = resumption.kept.bytes();  // should the run end before the next increment
    // Of a stage that is over its elements are asked for, as the last step has left them.
    if (at_.position.time >= 1) begin_at(model_.effects, at_.state, at_.position.time);
  }

  void follow() {
    State before = at_.state;
    StageDriver driver;
    driver.log = run_.options.log;
    driver.stop = [this] { return run_.stop_requested(); };
    driver.slack = [this](double to) { return tolerance_factor(stage_, is_last(), to); };
    driver.motion = [this](const State& state, double from, double to) { return model_.motion(state, from, to); };
    driver.accepted = [&](const State& accepted, const IncrementReport& report) {
      book(std::exchange(before, accepted), accepted, report.stage_time);
      return record(report) && !passes_a_turn();
    };
    const StageOutcome outcome = follow_path(driver);
    run_.state.stage_start = after_stage(stage_, model_, at_.state, std::move(run_.state.stage_start));
    // As they were found with the last increment: a run that goes on from its end looks for contacts anew.
    run_.state.stage_start.body_forces = at_.body_forces;
    look_at_end();
    if (outcome.status != StageOutcome::Status::done) end_early(outcome);
  }

 private:
  [[nodiscard]] bool is_last() const { return index_ + 1 == run_.scene.stages.size(); }

  [[nodiscard]] StageOutcome follow_path(const StageDriver& driver) {
    if (const std::string what = model_.surface_contact ? model_.surface_contact->behind_at(at_.state) : "";
        !what.empty())
      return {.status = StageOutcome::Status::gave_up,
              .reason = what + " as it begins",
              .stage_time = at_.position.time,
              .hopeless = true};
    // Increments end where drives turn: the path is left and taken up again for a shorter one.
    for (;;) {
      if (passes_a_turn()) at_.position.size = model_.next_turn(at_.position.time) - at_.position.time;
      StageOutcome outcome = micro::run_stage(newton_, model_.effects, load_path_settings(run_.scene, stage_, model_),
                                              driver, run_.state.summary.timers, at_.position, at_.state);
      if (outcome.status != StageOutcome::Status::interrupted || run_.stop_requested()) return outcome;
    }
  }

  /// Whether the next increment would go beyond a turn of a drive.
  [[nodiscard]] bool passes_a_turn() const {
    constexpr double hair = 1e-9;
    const StagePosition& at = at_.position;
    return at.time < 1 && at.time + at.size > model_.next_turn(at.time) + hair;
  }

  /// Enters an accepted increment into the energy books.
  void book(const State& before, const State& accepted, double stage_time) {
    EnergyAccount& energy = run_.state.energy;
    std::vector<double> forces = model_.body_forces(accepted);
    const std::vector<double> motion = body_motion(model_, before, accepted);
    energy.add(Source::bodies, external_work(model_, motion, at_.body_forces, forces));
    for (std::size_t i = 0; i < motion.size(); ++i) run_.state.motion[i] += motion[i];
    if (at_.position.n_accepted == 1) {
      StageModel at_start(run_.scene, run_.assembly, stage_, run_.state.stage_start);
      energy.add(Sink::release, released_energy(at_start, accepted, stage_time));
      run_.state.stage_start.forget_contacts();
    }
    energy.close(model_, accepted);
    at_.body_forces = std::move(forces);
  }

  /// Records an accepted increment, saves it and tells the watcher; returns whether to go on.
  bool record(const IncrementReport& report) {
    RunState& state = run_.state;
    const SolverRecord& solver = state.last_solver =
        record_solver(model_, at_.state, report, dimensional(state.energy.total(), run_.scales));
    state.summary.count(solver, model_.n_contact_elements());
    if (report.unstable && state.summary.n_unstable_increments == 1)
      state.first_unstable = fmt::format("in stage {} at stage time {:.4f}", stage_.name, report.stage_time);
    state.last_point = curve_point(report.stage_time, at_.state, at_.body_forces);
    state.last_point.energy = solver.energy;
    state.summary.curve.push_back(state.last_point);
    ++state.since_saved;
    run_.continuation = continuation(state, at_, model_, newton_, run_.options.changes, stage_, index_);
    const bool stop = run_.stop_requested();
    if (stop || report.stage_time >= 1 || state.since_saved >= stage_.save_every) save();
    if (run_.options.on_increment) run_.options.on_increment(progress(report.stage_time));
    return !stop;
  }

  [[nodiscard]] CurvePoint curve_point(double stage_time, const State& state,
                                       const std::vector<double>& body_forces) const {
    const Scales& scales = run_.scales;
    const auto [strain, force] = run_.state.gauge.read(model_, state);
    CurvePoint point{stage_.name, stage_time, strain, {force[0] * scales.force(), force[1] * scales.force()},
                     {},          {},         {}};
    for (std::size_t i = 0; i < body_forces.size(); ++i) {
      const bool turns = i % 6 >= 3;
      point.motion.push_back(run_.state.motion[i] * (turns ? 1 : scales.length));
      point.reaction.push_back(body_forces[i] * (turns ? scales.energy() : scales.force()));
    }
    return point;
  }

  void save() {
    RunState& state = run_.state;
    const auto guard = state.summary.timers.measure(Phase::io);
    FiberConfiguration configuration =
        state.stage_start.configuration;  // sections of rods go on from the stage's start
    model_.field.write_configuration(at_.state, configuration);
    run_.states->append({.stage = state.last_point.stage,
                         .stage_time = state.last_point.stage_time,
                         .fibers = dimensional(configuration, run_.scales),
                         .contacts = record_contacts(model_, at_.state, run_.scales),
                         .bodies = record_bodies(model_, at_.state, state.last_point.motion, run_.scales),
                         .sides = {state.last_point.side_strain, state.last_point.side_force},
                         .solver = state.last_solver},
                        run_.continuation);
    state.since_saved = 0;
  }

  [[nodiscard]] Progress progress(double stage_time) const {
    return {.stage = stage_.name,
            .stage_index = static_cast<Index>(index_),
            .n_stages = static_cast<Index>(run_.scene.stages.size()),
            .stage_time = stage_time,
            .fraction = run_.fraction(index_, stage_time),
            .begun_at = run_.begun_at,
            .increment = run_.state.summary.n_increments,
            .solver = &run_.state.last_solver,
            .n_contact_elements = model_.n_contact_elements()};
  }

  /// What there is to know of the stage's last state.
  void look_at_end() {
    SimulationSummary& summary = run_.state.summary;
    const CrossingCount crossings = count_crossings(model_, at_.state, run_.assembly);
    summary.n_crossings = crossings.n;
    summary.n_crossings_ok = crossings.n_in_order;
    summary.crossing_order_ok = crossings.n_in_order == crossings.n;
    if (const std::string text = held_back(stage_, is_last()); !text.empty()) run_.warn(text);
    for (const auto& effect : model_.effects)
      if (const std::string text = effect->doubt(at_.state); !text.empty())
        run_.warn(fmt::format("stage {}: {}", stage_.name, text));
    if (!model_.contact) return;
    const BuriedEnds ends = find_free_buried_ends(model_, at_.state, run_.assembly);
    summary.n_buried_ends = ends.n;
    if (ends.n > 0)
      run_.warn(fmt::format("stage {}: {} inside other fibers, where ends have no contact: {}", stage_.name,
                            ends.n == 1 ? "1 fiber end lies" : fmt::format("{} fiber ends lie", ends.n), ends.text));
  }

  void end_early(const StageOutcome& outcome) {
    SimulationSummary& summary = run_.state.summary;
    if (run_.state.since_saved > 0) {
      // The effects stand at the failed attempt: bring their contact elements back to the last good state.
      begin_at(model_.effects, at_.state, outcome.stage_time);
      save();
    }
    const bool gave_up = outcome.status == StageOutcome::Status::gave_up;
    summary.status = gave_up ? SimulationSummary::Status::gave_up : SimulationSummary::Status::interrupted;
    if (gave_up) summary.message = describe_failure(model_, stage_, outcome);
  }

  RunContext& run_;
  std::size_t index_;
  const Stage& stage_;
  StageModel model_;
  NewtonSolver newton_;
  StageState at_;
};

}  // namespace

double RunContext::fraction(std::size_t stage, double stage_time) const {
  double done = 0, all = 0;
  for (std::size_t i = state.first_stage; i < scene.stages.size(); ++i) {
    const double share = scene.stages[i].n_increments;
    all += share;
    done += i < stage ? share : i == stage ? share * stage_time : 0;
  }
  return done / all;
}

void run_stage(RunContext& run, std::size_t index, std::optional<Resumption>& resumption) {
  const bool resumes = resumption && resumption->at.within;
  if (!resumes) {
    place_leaders(run.assembly, run.scene.stages[index], run.state.stage_start.poses);
    place_touching(run.scene, run.assembly, run.scene.stages[index], run.state.stage_start);
  }
  StageRun stage(run, index);
  if (resumes) {
    stage.resume(*resumption);
    resumption.reset();
  } else {
    stage.begin();
  }
  stage.follow();
}

}  // namespace trame::micro
