#pragma once
/// \file
/// What is saved with each state to go on from there, to the bit, and back.

#include <filesystem>
#include <optional>
#include <string>

#include "micro/run/run_state.h"

namespace trame::micro {

/// Where a run stands, at the head of what is saved.
struct Milestone {
  std::string program;      ///< that wrote it
  std::string changes;      ///< SimulateOptions::changes
  std::uint64_t stage = 0;  ///< of the scene
  bool within = false;      ///< the stage is under way, or over; else it has not begun
  double stage_time = 0;
  Index since_saved = 0;   ///< accepted increments since the last that a run saves of itself; 0: this is one
  Index n_increments = 0;  ///< accepted

  void keep(Archive& archive) { archive(program, changes, stage, within, stage_time, since_saved, n_increments); }
};

/// Before the first stage that there is to run.
[[nodiscard]] std::string continuation(RunState& run, const std::string& changes);
/// After an accepted increment of stage number `index` of the scene.
[[nodiscard]] std::string continuation(RunState& run, StageState& at, StageModel& model, NewtonSolver& newton,
                                       const std::string& changes, const Stage& stage, std::size_t index);

/// A run that was left.
struct Resumption {
  std::filesystem::path states;
  Milestone at;
  Archive kept;        ///< what follows the milestone
  Index n_states = 0;  ///< saved states that the run would have had without the interruption
};

/// The run that `states` holds; nothing where there is no such file. Throws InputError where `scene` is not that run's,
/// but for stages behind the one that it has come to, or the file cannot be gone on from.
[[nodiscard]] std::optional<Resumption> find_resumption(const std::filesystem::path& states, const Scene& scene,
                                                        const std::string& changes);
/// The run as it was left. Reads from `resumption`, of which the stage under way remains. Throws InputError.
void take_up(Resumption& resumption, const Scene& scene, const Assembly& assembly, RunState& run);
/// The stage under way as it was left; what effects and solver keep goes to them. Throws InputError.
[[nodiscard]] StageState take_up_stage(const Resumption& resumption, StageModel& model, NewtonSolver& newton);

}  // namespace trame::micro
