#include "micro/simulate.h"

#include <fmt/format.h>

#include <memory>
#include <new>
#include <optional>
#include <utility>

#include "micro/core/error.h"
#include "micro/run/record.h"
#include "micro/run/restart.h"
#include "micro/run/stage_run.h"
#include "micro/solve/threads.h"

namespace trame::micro {

namespace {

using Status = SimulationSummary::Status;

/// A run, from a scene to states.
class Run {
 public:
  /// Writes nothing before `follow_load_path`.
  Run(const Scene& scene, const SimulateOptions& options)
      : threads_(options.n_threads),
        run_(scene, options), header_{TRAME_VERSION, scene.name, scene.text,
                                      dimensional(run_.assembly.mesh, run_.scales), run_.assembly.body_names} {
    run_.state.summary.size = model_size(scene);
    run_.state.summary.n_threads = threads_.n();
    if (options.resume) resumption_ = find_resumption(options.states, scene, options.changes);
    if (resumption_) {
      take_up(*resumption_, run_.scene, run_.assembly, run_.state);
    } else if (options.start_from.empty()) {
      run_.state.stage_start = start_of(run_.assembly);
    } else {
      restart_ =
          restart_after(options.after, SnapshotReader(options.start_from), run_.scene, run_.assembly, run_.scales);
      run_.state.stage_start = restart_->start;
      run_.state.first_stage = restart_->next_stage;
    }
  }

  [[nodiscard]] StartPoint start() const {
    if (!resumption_) return {run_.state.first_stage, 0, 0};
    const Milestone& at = resumption_->at;
    const bool is_over = at.within && at.stage_time >= 1;
    return {at.stage + (is_over ? 1 : 0), is_over || !at.within ? 0 : at.stage_time, at.n_increments};
  }

  /// Builds the stage that is gone on with, and reads all that is kept of it.
  void check_resumption() {
    if (!resumption_ || !resumption_->at.within) return;
    StageModel model(run_.scene, run_.assembly, run_.scene.stages[resumption_->at.stage], run_.state.stage_start);
    NewtonSolver newton(model.layout, {}, 1, run_.state.summary.timers);
    (void)take_up_stage(*resumption_, model, newton);
  }

  SimulationSummary follow_load_path() {
    begin_states();
    if (const StartPoint at = start(); at.stage < run_.scene.stages.size())
      run_.begun_at = run_.fraction(at.stage, at.stage_time);
    SimulationSummary& summary = run_.state.summary;
    const std::size_t first = resumption_ ? resumption_->at.stage : run_.state.first_stage,
                      n = run_.scene.stages.size();
    for (std::size_t i = first; i < n && summary.status == Status::done; ++i) {
      run_as_far_as_it_goes(i);
      if (run_.stop_requested() && i + 1 < n && summary.status == Status::done) summary.status = Status::interrupted;
    }
    if (summary.n_unstable_increments > 0)
      run_.warn(fmt::format(
          "{} of {} increments ended in an equilibrium that is known to be unstable, the first one {}: a small "
          "disturbance, say a slight bow, would lead elsewhere",
          summary.n_unstable_increments, summary.n_increments, run_.state.first_unstable));
    return std::move(summary);
  }

 private:
  void begin_states() {
    const SimulateOptions& options = run_.options;
    if (!options.resume && std::filesystem::exists(options.states))
      throw InputError(options.states.string() + ": exists already; remove it or choose another name");
    run_.states = std::make_unique<StateFile>(options.states, header_);
    if (resumption_) {
      const SnapshotReader before(options.states);
      for (Index i = 0; i < resumption_->n_states; ++i) run_.states->repeat(before.read(i));
      return;
    }
    // Strains between the flat start and any later state shall be had from this run's states alone.
    if (restart_) run_.states->repeat(restart_->reference);
    if (restart_) run_.state.energy = EnergyAccount(natural(restart_->state.solver.energy, run_.scales));
    run_.continuation = continuation(run_.state, options.changes);
    run_.states->append(restart_ ? restart_->state : start_record(run_.state.stage_start, run_.scales),
                        run_.continuation);
  }

  /// What the machine lacks ends a run, but not what it has saved.
  void run_as_far_as_it_goes(std::size_t stage) {
    SimulationSummary& summary = run_.state.summary;
    const auto end = [&](Status status, const std::string& why, bool is_saved = true) {
      summary.status = status;
      summary.message = why;
      if (is_saved && summary.n_increments > 0)
        summary.message += ". Once there is room, --resume goes on from the last state that is saved";
    };
    try {
      run_stage(run_, stage, resumption_);
    } catch (const LostError& error) {
      end(Status::cannot_write, error.what(), false);
    } catch (const WriteError& error) {
      end(Status::cannot_write, error.what());
    } catch (const std::bad_alloc&) {
      end(Status::gave_up, "there is not enough memory to go on");
    }
  }

  Threads threads_;
  RunContext run_;
  SnapshotHeader header_;
  std::optional<Restart> restart_;
  std::optional<Resumption> resumption_;  // until the run goes on
};

}  // namespace

StartPoint check_start(const Scene& scene, const SimulateOptions& options) {
  Run run(scene, options);
  run.check_resumption();
  return run.start();
}

SimulationSummary simulate(const Scene& scene, const SimulateOptions& options) {
  if (scene.fibers.empty() && scene.bundles.empty() && !scene.weave)
    throw InputError(
        fmt::format("{}: there is no fiber; a scene must have at least one fiber, bundle or weave", scene.name));
  return Run(scene, options).follow_load_path();
}

}  // namespace trame::micro
