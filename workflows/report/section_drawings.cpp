#include "workflows/report/section_drawings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "meso/strain/statistics.h"

namespace trame::workflows {

namespace {

constexpr double micrometres = 1e6;  ///< in a metre

std::string point(const Vec2& x) { return fmt::format("{:.4g} {:.4g}", micrometres * x.x(), -micrometres * x.y()); }

std::string svg(const Window& window, const std::string& content) {
  const Vec2 size = micrometres * (window.high - window.low);
  return fmt::format("<svg width=\"{:.0f}\" height=\"{:.0f}\" viewBox=\"{:.5g} {:.5g} {:.5g} {:.5g}\">{}</svg>",
                     window.pixels, std::max(1.0, window.pixels * size.y() / size.x()), micrometres * window.low.x(),
                     -micrometres * window.high.y(), size.x(), size.y(), content);
}

std::string polygon(const std::vector<Vec2>& corners, const std::string& attributes) {
  std::string path;
  for (const Vec2& x : corners) path += fmt::format("{}{}", path.empty() ? 'M' : 'L', point(x));
  return fmt::format("<path d=\"{}Z\" {} vector-effect=\"non-scaling-stroke\"/>", path, attributes);
}

/// The unit circle carried to the fiber's ellipse.
std::string ellipse(const meso::FiberCut& fiber) {
  const Eigen::Matrix2d h = micrometres * fiber.half_axes;
  return fmt::format(
      "<circle r=\"1\" transform=\"matrix({:.4g} {:.4g} {:.4g} {:.4g} {})\" vector-effect=\"non-scaling-stroke\"/>",
      h(0, 0), -h(1, 0), h(0, 1), -h(1, 1), point(fiber.centre));
}

std::string fibers(const meso::Section& section, const std::string& attributes) {
  std::string group = "<g " + attributes + ">";
  for (const meso::FiberCut& fiber : section.fibers) group += ellipse(fiber);
  return group + "</g>";
}

std::string missing(const Window& window, const std::string& why) {
  const Vec2 centre = 0.5 * (window.low + window.high);
  return svg(window, fmt::format("<text x=\"{:.4g}\" y=\"{:.4g}\" text-anchor=\"middle\" font-size=\"{:.3g}\" "
                                 "fill=\"#7b8591\">{}</text>",
                                 micrometres * centre.x(), -micrometres * centre.y(),
                                 11 * micrometres * (window.high.x() - window.low.x()) / window.pixels, why));
}

constexpr std::array<std::array<double, 3>, 9> cool_warm = {{{59, 76, 192},
                                                             {98, 130, 234},
                                                             {141, 176, 254},
                                                             {184, 208, 249},
                                                             {221, 221, 221},
                                                             {245, 196, 173},
                                                             {244, 154, 123},
                                                             {222, 96, 77},
                                                             {180, 4, 38}}};
constexpr std::array<std::array<double, 3>, 9> viridis = {{{68, 1, 84},
                                                           {71, 44, 122},
                                                           {59, 81, 139},
                                                           {44, 113, 142},
                                                           {33, 144, 141},
                                                           {39, 173, 129},
                                                           {92, 200, 99},
                                                           {170, 220, 50},
                                                           {253, 231, 37}}};

/// Lower left corner of a pixel.
Vec2 corner_of(const meso::YarnCut& cut, Index row, Index column) {
  return cut.corner + cut.pixel * Vec2(static_cast<double>(column) - 0.5, static_cast<double>(row) - 0.5);
}

/// One path for each of 64 shades, of runs of pixels along rows: a cut is a few kilobytes.
std::string pixels(const meso::YarnCut& cut, const meso::Picture& values, const ColourScale& scale) {
  constexpr int n_shades = 64;
  const auto shade = [&](Index row, Index column) {
    const double value = values(row, column);
    if (!std::isfinite(value)) return -1;
    const double t = scale.high > scale.low ? (value - scale.low) / (scale.high - scale.low) : 0.5;
    return static_cast<int>(std::lround(std::clamp(t, 0.0, 1.0) * (n_shades - 1)));
  };
  std::map<int, std::string> paths;
  const double side = micrometres * cut.pixel;
  for (Index row = 0; row < cut.n_rows(); ++row)
    for (Index column = 0, end = 0; column < cut.n_columns(); column = end) {
      const int own = shade(row, column);
      for (end = column + 1; end < cut.n_columns() && shade(row, end) == own; ++end) {
      }
      if (own < 0) continue;
      const double width = static_cast<double>(end - column) * side;
      paths[own] += fmt::format("M{}h{:.4g}v{:.4g}h{:.4g}z", point(corner_of(cut, row, column)), width, -side, -width);
    }
  std::string group = "<g shape-rendering=\"crispEdges\">";
  for (const auto& [own, path] : paths)
    group += fmt::format("<path fill=\"{}\" d=\"{}\"/>", colour(scale.map, own / (n_shades - 1.0)), path);
  return group + "</g>";
}

/// Sides between pixels of region k and others.
std::string region_edges(const meso::YarnCut& cut, const Eigen::ArrayXX<Index>& region, Index k) {
  const auto in = [&](Index row, Index column) {
    return row >= 0 && column >= 0 && row < cut.n_rows() && column < cut.n_columns() && region(row, column) == k;
  };
  std::string path;
  const auto side = [&](Index row, Index column, Index to_row, Index to_column) {
    path += fmt::format("M{}L{}", point(corner_of(cut, row, column)), point(corner_of(cut, to_row, to_column)));
  };
  for (Index row = 0; row <= cut.n_rows(); ++row)
    for (Index column = 0; column <= cut.n_columns(); ++column) {
      if (in(row, column) != in(row - 1, column)) side(row, column, row, column + 1);
      if (in(row, column) != in(row, column - 1)) side(row, column, row + 1, column);
    }
  return path;
}

/// Dark lines with a white rim, which are seen on any colour.
std::string band_edges(const meso::SectionBands& bands) {
  std::string paths;
  for (std::size_t k = 0; k < bands.bands.size(); ++k)
    paths += fmt::format("<path vector-effect=\"non-scaling-stroke\" {}d=\"{}\"/>",
                         bands.bands[k].significant ? "" : "stroke-dasharray=\"1 2.5\" ",
                         region_edges(*bands.cut, bands.region, static_cast<Index>(k) + 1));
  if (paths.empty()) return {};
  return fmt::format(
      "<g fill=\"none\"><g stroke=\"#fff\" stroke-width=\"3\">{0}</g><g stroke=\"#111\" "
      "stroke-width=\"1.3\">{0}</g></g>",
      paths);
}

constexpr double dial_radius = 90;

/// What directions are drawn on: a circle with their names.
std::string direction_dial_svg(const std::string& content) {
  return fmt::format(
      "<svg width=\"260\" height=\"220\" viewBox=\"-130 -115 260 220\"><circle r=\"{}\" fill=\"none\" "
      "stroke=\"#d5dbe2\"/>{}<g font-size=\"12\" text-anchor=\"middle\" fill=\"#5b6775\"><text x=\"112\" y=\"4\">0°"
      "</text><text y=\"-97\">90°</text><text x=\"80\" y=\"-72\">45°</text><text x=\"-82\" y=\"-72\">−45°</text></g>"
      "</svg>",
      dial_radius, content);
}

}  // namespace

Window window_around(const std::vector<const meso::Section*>& sections, double pixels) {
  Window window{.low = Vec2::Constant(1), .high = Vec2::Constant(-1), .pixels = pixels};
  bool first = true;
  for (const meso::Section* section : sections)
    for (const Vec2& x : section->outline) {
      window.low = first ? x : window.low.cwiseMin(x);
      window.high = first ? x : window.high.cwiseMax(x);
      first = false;
    }
  if (first) return {.low = Vec2::Constant(-1e-4), .high = Vec2::Constant(1e-4), .pixels = pixels};
  const Vec2 margin = Vec2::Constant(0.02 * (window.high.x() - window.low.x()));
  return {.low = window.low - margin, .high = window.high + margin, .pixels = pixels};
}

std::string section_svg(const meso::Section& section, const Window& window, const std::string& fill_colour) {
  if (section.status != meso::SectionStatus::ok) return missing(window, std::string(text(section.status)));
  return svg(window,
             polygon(section.outline, "fill=\"#f1f3f6\" stroke=\"#8a95a1\" stroke-width=\"1\"") +
                 fibers(section, fmt::format("fill=\"{}\" stroke=\"#1d2733\" stroke-width=\"0.7\"", fill_colour)));
}

std::string colour(ColourMap map, double t) {
  const auto& points = map == ColourMap::diverging ? cool_warm : viridis;
  const double at = std::clamp(t, 0.0, 1.0) * (points.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), points.size() - 2);
  std::string text = "#";
  for (int c = 0; c < 3; ++c)
    text += fmt::format("{:02x}", std::lround(points[i][c] + (at - double(i)) * (points[i + 1][c] - points[i][c])));
  return text;
}

