#pragma once
/// \file
/// Runs that begin where a stage of another run ended: weave once, pull in many ways.

#include "micro/model/model.h"
#include "micro/states/snapshot.h"

namespace trame::micro {

struct Restart {
  std::size_t next_stage = 0;  ///< of the scene: the one after the stage that the other run has done
  Increment reference, state;  ///< the other run's start, and the end of that stage
  StageStart start;            ///< the same end, in natural units
};

/// Finds the end of stage `after` in `states`, which must hold the fibers of this scene and no body that it lacks, and
/// takes from it positions, sections, poses, forces, loads and the history of every contact. A body that the states
/// lack stands where the ends that it ties have taken it. `scene` and `assembly` are in natural units. Throws
/// InputError where the states are of other fibers or bodies, have not finished that stage or other loads at its end,
/// or the scene has none of that name or nothing after it.
[[nodiscard]] Restart restart_after(const std::string& after, const SnapshotReader& states, const Scene& scene,
                                    const Assembly& assembly, const Scales& scales);

}  // namespace trame::micro
