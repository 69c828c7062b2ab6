#pragma once
/// \file
/// Picture of the force-strain curves, drawn by gnuplot where it is installed.

#include <optional>
#include <string>
#include <vector>

#include "micro/simulate.h"
#include "workflows/output_directory.h"

namespace trame::workflows {

/// The increments that a plot shows, all of one stage, and the side whose strain is its abscissa.
struct PlottedStage {
  std::size_t first = 0, end = 0;  ///< of the curve
  std::string side;                ///< "warp", or "weft" where the warp sides keep their distance
};
/// The last stage of `curve` in which a side is strained, if any is.
[[nodiscard]] std::optional<PlottedStage> strained_stage(const std::vector<micro::CurvePoint>& curve);

/// gnuplot commands that draw curves.svg: forces of warp and weft over the strain of one of them. The numbers are in
/// the script, because gnuplot does not read every CSV table right.
[[nodiscard]] std::string plot_script(const std::vector<micro::CurvePoint>& curve, const PlottedStage& stage,
                                      const std::string& title);

/// Writes curves.gp beside curves.csv, for anyone to adapt, and runs gnuplot on it. False where gnuplot is missing or
/// fails; a curve without strains needs no picture.
[[nodiscard]] bool plot_curves(const OutputDirectory& out, const std::vector<micro::CurvePoint>& curve,
                               const std::string& title);

}  // namespace trame::workflows