ColourScale scale_for(std::vector<double> values, ColourMap map) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  for (double& value : values) value = std::abs(value);
  std::sort(values.begin(), values.end());
  const double high = values.empty() ? 0 : meso::quantile(values, 0.95);
  return {map, map == ColourMap::diverging ? -high : 0, high};
}

std::string colour_bar_svg(const ColourScale& scale) {
  constexpr int n = 64, width = 130, margin = 32;
  std::string content;
  for (int i = 0; i < n; ++i)
    content += fmt::format("<rect x=\"{:.4g}\" y=\"0\" width=\"{:.4g}\" height=\"10\" fill=\"{}\"/>",
                           margin + i * double(width) / n, double(width) / n + 0.5, colour(scale.map, (i + 0.5) / n));
  const std::array<double, 3> marks = {scale.low, 0.5 * (scale.low + scale.high), scale.high};
  for (int i = 0; i < 3; ++i)
    content += fmt::format("<text x=\"{}\" y=\"23\" font-size=\"11\" text-anchor=\"middle\">{:.3g}{}</text>",
                           margin + i * width / 2, 100 * marks[i], i == 2 ? " %" : "");
  return fmt::format("<svg width=\"{0}\" height=\"28\" viewBox=\"0 0 {0} 28\">{1}</svg>", width + 2 * margin, content);
}

