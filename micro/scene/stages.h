#pragma once
/// \file
/// Parts of reading a scene: its bodies with their ties, and its stages with their drives and loads.

#include "micro/scene/scene.h"
#include "micro/scene/value.h"

namespace trame::micro {

/// Adds a name; fails for one that `known` holds already.
void add_new_name(const SceneValue& named, const std::string& name, NameTable& known);

/// Bodies in the order of the assembled scene: those of the weave, then those of [[body]].
[[nodiscard]] NameTable body_names(const Scene& scene);

/// Fills scene.bodies from [[body]]. Needs the fibers, bundles and the weave.
void read_bodies(const SceneValue& root, const std::filesystem::path& folder, Scene& scene);

[[nodiscard]] bool has_surfaces(const Scene& scene);

/// Fails for surfaces that wait for a stage which there is not, and for those that a periodic weave cannot have.
void check_surfaces(const SceneValue& root, const Scene& scene);

/// Number of a stage by its name, and of the first one in which a surface is there; that of all stages where there is
/// none of that name.
[[nodiscard]] std::size_t stage_number(const Scene& scene, const std::string& name);
[[nodiscard]] std::size_t first_stage(const Scene& scene, const SurfaceSpec& surface);

/// Fills scene.stages from [[stage]], or for a weave without any with those that weave it. Needs the bodies and the
/// effects.
void read_stages(const SceneValue& root, Scene& scene);

/// Fails where all stages, with that of [test], have more increments than a run can keep.
void check_increments(const SceneValue& root, const Scene& scene);

}  // namespace trame::micro
