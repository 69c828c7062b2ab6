#include "workflows/strains/state_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <vector>

namespace trame::workflows {
namespace {

/// The bodies at the two sides of a patch across which one family of yarns is pulled, and the direction of the pull.
struct Sides {
  Index start = 0, end = 0, axis = 0;

  [[nodiscard]] double distance(const micro::BodyRecord& bodies) const {
    return bodies.position[end][axis] - bodies.position[start][axis];
  }
  /// Mean of the pulling forces on both, N.
  [[nodiscard]] double force(const micro::BodyRecord& bodies) const {
    return 0.5 * (bodies.force[end][axis] - bodies.force[start][axis]);
  }
};

/// Warp along x, weft along y; nothing unless all four sides are there.
std::vector<Sides> find_sides(const std::vector<std::string>& body_names) {
  std::vector<Sides> all;
  for (const std::string family : {"warp", "weft"}) {
    const auto start = std::find(body_names.begin(), body_names.end(), "side/" + family + "/start");
    const auto end = std::find(body_names.begin(), body_names.end(), "side/" + family + "/end");
    if (start == body_names.end() || end == body_names.end()) return {};
    all.push_back({static_cast<Index>(start - body_names.begin()), static_cast<Index>(end - body_names.begin()),
                   static_cast<Index>(all.size())});
  }
  return all;
}

double largest_force(const micro::BodyRecord& bodies) {
  double largest = 0;
  for (const Vec3& force : bodies.force) largest = std::max(largest, force.norm());
  return largest;
}

/// The columns that tell the load. Strains of the sides would need the distance at which a stage began to pull, which
/// is not always that of a saved state.
struct LoadColumns {
  std::vector<Sides> sides;
  bool has_bodies = false;

  [[nodiscard]] std::string title() const {
    if (!sides.empty()) return "  warp (mm)  force (N)  weft (mm)  force (N)";
    return has_bodies ? "  largest force (N)" : "";
  }
  [[nodiscard]] std::string row(const micro::BodyRecord& bodies) const {
    std::string text;
    for (const Sides& pair : sides)
      text += fmt::format("  {:>9.6f}  {:>9.3e}", 1e3 * pair.distance(bodies), pair.force(bodies));
    if (sides.empty() && has_bodies) text = fmt::format("  {:>17.3e}", largest_force(bodies));
    return text;
  }
};

}  // namespace

void print_states(const meso::FiberStates& states) {
  const bool is_run = !states.header().version.empty();
  const auto& body_names = states.header().body_names;
  const LoadColumns load{find_sides(body_names), !body_names.empty()};
  fmt::print("{:>9}  {:<20} {:>6}{}{}\n", "increment", "stage", "time", is_run ? "  contacts" : "", load.title());
  for (Index i = 0; i < states.n_increments(); ++i) {
    const micro::Increment increment = states.read(i);
    fmt::print("{:>9}  {:<20} {:>6.3f}{}{}\n", i, increment.stage, increment.stage_time,
               is_run ? fmt::format("  {:>8}", increment.contacts.gap.size()) : "", load.row(increment.bodies));
  }
  fmt::print("\n{:<16} {:>6}\n", "yarn", "fibers");
  for (const auto& yarn : states.header().mesh.yarns) fmt::print("{:<16} {:>6}\n", yarn.name, yarn.n_fibers);
}

}  // namespace trame::workflows
