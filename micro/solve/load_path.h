#pragma once
/// \file
/// Advances a stage from time 0 to 1 in increments that are cut where they fail.

#include <functional>
#include <optional>
#include <string>

#include "micro/solve/newton.h"

namespace trame::micro {

struct LoadPathSettings {
  // A stage's own; there are no others.
  int n_increments = 0;           ///< wanted
  int max_geometry_updates = 0;   ///< times that contact found anew undoes an equilibrium, in an increment
  double friction_tolerance = 0;  ///< residual once limits of friction are renewed: forces are in balance before that
  double min_increment = 0;       ///< of stage time
  double prediction_cap = 0;      ///< largest motion of a first guess, in the unit of length

  int max_detours = 60;      ///< detections in an increment on the way, where fibers move far
  int max_holds = 50;        ///< times that fibers are held anew where they have been found to move on
  int max_stiffenings = 12;  ///< of penalties and preloads in an increment
};

/// What the solver did for one increment.
struct IncrementReport {
  double stage_time = 0;
  int n_newton_iterations = 0, n_factorizations = 0, n_geometry_updates = 0;
  int n_cuts = 0;         ///< failed attempts since the last accepted increment; their iterations are counted
  int n_stiffenings = 0;  ///< times that equilibrium was found again as contact was too soft
  double residual = 0;    ///< relative, with the contacts of the final state
  bool unstable = false;  ///< the equilibrium is known to be unstable; looked at where Newton's method met an
                          ///< indefinite tangent, and at the stage's end
  double seconds = 0;
};

/// How the driver of a stage takes part.
struct StageDriver {
  /// Motion of the prescribed dofs to stage time `to`: of translations from `state`, of rotations from stage time
  /// `from`.
  std::function<PrescribedMotion(const State& state, double from, double to)> motion;
  /// An increment has converged and is committed; return false to end here.
  std::function<bool(const State& state, const IncrementReport& report)> accepted;
  /// Factor of the tolerances in an increment to stage time `to`: more than 1 where it need not end in equilibrium.
  std::function<double(double to)> slack = [](double) { return 1; };
  std::function<void(const std::string&)> log;  ///< may be empty
  std::function<bool()> stop = [] {
    return false;
  };  ///< whether an increment that failed is the end; see NewtonSettings
};

/// How far a stage has come, and what the next step is made from beside the state and what effects keep.
struct StagePosition {
  double time = 0;       ///< reached
  double size = 0;       ///< of the next step; 0: as the settings say
  double last_size = 0;  ///< of the last step
  int n_accepted = 0;
  State before;  ///< the accepted state before the last one

  void keep(Archive& archive) { archive(time, size, last_size, n_accepted, before); }
};

struct StageOutcome {
  enum class Status : std::uint8_t { done, interrupted, gave_up } status = Status::done;
  std::string reason{};   ///< why it gave up
  double stage_time = 0;  ///< reached
  std::optional<Index>
      worst_dof{};        ///< where the residual of the last failure is largest; nothing where `reason` says where
  bool hopeless = false;  ///< gave up before the smallest allowed increment, which would not help
};

/// Begins a step to stage time `to` at `state`, with what there is to act on at that state.
void begin_at(Effects& effects, const State& state, double to);

/// Runs a stage from `position` on, at its start or where it was left, on `state`. At the end both are those of the
/// last accepted increment; the driver meets them so with each.
StageOutcome run_stage(NewtonSolver& newton, Effects& effects, const LoadPathSettings& settings,
                       const StageDriver& driver, Timers& timers, StagePosition& position, State& state);

}  // namespace trame::micro
