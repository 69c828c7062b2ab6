#pragma once
/// \file
/// What each effect of a scene will cost, before anything runs: for `--check`. Orders of magnitude.
///
/// The model of every stage is built at the start configuration, contacts are looked for and the matrix is analysed, so
/// unknowns, couplings and the fill of the factor are counted, not guessed. Guessed is how often: Newton iterations,
/// detections. What fibers cost is the matrix of fibers that do not touch; what contact costs is what the matrix costs
/// more because they do.

#include <cstdint>
#include <vector>

#include "micro/scene/scene.h"

namespace trame::micro {

/// Effects with a price of their own.
enum class PricedEffect : std::uint8_t {
  enriched_beams,
  rods,
  twist_stretch,
  contact,
  self_contact,
  friction,
  adaptation,
  crossing_order,
  surfaces,
  bodies,
  follow,
  loads,
  fiber_loads,
  proximal
};
inline constexpr int n_priced_effects = 14;

struct EffectCost {
  PricedEffect effect{};
  std::int64_t n_dofs = 0;  ///< unknowns that it brings, in the stage with most of them
  double seconds = 0;       ///< of the whole run on two cores of 2025
  double bytes = 0;         ///< in the stage with most of them
};

struct CostEstimate {
  std::vector<EffectCost> effects;  ///< those that some stage calls for
  double seconds = 0, bytes = 0;    ///< of the whole run: effects, program, states and files
  bool extrapolated = false;        ///< from fewer fibers or elements, because looking at all of them would take long
};

/// Throws InputError where the scene cannot be laid out or driven.
[[nodiscard]] CostEstimate estimate_cost(const Scene& scene);

}  // namespace trame::micro
