#pragma once
/// \file
/// The parts of the report that show sections of single yarns.

#include <string>

#include "workflows/report/report_data.h"

namespace trame::workflows {

/// Sections of the detailed yarns at their stations, state by state, and strips of sections along them in B.
[[nodiscard]] std::string sections_html(const ReportData& data);

/// Strains on the sections of all detailed yarns, with one colour scale per component.
[[nodiscard]] std::string strain_maps_html(const ReportData& data);

/// Bands on these sections: directions, how many there are, and the strongest ones in numbers.
[[nodiscard]] std::string bands_html(const ReportData& data);

}  // namespace trame::workflows
