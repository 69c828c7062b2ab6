#include <cmath>
#include <limits>

#include "meso/fabric/fabric_facts.h"
#include "micro/core/error.h"
#include "micro/scene/scene.h"

namespace trame::meso {

std::vector<double> fiber_densities(const micro::SnapshotHeader& header) {
  const micro::FiberMesh& mesh = header.mesh;
  std::vector<double> density(static_cast<std::size_t>(mesh.n_fibers()), std::numeric_limits<double>::quiet_NaN());
  if (header.version.empty()) return density;
  micro::Scene scene;
  try {
    scene = micro::parse_scene(header.scene_text, header.scene_name);
  } catch (const InputError&) {  // of an older program
    return density;
  }
  if (!scene.weave) return density;
  Index n_warp = 0, n_weft = 0;
  for (const micro::Yarn& yarn : mesh.yarns) {
    if (yarn.family == micro::YarnFamily::free) continue;
    const bool is_warp = yarn.family == micro::YarnFamily::warp;
    const micro::YarnKind& kind = is_warp ? scene.weave->warp.kind_of(n_warp++) : scene.weave->weft.kind_of(n_weft++);
    const double known = scene.materials[scene.fiber_types[kind.type].material].density;
    for (Index f = yarn.first_fiber; f < yarn.first_fiber + yarn.n_fibers; ++f)
      if (known > 0) density[f] = known;
  }
  return density;
}

}  // namespace trame::meso
