#pragma once
/// \file
/// Where the fibers of a yarn stand in its section, and how near two yarns can lie beside each other.

#include <optional>
#include <vector>

#include "micro/scene/scene.h"

namespace trame::micro {

/// Centres of n fibers on a hexagonal lattice of spacing a, centred on the origin: in `n_layers` rows (second
/// coordinate), or, for n_layers = 0, the n points nearest to the origin.
[[nodiscard]] std::vector<Vec2> hexagonal_section(Index n, Index n_layers, double a);

/// Centres of n fibers of radius 1 at random, a little apart from each other, in an outline of which they fill
/// `volume_fraction`: a circle, or for n_layers > 0 a rectangle with the proportions of so many rows. Nothing where no
/// such lay was found. The same on every machine.
[[nodiscard]] std::optional<std::vector<Vec2>> random_section(Index n, Index n_layers, double volume_fraction,
                                                              std::uint64_t seed);

/// Section of a yarn of a kind whose fibers have this radius; yarns of random lay differ by their number. Throws
/// InputError where no such lay was found.
[[nodiscard]] std::vector<Vec2> yarn_section(const YarnKind& kind, double radius, Index yarn);

/// Height of a flat yarn of the kind, fibers included; twisted yarns are as high as they are wide.
[[nodiscard]] double yarn_height(const YarnKind& kind, double radius);

/// Height of the highest yarn of a system.
[[nodiscard]] double system_height(const Scene& scene, const YarnSystem& yarns);

/// Where the yarns of a weave start in height, above the middle. Those of a weave of one layer start at 0; layers of
/// weft so far apart that a warp yarn fits between them, warp yarns at their mean level.
struct StartHeights {
  std::vector<double> warp, weft;  ///< of each yarn
  double deepest = 0;              ///< how deep yarns start in those that they shall part from, at most
};
[[nodiscard]] StartHeights start_heights(const Scene& scene);

/// Least distance of the axes of two yarns at which none of their fibers overlap, the first one at smaller coordinates.
[[nodiscard]] double least_yarn_spacing(const YarnKind& a, double radius_a, const YarnKind& b, double radius_b);

}  // namespace trame::micro
