#pragma once
/// \file
/// Diagrams of the report. Those that gnuplot draws are figures, or a note where it is not installed.

#include <string>
#include <utility>
#include <vector>

#include "workflows/report/report_data.h"

namespace trame::workflows {

/// Colours of warp and weft, as in the pictures of the patch.
inline constexpr const char* warp_colour = "#3b75af";
inline constexpr const char* weft_colour = "#d5813a";
/// Of yarns that are neither.
inline constexpr const char* free_colour = "#5a9e6f";
[[nodiscard]] const char* family_colour(micro::YarnFamily family);

/// Shares of volume by strain, warp and weft apart.
[[nodiscard]] std::string histogram_figure(const ReportData& data);

/// Parts of a whole as a bar with a legend, the largest first; parts below half a percent are left out.
[[nodiscard]] std::string share_bar_svg(std::vector<std::pair<std::string, double>> parts);

}  // namespace trame::workflows
