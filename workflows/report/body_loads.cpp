#include "workflows/report/body_loads.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "workflows/report/html.h"

namespace trame::workflows {

namespace {

constexpr std::size_t most_rows = 40;

/// Without round-off.
std::string components(const Vec3& vector, double factor) {
  const double smallest = 1e-6 * vector.norm();
  const Vec3 x = vector.unaryExpr([&](double v) { return std::abs(v) < smallest ? 0.0 : factor * v; });
  return fmt::format("({:.4g}, {:.4g}, {:.4g})", x.x(), x.y(), x.z());
}

double degrees(const Mat3& rotation) { return 180 / std::numbers::pi * Eigen::AngleAxisd(rotation).angle(); }

std::string bodies_table(const std::vector<std::string>& names, const micro::BodyRecord& first,
                         const micro::BodyRecord& last) {
  HtmlTable rows{.header = {"body", "moved by, µm", "turned by, °", "force, mN", "moment, nN m"}, .rows = {}};
  for (std::size_t b = 0; b < std::min(names.size(), most_rows); ++b)
    rows.rows.push_back({escaped(names[b]), components(last.position[b] - first.position[b], 1e6),
                         fmt::format("{:.4g}", degrees(last.rotation[b] * first.rotation[b].transpose())),
                         components(last.force[b], 1e3), components(last.moment[b], 1e9)});
  return table(rows);
}

}  // namespace

std::string bodies_html(const meso::FiberStates& states, Index last) {
  const std::vector<std::string>& names = states.header().body_names;
  if (names.empty()) return {};
  const micro::BodyRecord first = states.read(0).bodies, end = states.read(last).bodies;
  return filled("bodies", {{"table", bodies_table(names, first, end)},
                           {"cut", names.size() > most_rows},
                           {"shown", std::to_string(most_rows)},
                           {"all", std::to_string(names.size())}});
}

}  // namespace trame::workflows
