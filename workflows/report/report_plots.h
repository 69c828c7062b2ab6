#pragma once
/// \file
/// Diagrams of the report. Those that gnuplot draws are figures, or a note where it is not installed.

#include <array>
#include <filesystem>
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

/// A row of curves.csv: index 0 warp, 1 weft.
struct CurveRow {
  std::string stage;
  std::array<double, 2> strain{}, force{};  ///< 1, N
};
/// Throws InputError for a file that is missing or not such a table.
[[nodiscard]] std::vector<CurveRow> read_curves(const std::filesystem::path& file);

/// Forces over strain of the sides in the last stage that strains one.
[[nodiscard]] std::string curves_figure(const std::vector<CurveRow>& rows);

/// Shares of volume by strain, warp and weft apart.
[[nodiscard]] std::string histogram_figure(const ReportData& data);

/// Parts of a whole as a bar with a legend, the largest first; parts below half a percent are left out.
[[nodiscard]] std::string share_bar_svg(std::vector<std::pair<std::string, double>> parts);

}  // namespace trame::workflows
