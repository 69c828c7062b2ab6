#pragma once
/// \file
/// Weaving drafts in the Weaving Information File format, WIF 1.1: which shafts a warp yarn is threaded on, and which
/// shafts each weft yarn (pick) finds lifted. Colours, thicknesses and the rest are not read.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "micro/scene/pattern.h"

namespace trame::micro {

struct Draft {
  std::vector<std::vector<Index>> threading;  ///< shafts of each warp yarn, ascending
  std::vector<std::vector<Index>> lifts;      ///< shafts that each pick moves, ascending
  bool rising_shed = true;                    ///< they go up; else they go down

  [[nodiscard]] Index n_warp() const { return static_cast<Index>(threading.size()); }
  [[nodiscard]] Index n_weft() const { return static_cast<Index>(lifts.size()); }
  /// A warp yarn is above where one of its shafts is up: where the pick moves one of them in a rising shed, none of
  /// them in a sinking one.
  [[nodiscard]] bool warp_above(Index weft, Index warp) const;
};

/// Reads a draft as weaving programs do: names of sections and keys in any case, comments from ";" on, sections in any
/// order and whatever [CONTENTS] claims, yarns counted from 1 or from 0. Yarns after the last one that is threaded or
/// treadled do not count, whatever [WARP] and [WEFT] claim. Lifts are those of [LIFTPLAN], else of [TREADLING] through
/// [TIEUP], else of [TREADLING] with a shaft to each treadle. Throws InputError with origin, section and line where the
/// draft contradicts itself or lacks something; `origin` stands for the file name.
[[nodiscard]] Draft parse_draft(std::string_view wif, const std::string& origin);
[[nodiscard]] Draft read_draft(const std::filesystem::path& file);

/// What is woven from yarn `first_…` on (from 0), and from the draft's start again where it ends.
[[nodiscard]] WeavePattern pattern_of(const Draft& draft, Index first_weft, Index first_warp, Index n_weft,
                                      Index n_warp);

}  // namespace trame::micro
