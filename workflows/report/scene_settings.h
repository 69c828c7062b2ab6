#pragma once
/// \file
/// What the report says about the scene of a run.

#include <optional>
#include <string>

#include "micro/scene/scene.h"
#include "micro/states/snapshot.h"

namespace trame::workflows {

/// The scene that states were computed from; nothing for states from elsewhere, and where its text is not one that this
/// version reads. Reading takes time: once a report.
[[nodiscard]] std::optional<micro::Scene> scene_of(const micro::SnapshotHeader& header);

/// Title of the scene, or its name where there is none. In all that follows, `scene` is `scene_of(header)`.
[[nodiscard]] std::string scene_title(const micro::SnapshotHeader& header, const std::optional<micro::Scene>& scene);

/// Yarns, stages and contact of the scene at a glance, and its text to unfold.
[[nodiscard]] std::string settings_html(const micro::SnapshotHeader& header, const std::optional<micro::Scene>& scene);

}  // namespace trame::workflows