std::string strain_map_svg(const meso::YarnCut& cut, const meso::Picture& values, const ColourScale& scale,
                           const meso::Section& section, const Window& window, const meso::SectionBands& bands) {
  if (!values.isFinite().any()) return missing(window, "no strain here");
  std::string content = pixels(cut, values, scale) +
                        fibers(section, "fill=\"none\" stroke=\"#000\" stroke-opacity=\"0.35\" stroke-width=\"0.6\"");
  return svg(window, content + band_edges(bands));
}

std::string rose_svg(const std::vector<meso::ShearBand>& bands) {
  constexpr int n = 12;
  constexpr double sector = std::numbers::pi / n;
  std::array<double, n> area{};
  for (const meso::ShearBand& band : bands)
    area[static_cast<int>(std::lround((band.angle + 90) * n / 180)) % n] += band.area;
  const double largest = *std::max_element(area.begin(), area.end());
  if (largest <= 0) return {};
  std::string content;
  for (int i = 0; i < 2 * n; ++i) {
    // The area of a sector, not its radius, is in proportion.
    const double r = dial_radius * std::sqrt(area[i % n] / largest), middle = -std::numbers::pi / 2 + i * sector;
    const auto at = [&](double angle) {
      return fmt::format("{:.4g} {:.4g}", r * std::cos(angle), -r * std::sin(angle));
    };
    if (r > 0)
      content += fmt::format("<path fill=\"#6a51a3\" stroke=\"#fff\" d=\"M0 0L{}A{:.4g} {:.4g} 0 0 0 {}Z\"/>",
                             at(middle - sector / 2), r, r, at(middle + sector / 2));
  }
  return direction_dial_svg(content);
}

std::string direction_curves_svg(const std::vector<DirectionCurve>& curves, double full, double noise) {
  std::string content;
  for (const auto& [line_colour, values] : curves) {
    if (std::none_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); })) continue;
    std::string path;
    for (std::size_t i = 0; i < 2 * values.size(); ++i) {
      const double angle = std::numbers::pi / 180 * meso::DirectionalCorrelation::angle(i);
      const double value = values[i % values.size()];  // NaN where the yarn is too thin to tell
      const double r = std::isfinite(value) ? dial_radius * std::clamp(value / full, 0.0, 1.0) : 0;
      path += fmt::format("{}{:.1f} {:.1f}", i == 0 ? 'M' : 'L', r * std::cos(angle), -r * std::sin(angle));
    }
    content += fmt::format("<path d=\"{0}Z\" fill=\"{1}\" fill-opacity=\"0.2\" stroke=\"{1}\" stroke-width=\"2\"/>",
                           path, line_colour);
  }
  if (content.empty()) return {};
  return direction_dial_svg(content + fmt::format("<circle r=\"{:.1f}\" fill=\"none\" stroke=\"#5b6775\" "
                                                  "stroke-dasharray=\"2 3\"/>",
                                                  dial_radius * noise / full));
}

}  // namespace trame::workflows
