#pragma once
/// \file
/// Loads on fibers from stage to stage: what is on stays on until a later stage has a load of the same name.

#include <string>
#include <vector>

#include "micro/core/archive.h"
#include "micro/fiber/fiber_loads.h"
#include "micro/weave/flat_start.h"

namespace trame::micro {

/// A load that is on as a stage begins or ends.
struct StandingLoad {
  std::string name;
  std::vector<Vec3> force;  ///< per length of the start configuration, of each fiber

  void keep(Archive& archive) { archive(name, force); }
};

/// A load through a stage.
struct LoadThroughStage {
  StandingLoad start, end;  ///< of the same name
  Amplitude amplitude = {};
};

/// The loads of a stage that finds `before`: those that it names, from what they were, and all others as they were.
/// Of gravity g, a fiber of density ρ and section A gets ρ A g.
[[nodiscard]] std::vector<LoadThroughStage> loads_through(const Scene& scene, const Assembly& assembly,
                                                          const Stage& stage, const std::vector<StandingLoad>& before);
/// What of it is not zero, fiber by fiber.
[[nodiscard]] std::vector<FiberLoadTerm> fiber_load_terms(const std::vector<LoadThroughStage>& loads);
/// What is on once the stage is over.
[[nodiscard]] std::vector<StandingLoad> standing_after(const std::vector<LoadThroughStage>& loads);
/// What is on after the first `n_stages` of a scene.
[[nodiscard]] std::vector<StandingLoad> standing_loads(const Scene& scene, const Assembly& assembly,
                                                       std::size_t n_stages);

/// Whether both are the same loads, up to the round-off of unit conversions.
[[nodiscard]] bool are_alike(const std::vector<StandingLoad>& a, const std::vector<StandingLoad>& b);

}  // namespace trame::micro
