#pragma once
/// \file
/// Curves as gnuplot draws them, for curves.svg and for the report.

#include <filesystem>
#include <string>
#include <vector>

#include "workflows/curves/branches.h"

namespace trame::workflows {

/// What curves of a kind are drawn on: labels with units.
struct Axes {
  std::string motion, reaction;
};
[[nodiscard]] Axes axes_of(const Curve& curve);

/// Curves of this kind that move, those that took most work first, but warp before weft; at most `most`.
[[nodiscard]] std::vector<Curve> curves_to_draw(const CurveKind& kind, const std::vector<Curve>& curves,
                                                std::size_t most = 8);

/// What draws curves of the same axes in a colour each: loading solid, unloading dashed. Numbers are in the script,
/// because gnuplot does not read every CSV table right. Empty where nothing moves.
[[nodiscard]] std::string plot_commands(const std::vector<Curve>& curves);

/// Writes curves.gp to the folder, for anyone to adapt, and runs gnuplot on it for curves.svg: the curve of a
/// test, or those of the sides; without any those of the dof that took most work and what shares its axes. False where
/// gnuplot is missing or fails; nothing to draw needs no picture.
[[nodiscard]] bool plot_curves(const std::filesystem::path& folder, const std::vector<Curve>& curves,
                               const std::string& title);

}  // namespace trame::workflows
