#include "workflows/report/body_loads.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "workflows/report/gnuplot.h"
#include "workflows/report/html.h"

namespace trame::workflows {

namespace {

constexpr std::size_t most_curves = 8, most_rows = 40;
constexpr Index most_states = 200;  ///< of a curve

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

/// The bodies that move, and each one's direction, from the first state to the last.
struct Mover {
  std::size_t body = 0;
  Vec3 direction = Vec3::Zero();
};

std::vector<Mover> movers(const micro::BodyRecord& first, const micro::BodyRecord& last) {
  double largest = 0;
  for (std::size_t b = 0; b < last.position.size(); ++b)
    largest = std::max(largest, (last.position[b] - first.position[b]).norm());
  std::vector<Mover> found;
  for (std::size_t b = 0; b < last.position.size() && found.size() < most_curves; ++b) {
    const Vec3 motion = last.position[b] - first.position[b];
    if (motion.norm() > 0.01 * largest) found.push_back({b, motion.normalized()});
  }
  return found;
}

/// A data block for each of the bodies: motion (µm) and force (mN) along its direction.
std::string curve_data(const meso::FiberStates& states, Index last, const micro::BodyRecord& first,
                       const std::vector<Mover>& moving) {
  std::vector<std::string> curves(moving.size());
  const Index step = last / most_states + 1;
  for (Index i = last % step; i <= last; i += step) {
    const micro::BodyRecord bodies = states.read(i).bodies;
    for (std::size_t m = 0; m < moving.size(); ++m) {
      const auto& [body, direction] = moving[m];
      curves[m] += fmt::format("{:.9g} {:.9g}\n", 1e6 * direction.dot(bodies.position[body] - first.position[body]),
                               1e3 * direction.dot(bodies.force[body]));
    }
  }
  std::string data;
  for (std::size_t m = 0; m < moving.size(); ++m) data += fmt::format("$body{} << EOD\n{}EOD\n", m, curves[m]);
  return data;
}

/// Names come from a file: what is no text must not get into a script.
std::string plot_title(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
  return gnuplot_string(name) + " noenhanced";
}

std::string curves_figure(const meso::FiberStates& states, Index last, const micro::BodyRecord& first,
                          const std::vector<Mover>& moving) {
  if (moving.empty()) return {};
  std::string commands = curve_data(states, last, first, moving) +
                         "set xlabel 'motion of the body (µm)'\nset ylabel 'force along it (mN)'\nset grid\n"
                         "set key top left\nset offsets graph 0.02, graph 0.02, graph 0.05, graph 0.05\nplot ";
  for (std::size_t m = 0; m < moving.size(); ++m)
    commands += fmt::format("{}$body{} with linespoints pt 7 ps 0.4 lw 2 title {}", m == 0 ? "" : ", ", m,
                            plot_title(states.header().body_names[moving[m].body]));
  const std::optional<std::string> svg = gnuplot_svg(commands + "\n", "760,430");
  if (!svg) return note("No curves: gnuplot draws them, and it is not installed or failed.");
  return figure(inline_image(*svg, "image/svg+xml", "force over motion of bodies"), filled("bodies_caption"));
}

}  // namespace

std::string bodies_html(const meso::FiberStates& states, Index last) {
  const std::vector<std::string>& names = states.header().body_names;
  if (names.empty()) return {};
  const micro::BodyRecord first = states.read(0).bodies, end = states.read(last).bodies;
  return filled("bodies", {{"table", bodies_table(names, first, end)},
                           {"cut", names.size() > most_rows},
                           {"shown", std::to_string(most_rows)},
                           {"all", std::to_string(names.size())},
                           {"curves", curves_figure(states, last, first, movers(first, end))}});
}

}  // namespace trame::workflows
