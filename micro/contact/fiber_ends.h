#pragma once
/// \file
/// Ends of fibers that went into other fibers. Contact knows flanks only: nothing stops an end, so that it must be
/// looked for.

#include <functional>

#include "micro/fiber/fiber_field.h"

namespace trame::micro {

/// An end of `fiber` whose centre lies in the cylinder of another fiber, beside arc length `s` of that.
struct BuriedEnd {
  Index fiber = 0;
  FiberEnd end = FiberEnd::start;
  Index inside = 0;
  double s = 0;
};

/// All ends that are buried, by fiber and end, each named once. `together` (fiber, end, other): pairs that are not
/// looked at.
[[nodiscard]] std::vector<BuriedEnd> find_buried_ends(const FiberField& field, const State& state,
                                                      const std::function<bool(Index, FiberEnd, Index)>& together);

}  // namespace trame::micro
