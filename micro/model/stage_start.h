#pragma once
/// \file
/// What a stage starts from: where fibers and bodies are, the forces on them, and the history of their contacts.

#include <vector>

#include "micro/contact/contact.h"
#include "micro/contact/surface_contact.h"
#include "micro/model/standing_loads.h"
#include "micro/rigid/rigid_body.h"
#include "micro/weave/flat_start.h"

namespace trame::micro {

struct StageModel;

struct StageStart {
  FiberConfiguration configuration;
  std::vector<Pose> poses;
  std::vector<double> body_forces;  ///< external force on each of the 6 dofs of each body
  std::vector<ContactHistory> contact_history;
  std::vector<Vec3> contact_tractions;
  std::vector<SurfaceContactHistory> surface_history;
  std::vector<StandingLoad> loads;  ///< on fibers
  bool just_separated = false;      ///< yarns were parted with vertical normals in the stage before

  /// Contacts are the effects' own, once the stage is under way.
  void forget_contacts();

  void keep(Archive& archive) {
    archive(configuration, poses, body_forces, contact_history, contact_tractions, surface_history, loads,
            just_separated);
  }
};

/// The start of a run's first stage, at the layout of the scene.
[[nodiscard]] StageStart start_of(const Assembly& assembly);

/// A body without ties that leads others stands at the middle of its followers when a stage begins.
void place_leaders(const Assembly& assembly, const Stage& stage, std::vector<Pose>& poses);

/// Bodies of planes and spheres that touch from this stage on are moved along their directions to where they do.
void place_touching(const Scene& scene, const Assembly& assembly, const Stage& stage, StageStart& start);

/// The start of the stage after `stage`, which ended at `state`; sections of rods go on from `start`, its own.
[[nodiscard]] StageStart after_stage(const Stage& stage, const StageModel& model, const State& state, StageStart start);

}  // namespace trame::micro
