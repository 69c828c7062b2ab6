#pragma once
/// \file
/// What a scene drives.

#include "micro/scene/scene.h"

namespace trame::micro {

/// A dof of a body that stages drive.
struct DrivenDof {
  Index body = 0;  ///< of `body_names`
  BodyDof dof = BodyDof::x;
  /// For each stage of the scene: how it is driven there; nothing where it is held.
  std::vector<std::optional<DriveMode>> modes;
};

/// All dofs that at least one stage drives, by body and axis.
[[nodiscard]] std::vector<DrivenDof> driven_dofs(const Scene& scene, const std::vector<std::string>& body_names);

}  // namespace trame::micro
