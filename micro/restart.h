#pragma once
/// \file
/// Runs that do not begin at the scene's start: where a stage of another run ended (weave once, pull in many ways), or
/// where they were left themselves.

#include "micro/core/archive.h"
#include "micro/states/snapshot.h"
#include "micro/model.h"

namespace trame::micro {

struct Restart {
  std::size_t next_stage = 0;  ///< of the scene: the one after the stage that the other run has done
  Increment reference, state;  ///< the other run's start, and the end of that stage
  Carried carried;             ///< the same end, in natural units
};

/// Finds the end of stage `after` in `states`, which must hold the fibers of this scene and no body that it lacks, and
/// takes from it positions, sections, poses, forces and the history of every contact. A body that the states lack
/// stands where the ends that it ties have taken it. `scene` and `assembly` are in natural units. Throws InputError
/// where the states are of other fibers or bodies, have not finished that stage, or the scene has none of that name or
/// nothing after it.
[[nodiscard]] Restart restart_after(const std::string& after, const SnapshotReader& states, const Scene& scene,
                                    const Assembly& assembly, const Scales& scales);

/// Where a run stands, at the head of what is saved to go on from there.
struct Milestone {
  std::string program;         ///< that wrote it
  std::string changes;         ///< SimulateOptions::changes
  std::uint64_t stage = 0;     ///< of the scene
  bool within = false;         ///< the stage is under way, or over; else it has not begun
  double stage_time = 0;
  Index since_saved = 0;       ///< accepted increments since the last that a run saves of itself; 0: this is one
  Index n_increments = 0;      ///< accepted

  void keep(Archive& archive) {
    archive(program, changes, stage, within, stage_time, since_saved, n_increments);
  }
};

/// What to call the program in a milestone: what it goes on with must have been written by the same.
[[nodiscard]] std::string program_of_milestones();

/// A run that was left.
struct Resumption {
  Milestone at;
  Archive kept;              ///< what follows the milestone
  Index n_states = 0;        ///< saved states that the run would have had without the interruption
};

/// The run that `states` holds; nothing where there is no such file. Throws InputError where `scene` is not that run's,
/// but for stages behind the one that it has come to, or the file cannot be gone on from.
[[nodiscard]] std::optional<Resumption> find_resumption(const std::filesystem::path& states, const Scene& scene,
                                                        const std::string& changes);

}  // namespace trame::micro
