#pragma once
/// \file
/// Tables of the report with a row for each yarn.

#include <string>

#include "workflows/report/report_data.h"

namespace trame::workflows {

/// Sizes of sections in A and B, mean strains, side over centre.
[[nodiscard]] std::string yarns_table(const ReportData& data);

/// What speaks for and against a continuum, with a verdict.
[[nodiscard]] std::string validity_table(const ReportData& data);

/// How much longer the fibers of each yarn have become.
[[nodiscard]] std::string fibers_table(const ReportData& data);

}  // namespace trame::workflows
