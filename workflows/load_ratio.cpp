#include "workflows/load_ratio.h"

#include <fmt/format.h>

#include <cmath>

#include "micro/core/error.h"

namespace trame::workflows {

namespace {

std::vector<micro::Drive*> strain_drives(micro::Stage& stage, micro::BodyDof dof) {
  std::vector<micro::Drive*> found;
  for (micro::Drive& drive : stage.drives)
    if (drive.mode == micro::DriveMode::strain && drive.dof == dof) found.push_back(&drive);
  return found;
}

}  // namespace

micro::Scene with_weft_ratio(micro::Scene scene, double alpha) {
  if (!std::isfinite(alpha)) throw InputError(fmt::format("--alpha {}: must be a finite number", alpha));
  if (scene.stages.empty()) throw InputError(fmt::format("--alpha {}: scene {} has no stages", alpha, scene.name));
  micro::Stage& stage = scene.stages.back();
  const auto warp = strain_drives(stage, micro::BodyDof::x), weft = strain_drives(stage, micro::BodyDof::y);
  if (warp.empty() || weft.empty())
    throw InputError(fmt::format("--alpha {}: the last stage of scene {}, \"{}\", must drive strains along x and y",
                                 alpha, scene.name, stage.name));
  for (const micro::Drive* drive : warp)
    if (drive->value != warp.front()->value)
      throw InputError(
          fmt::format("--alpha {}: the strains along x in stage \"{}\" of scene {} must be equal, but are {} and {}",
                      alpha, stage.name, scene.name, warp.front()->value, drive->value));
  for (micro::Drive* drive : weft) drive->value = alpha * warp.front()->value;
  return scene;
}

}  // namespace trame::workflows
