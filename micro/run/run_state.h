#pragma once
/// \file
/// What a run carries from increment to increment, beside what effects and solver keep. Whatever is here, and nothing
/// else, is saved with each state to go on from there.

#include "micro/run/energy_account.h"
#include "micro/run/side_gauge.h"
#include "micro/run/summary.h"

namespace trame::micro {

/// From stage to stage.
struct RunState {
  explicit RunState(const Assembly& assembly) : gauge(assembly), motion(6 * assembly.body_names.size(), 0.0) {
    summary.body_names = assembly.body_names;
  }

  std::uint64_t first_stage = 0;  ///< of the scene, with which the run began
  EnergyAccount energy;
  SideGauge gauge;
  std::vector<double> motion;  ///< of bodies since the run began, six numbers each; not what happens between stages
  StageStart stage_start;      ///< of the stage under way, or of the next one
  SimulationSummary summary;
  std::string first_unstable;  ///< where and when
  CurvePoint last_point;       ///< of the last accepted increment
  SolverRecord last_solver;
  Index since_saved = 0;  ///< increments; kept in the milestone

  void keep(Archive& archive) {
    archive(first_stage, energy, gauge, motion, stage_start, summary, first_unstable, last_point, last_solver);
  }
};

/// Within a stage.
struct StageState {
  StagePosition position;
  State state;
  std::vector<double> body_forces;  ///< at `state`

  void keep(Archive& archive) { archive(position, state, body_forces); }
};

}  // namespace trame::micro
