#include "workflows/strains/state_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include "workflows/report/curve_chapters.h"
#include "workflows/report/scene_settings.h"

namespace trame::workflows {
namespace {

double largest_force(const micro::BodyRecord& bodies) {
  double largest = 0;
  for (const Vec3& force : bodies.force) largest = std::max(largest, force.norm());
  return largest;
}

/// The columns that tell the load: the first of those of curves.csv. Files of older versions have but forces.
struct LoadColumns {
  static constexpr std::size_t most = 8;
  CurvesLayout layout;
  bool has_bodies = false;
  std::vector<std::string> columns = layout.columns();

  [[nodiscard]] std::size_t n_shown() const {
    return layout.has_sides ? side_columns.size() : std::min(columns.size(), most);
  }
  [[nodiscard]] static std::size_t width(const std::string& column) { return std::max<std::size_t>(column.size(), 12); }
  [[nodiscard]] std::string title() const {
    std::string text;
    for (std::size_t c = 0; c < n_shown(); ++c) text += fmt::format("  {:>{}}", columns[c], width(columns[c]));
    return columns.empty() && has_bodies ? "  largest force (N)" : text;
  }
  [[nodiscard]] std::string row(const micro::Increment& state) const {
    if (columns.empty()) return has_bodies ? fmt::format("  {:>17.3e}", largest_force(state.bodies)) : "";
    const std::vector<double> values = saved_values(layout, state);
    std::string text;
    for (std::size_t c = 0; c < n_shown(); ++c) text += fmt::format("  {:>{}.5e}", values[c], width(columns[c]));
    return text;
  }
};

}  // namespace

void print_states(const meso::FiberStates& states) {
  const bool is_run = !states.header().version.empty();
  const auto& body_names = states.header().body_names;
  const micro::Increment last = states.read(states.n_increments() - 1);
  const LoadColumns load{saved_layout(states.header(), scene_of(states.header()), last), !body_names.empty()};
  fmt::print("{:>9}  {:<20} {:>6}{}{}\n", "increment", "stage", "time", is_run ? "  contacts" : "", load.title());
  for (Index i = 0; i < states.n_increments(); ++i) {
    const micro::Increment increment = states.read(i);
    fmt::print("{:>9}  {:<20} {:>6.3f}{}{}\n", i, increment.stage, increment.stage_time,
               is_run ? fmt::format("  {:>8}", increment.contacts.gap.size()) : "", load.row(increment));
  }
  if (load.n_shown() < load.columns.size())
    fmt::print("\nAll {} motions and reactions are in the run's curves.csv.\n", load.columns.size() / 2);
  fmt::print("\n{:<16} {:>6}\n", "yarn", "fibers");
  for (const auto& yarn : states.header().mesh.yarns) fmt::print("{:<16} {:>6}\n", yarn.name, yarn.n_fibers);
}

}  // namespace trame::workflows
