#include "micro/scene/weaving_stages.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "micro/scene/weave.h"
#include "micro/scene/yarn_section.h"

namespace trame::micro {

namespace {

double radius_of(const Scene& scene, const YarnKind& kind) { return scene.fiber_types[kind.type].radius; }

/// E A of the fibers of a system's weakest yarn.
double axial_stiffness(const Scene& scene, const YarnSystem& yarns) {
  double least = std::numeric_limits<double>::infinity();
  for (const YarnKind& kind : yarns.kinds) {
    const Material& material = scene.materials[scene.fiber_types[kind.type].material];
    const double r = radius_of(scene, kind);
    least = std::min(least, kind.n_fibers * material.young_modulus_axial * std::numbers::pi * r * r);
  }
  return least;
}

/// To two digits, so that a person can read it and write it.
double rounded(double x) {
  const double unit = std::pow(10, std::floor(std::log10(x)) - 1);
  return std::round(x / unit) * unit;
}

/// Both ends of all yarns are pulled outward; in a periodic cell, all yarns at once.
std::vector<Drive> pulls(const Weave& weave, double warp, double weft) {
  std::vector<Drive> drives;
  const auto add = [&](const YarnSystem& yarns, const std::string& family, BodyDof axis, double pull) {
    if (yarns.periodic) {
      drives.push_back({period_name(family == "warp"), axis, DriveMode::force, yarns.n_yarns * pull, "", {}});
      return;
    }
    drives.push_back({family + "/*/start", axis, DriveMode::force, -pull, "", {}});
    drives.push_back({family + "/*/end", axis, DriveMode::force, pull, "", {}});
  };
  add(weave.warp, "warp", BodyDof::x, warp);
  add(weave.weft, "weft", BodyDof::y, weft);
  return drives;
}

}  // namespace

std::vector<Stage> weaving_stages(const Scene& scene) {
  constexpr double radii_an_increment = 1.0 / 3, pull_share = 5e-5, later_share = 0.1, damping = 1e-2;
  constexpr Index least_increments = 12, most_increments = 100;
  const Weave& weave = *scene.weave;
  double radius = std::numeric_limits<double>::infinity();
  for (const YarnSystem* yarns : {&weave.warp, &weave.weft})
    for (const YarnKind& kind : yarns->kinds) radius = std::min(radius, radius_of(scene, kind));
  const double rise = start_heights(scene).deepest + 2 * radius;
  const double warp = rounded(pull_share * axial_stiffness(scene, weave.warp)),
               weft = rounded(pull_share * axial_stiffness(scene, weave.weft));

  Stage separate;
  separate.name = "separate";
  separate.separate_yarns = true;
  separate.friction = false;
  separate.n_increments = static_cast<Index>(
      std::clamp<double>(std::ceil(rise / radius / radii_an_increment), least_increments, most_increments));
  separate.proximal_start = separate.proximal_end = damping;
  separate.fiber_model = FiberModel::rod;
  separate.drives = pulls(weave, warp, weft);

  Stage relax;
  relax.name = "relax";
  relax.n_increments = 12;
  relax.friction = scene.contact.friction;
  relax.proximal_start = damping;
  relax.fiber_model = FiberModel::rod;
  relax.drives = pulls(weave, later_share * warp, later_share * weft);

  Stage settle = relax;
  settle.name = "settle";
  settle.n_increments = 4;
  settle.fiber_model.reset();
  return {separate, relax, settle};
}

}  // namespace trame::micro
