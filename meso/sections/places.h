#pragma once
/// \file
/// Places along a yarn that have a name: where it passes others.

#include <string>
#include <vector>

#include "micro/fiber/fiber_mesh.h"

namespace trame::meso {

/// A fraction of the yarn's fibers' lengths, and what is there: "over weft/3", "under weft/3" or "between".
struct Place {
  double fraction = 0;
  std::string label;
};

/// Where the yarn passes others of the crossing family in this state, seen from above, and half-way between; at most
/// `most`, the middle ones. None for a yarn that crosses none.
[[nodiscard]] std::vector<Place> places(const micro::FiberMesh& mesh, const micro::FiberConfiguration& fibers,
                                        Index yarn, std::size_t most);

}  // namespace trame::meso
