#pragma once
/// \file
/// Weave patterns: one repeat as rows of weft yarns and columns of warp yarns, true where the warp yarn passes above.

#include <vector>

#include "micro/core/types.h"

namespace trame::micro {

using WeavePattern = std::vector<std::vector<bool>>;

/// Of each warp yarn, how many layers of weft it passes above, column by column of weft.
using WarpLevels = std::vector<std::vector<Index>>;

/// A row for each weft yarn, column by column, in a column layer by layer from below.
[[nodiscard]] WeavePattern layered_pattern(const WarpLevels& levels, Index n_layers);

/// Twill in which a warp yarn passes above floats[0] weft yarns, below floats[1], above floats[2] and so on, and each
/// warp yarn does so one weft yarn later than the one before it. {1, 1} is plain weave, {2, 2} the common twill. All
/// floats are at least 1.
[[nodiscard]] WeavePattern twill_pattern(const std::vector<Index>& floats);

/// Warp-faced satin: weft yarn i passes above warp yarn i·step (mod harnesses) and below all others.
/// harnesses and step have no common divisor.
[[nodiscard]] WeavePattern satin_pattern(Index harnesses, Index step);

/// Whether (harnesses, step) is a satin: no common divisor, and 1 < step < harnesses − 1, which would be twills.
[[nodiscard]] bool is_satin(Index harnesses, Index step);

/// `repeat` continued over n_weft rows and n_warp columns, from row first_weft and column first_warp on.
[[nodiscard]] WeavePattern continued(const WeavePattern& repeat, Index n_weft, Index n_warp, Index first_weft = 0,
                                     Index first_warp = 0);

}  // namespace trame::micro
