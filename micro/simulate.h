#pragma once
/// \file
/// Runs a scene: builds the model, follows its load path, saves states.

#include "micro/run/options.h"
#include "micro/run/summary.h"
#include "micro/scene/scene.h"

namespace trame::micro {

/// Where a run begins.
struct StartPoint {
  std::size_t stage = 0;   ///< of the scene; the number of stages where nothing is left to do
  double stage_time = 0;   ///< done of that stage
  Index n_increments = 0;  ///< accepted before, by the run that is gone on with
};

/// Where the run would begin. Throws InputError where it cannot start from what the options name; touches nothing.
[[nodiscard]] StartPoint check_start(const Scene& scene, const SimulateOptions& options);

/// Runs `scene` and writes its states. A run that goes on (`resume`) leaves what it would have left without the
/// interruption, to the bit, but for times; the states it finds stay as they are until the next one is saved. A solver
/// that gives up is reported in `status`, with the last good state saved; so is a disk that is full after the first
/// state. Throws InputError where the scene and the options cannot be run, WriteError where not even the first state
/// can be written.
[[nodiscard]] SimulationSummary simulate(const Scene& scene, const SimulateOptions& options);

}  // namespace trame::micro
