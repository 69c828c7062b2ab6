#include "workflows/report/report_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "workflows/program/gnuplot.h"
#include "workflows/report/html.h"

namespace trame::workflows {

namespace {

constexpr std::array<micro::YarnFamily, 3> families = {micro::YarnFamily::warp, micro::YarnFamily::weft,
                                                       micro::YarnFamily::free};
constexpr std::array<const char*, 3> family_names = {"warp", "weft", "other yarns"};

std::string plot_figure(const std::string& commands, const std::string& size, const std::string& what,
                        const std::string& caption) {
  const std::optional<std::string> svg = gnuplot_svg(commands, size);
  if (!svg) return note(fmt::format("No {}: gnuplot draws them, and it is not installed or failed.", what));
  return figure(inline_image(*svg, "image/svg+xml", what), caption);
}

/// Share of volume (%) of a family in each of n equal bins from low to high.
std::vector<double> shares(const ReportData& data, micro::YarnFamily family, const StrainQuantity& quantity, double low,
                           double high, std::size_t n) {
  std::vector<double> result(n, 0.0);
  double volume = 0;
  for (const meso::YarnComparison& yarn : data.comparison.yarns) {
    if (data.yarn(yarn).family != family) continue;
    const meso::YarnOnMesh& on = yarn.on_mesh();
    const std::vector<double> values = values_of(on.fields.strain, quantity.component);
    for (std::size_t t = 0; t < values.size(); ++t) {
      if (!std::isfinite(values[t])) continue;
      volume += on.mesh.volumes[t];
      const double at = (values[t] - low) / (high - low) * static_cast<double>(n);
      if (at >= 0 && at < static_cast<double>(n)) result[static_cast<std::size_t>(at)] += on.mesh.volumes[t];
    }
  }
  for (double& share : result) share = volume > 0 ? 100 * share / volume : 0;
  return result;
}

/// The range that leaves out 1 % of the tetrahedra at either end; empty (high ≤ low) without any.
std::pair<double, double> histogram_range(const ReportData& data, const StrainQuantity& quantity) {
  std::vector<double> all;
  for (const meso::YarnComparison& yarn : data.comparison.yarns)
    for (const double value : values_of(yarn.on_mesh().fields.strain, quantity.component))
      if (std::isfinite(value)) all.push_back(value);
  if (all.empty()) return {0, 0};
  std::sort(all.begin(), all.end());
  return {meso::quantile(all, 0.01), meso::quantile(all, 0.99)};
}

bool has_mesh(const ReportData& data, micro::YarnFamily family) {
  return std::any_of(data.comparison.yarns.begin(), data.comparison.yarns.end(),
                     [&](const auto& yarn) { return yarn.on_mesh().has_mesh() && data.yarn(yarn).family == family; });
}

/// One of the four diagrams: a data block, then the plot of it.
std::string histogram_commands(const ReportData& data, std::size_t index) {
  constexpr std::size_t n = 40;
  const StrainQuantity& quantity = strain_quantities[index];
  const auto [low, high] = histogram_range(data, quantity);
  if (high <= low) return {};
  std::string block = fmt::format("$data{} << EOD\n", index), plot;
  std::array<std::vector<double>, 3> of_family;
  for (std::size_t f = 0; f < 3; ++f) of_family[f] = shares(data, families[f], quantity, low, high, n);
  for (std::size_t i = 0; i < n; ++i)
    block += fmt::format("{:.6g} {:.6g} {:.6g} {:.6g}\n", 100 * (low + (double(i) + 0.5) * (high - low) / n),
                         of_family[0][i], of_family[1][i], of_family[2][i]);
  for (std::size_t f = 0; f < 3; ++f)
    if (has_mesh(data, families[f]))
      plot += fmt::format("{}$data{} using 1:{} with histeps linewidth 2 linecolor rgb '{}' title '{}'",
                          plot.empty() ? "plot " : ", ", index, f + 2, family_colour(families[f]), family_names[f]);
  return fmt::format("{}EOD\nset xlabel '{} (%)'\n{}\n", block, quantity.plain, plot);
}

}  // namespace

const char* family_colour(micro::YarnFamily family) {
  return family == micro::YarnFamily::warp   ? warp_colour
         : family == micro::YarnFamily::weft ? weft_colour
                                             : free_colour;
}

std::string histogram_figure(const ReportData& data) {
  std::string commands =
      "set multiplot layout 2,2\nset grid\nset yrange [0:*]\nset offsets 0, 0, graph 0.2, 0\n"
      "set ylabel 'share of volume (%)'\n";
  std::size_t n_plots = 0;
  for (std::size_t q = 0; q < strain_quantities.size(); ++q) {
    const std::string plot = histogram_commands(data, q);
    n_plots += plot.empty() ? 0 : 1;
    commands += plot;
  }
  if (n_plots == 0) return note("No histograms: the strain is the same everywhere, or no yarn has a mesh.");
  return plot_figure(commands, "980,640", "histograms of strain", filled("histogram_caption"));
}

std::string share_bar_svg(std::vector<std::pair<std::string, double>> parts) {
  constexpr std::array<const char*, 8> colours = {"#3b75af", "#d5813a", "#5a9e6f", "#8a6bb1",
                                                  "#b5524d", "#c9a227", "#6b7a8a", "#a0a8b2"};
  constexpr double width = 860;
  double total = 0;
  for (const auto& part : parts) total += part.second;
  std::erase_if(parts, [&](const auto& part) { return part.second <= 0.005 * total; });
  std::sort(parts.begin(), parts.end(), [](const auto& p, const auto& q) { return p.second > q.second; });
  std::string content;
  double x = 0, legend = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const double share = parts[i].second / total;
    const char* fill = colours[i % colours.size()];
    content += fmt::format("<rect x=\"{:.1f}\" width=\"{:.1f}\" height=\"22\" fill=\"{}\"/>", x, share * width, fill);
    const std::string text = fmt::format("{} {:.0f} %", parts[i].first, 100 * share);
    content += fmt::format(
        "<rect x=\"{0:.1f}\" y=\"33\" width=\"10\" height=\"10\" fill=\"{1}\"/>"
        "<text x=\"{2:.1f}\" y=\"42\" font-size=\"12\">{3}</text>",
        legend, fill, legend + 14, escaped(text));
    x += share * width;
    legend += 34 + 7 * static_cast<double>(text.size());
  }
  return fmt::format("<svg width=\"{0:.0f}\" height=\"48\" viewBox=\"0 0 {0:.0f} 48\">{1}</svg>",
                     std::max(width, legend), content);
}

}  // namespace trame::workflows
