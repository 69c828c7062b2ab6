#pragma once
/// \file
/// report.html: what a person wants to see of two states, on one page that needs no other file.

#include <filesystem>
#include <string>
#include <vector>

#include "meso/fiber_states.h"
#include "workflows/report/report_data.h"

namespace trame::workflows {

struct ReportInput {
  const meso::FiberStates& states;
  /// Of these states, at least one; pictures show the last B.
  std::vector<const meso::Comparison*> comparisons;
  std::filesystem::path file = "report.html";  ///< what is written
  std::vector<std::string> yarns =
      {};  ///< to show section by section, see `detailed_yarns`; those without bands are not
  std::filesystem::path summary = {};  ///< summary.json of the run; empty: certificates of the last B only, no times
  std::filesystem::path curves = {};   ///< curves.csv of the run; empty: of the saved states only
  bool draw_patch = true;              ///< pictures of the patch, which take seconds
};

/// Writes the report. Returns what it lacks and why, for the terminal; nothing where it is whole. Throws InputError for
/// yarns that there are not and for files that cannot be read, WriteError for a report that cannot be written; then
/// nothing is left behind.
std::string write_report(const ReportInput& input);

}  // namespace trame::workflows
