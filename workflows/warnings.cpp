#include "workflows/warnings.h"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace trame::workflows {

namespace {

/// "of which 4 % are penetration of contacts": what the estimate says a user can do something about.
std::string parts_text(const PosterioriEstimate& estimate) {
  const std::array<std::pair<const char*, std::optional<double>>, 3> parts = {
      {{"steps of the load path", estimate.steps},
       {"penetration of contacts", estimate.penetration},
       {"bending within elements", estimate.elements}}};
  std::string text;
  for (const auto& [what, error] : parts)
    if (error) text += fmt::format("{}{} {:.2g} %", text.empty() ? "" : ", ", what, 100 * *error);
  return text;
}

}  // namespace

std::vector<std::string> all_warnings(const micro::SimulationSummary& summary, const PosterioriEstimate& estimate,
                                      std::optional<double> error) {
  std::vector<std::string> warnings = summary.warnings;
  if (!summary.crossing_order_ok)
    warnings.push_back(
        fmt::format("only {} of {} crossings agree with the weave", summary.n_crossings_ok, summary.n_crossings));
  if (summary.max_penetration_over_radius > penetration_to_warn_of)
    warnings.push_back(fmt::format("fibers lie up to {:.2g} of a radius inside each other at the end",
                                   summary.max_penetration_over_radius));
  else if (summary.deepest_penetration_over_radius > penetration_to_warn_of)
    warnings.push_back(fmt::format("fibers lay up to {:.2g} of a radius inside each other, or in surfaces, on the way",
                                   summary.deepest_penetration_over_radius));
  if (error && *error > estimate_to_warn_of)
    warnings.push_back(fmt::format("forces and energies of the last stage may be off by {:.0f} %{} ({})", 100 * *error,
                                   *error < 1 ? "" : " or more", parts_text(estimate)));
  return warnings;
}

}  // namespace trame::workflows
