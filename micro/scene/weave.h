#pragma once
/// \file
/// Part of reading a scene: its weave.

#include <array>
#include <filesystem>
#include <string>

#include "micro/scene/keys.h"
#include "micro/scene/pattern.h"
#include "micro/scene/scene.h"

namespace trame::micro {

/// "2/2" or "3/1/1/1": an even number of floats of a twill.
[[nodiscard]] Kind<std::vector<Index>> twill_floats();

/// Rows of 0 and 1.
[[nodiscard]] Kind<WeavePattern> pattern_matrix();

/// Rows of X and dots, as a list or as lines of one text.
[[nodiscard]] Kind<WeavePattern> pattern_picture();

/// Lists of integers.
[[nodiscard]] Kind<WarpLevels> warp_levels();

/// The angle from the warp to the weft: not so small that yarns hardly cross.
[[nodiscard]] Kind<double> crossing_angle();

/// Kinds of yarn that [yarn.NAME] describes. Needs the fiber types of `scene`.
[[nodiscard]] std::vector<YarnKind> read_yarn_kinds(const SceneValue& root, const Scene& scene);

/// Reads [weave]. Needs the fiber types of `scene` and the kinds of yarn. `folder` is that of the scene's file; empty
/// where there is none.
[[nodiscard]] Weave read_weave(const SceneValue& table, const Scene& scene, const std::vector<YarnKind>& kinds,
                               const std::filesystem::path& folder);

/// What can stand in a scene instead of pattern_file, so that the scene's text says all: `picture`, of the size of the
/// patch, turned so that `first_weft` and `first_warp`, counted from 1, are yarns 1 of `weave`.
[[nodiscard]] std::string picture_instead(const std::string& pattern_file, const Weave& weave, Index first_weft,
                                          Index first_warp);

/// Names of a weave's yarns: warp/1 … then weft/1 …
[[nodiscard]] std::vector<std::string> yarn_names(const Weave& weave);

[[nodiscard]] inline bool is_warp(const std::string& yarn) { return yarn.starts_with("warp/"); }

/// Name of the body that stands for the period vector of a cell along its warp, or along its weft.
[[nodiscard]] constexpr const char* period_name(bool along_warp) { return along_warp ? "cell/warp" : "cell/weft"; }
[[nodiscard]] inline bool is_period(const std::string& body) {
  return body == period_name(true) || body == period_name(false);
}

/// Width of the laid out patch across its warp, or across its weft.
[[nodiscard]] double cell_width(const Weave& weave, bool across_warp);

/// Names of the bodies that a weave makes: an end of each yarn, a side of the patch for each end of each yarn system;
/// for systems that come back to where they start a period instead.
[[nodiscard]] std::vector<std::string> weave_body_names(const Weave& weave);

}  // namespace trame::micro
