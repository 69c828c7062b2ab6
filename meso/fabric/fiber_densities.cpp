#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "meso/fabric/fabric_facts.h"
#include "micro/core/error.h"
#include "micro/scene/scene.h"

namespace trame::meso {

namespace {

/// The scene of a weave; nothing where the states have none, or one of an older program.
std::optional<micro::Scene> woven_scene(const micro::SnapshotHeader& header) {
  if (header.version.empty()) return std::nullopt;
  try {
    micro::Scene scene = micro::parse_scene(header.scene_text, header.scene_name);
    return scene.weave ? std::optional(std::move(scene)) : std::nullopt;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

}  // namespace

Index weft_layers(const micro::SnapshotHeader& header) {
  const std::optional<micro::Scene> scene = woven_scene(header);
  return scene ? scene->weave->weft.n_layers : 1;
}

std::vector<double> fiber_densities(const micro::SnapshotHeader& header) {
  const micro::FiberMesh& mesh = header.mesh;
  std::vector<double> density(static_cast<std::size_t>(mesh.n_fibers()), std::numeric_limits<double>::quiet_NaN());
  const std::optional<micro::Scene> scene = woven_scene(header);
  if (!scene) return density;
  Index n_warp = 0, n_weft = 0;
  for (const micro::Yarn& yarn : mesh.yarns) {
    if (yarn.family == micro::YarnFamily::free) continue;
    const bool is_warp = yarn.family == micro::YarnFamily::warp;
    const micro::YarnKind& kind = is_warp ? scene->weave->warp.kind_of(n_warp++) : scene->weave->weft.kind_of(n_weft++);
    const double known = scene->materials[scene->fiber_types[kind.type].material].density;
    for (Index f = yarn.first_fiber; f < yarn.first_fiber + yarn.n_fibers; ++f)
      if (known > 0) density[f] = known;
  }
  return density;
}

}  // namespace trame::meso
