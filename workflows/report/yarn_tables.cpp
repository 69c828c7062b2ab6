#include "workflows/report/yarn_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "workflows/report/html.h"

namespace trame::workflows {

namespace {

/// Numbers of a table; a dash where there is none.
std::string number(double value, const char* format = "{:.2f}") {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "–";
}

std::string change(double a, double b, const char* format) { return number(a, format) + " → " + number(b, format); }

std::string verdict_badge(meso::ContinuumVerdict verdict) {
  constexpr std::array<const char*, 5> kinds = {"good", "fair", "bad", "none", "none"};
  return fmt::format("<span class=\"badge {}\">{}</span>", kinds[static_cast<std::size_t>(verdict)],
                     escaped(text(verdict)));
}

std::string limits(const char* what, double fine, double coarse, double factor, const char* unit) {
  if (!std::isfinite(coarse)) return fmt::format("{}<br>≤ {:g}{}", what, factor * fine, unit);
  return fmt::format("{}<br>≤ {:g}{} (≤ {:g}{})", what, factor * fine, unit, factor * coarse, unit);
}

}  // namespace

std::string yarns_table(const ReportData& data) {
  HtmlTable rows{.header = {"yarn", "width, µm", "height, µm", "fill, %", "lens-shaped, %", "E<sub>axial</sub>, %",
                            "E<sub>horizontal</sub>, %", "E<sub>vertical</sub>, %", "γ<sub>max</sub>, %",
                            "axial: sides, %", "centre, %", "ratio"},
                 .rows = {}};
  for (const meso::YarnComparison& yarn : data.comparison.yarns) {
    const meso::SectionMeans& means = yarn.means;
    const meso::YarnStrain& strain = yarn.on_mesh().summary;
    rows.rows.push_back({escaped(data.yarn(yarn).name), change(1e6 * means.width_a, 1e6 * means.width_b, "{:.1f}"),
                         change(1e6 * means.height_a, 1e6 * means.height_b, "{:.1f}"),
                         change(100 * means.fill_a, 100 * means.fill_b, "{:.1f}"),
                         change(100 * means.lenticular_a, 100 * means.lenticular_b, "{:.0f}")});
    for (const double value :
         {100 * strain.axial.mean, 100 * strain.horizontal.mean, 100 * strain.vertical.mean,
          100 * strain.gamma_max.mean, 100 * means.axial_side, 100 * means.axial_centre, means.side_to_centre})
      rows.rows.back().push_back(number(value));
  }
  return table(rows);
}

std::string fibers_table(const ReportData& data) {
  const micro::FiberMesh& mesh = data.header.mesh;
  const auto length = [&](const std::vector<Vec3>& r, Index fiber) {
    double sum = 0;
    for (Index n = mesh.first_node[fiber] + 1; n < mesh.first_node[fiber + 1]; ++n) sum += (r[n] - r[n - 1]).norm();
    return sum;
  };
  HtmlTable rows{.header = {"yarn", "fibers", "mean elongation, %", "smallest, %", "largest, %"}, .rows = {}};
  for (const meso::YarnComparison& compared : data.comparison.yarns) {
    const micro::Yarn& yarn = data.yarn(compared);
    double sum = 0, low = INFINITY, high = -INFINITY;
    for (Index f = yarn.first_fiber; f < yarn.first_fiber + yarn.n_fibers; ++f) {
      const double percent = 100 * (length(data.comparison.b.fibers.r, f) / length(data.comparison.a.fibers.r, f) - 1);
      sum += percent;
      low = std::min(low, percent);
      high = std::max(high, percent);
    }
    rows.rows.push_back({escaped(yarn.name), fmt::format("{}", yarn.n_fibers), number(sum / yarn.n_fibers, "{:.3f}"),
                         number(low, "{:.3f}"), number(high, "{:.3f}")});
  }
  return table(rows);
}

std::string validity_table(const ReportData& data) {
  const meso::ContinuumLimits &fine = meso::fiber_by_fiber, &coarse = meso::on_average;
  HtmlTable rows{.header = {"yarn", "as a continuum",
                            limits("off affine, 95 %", fine.non_affine_95, coarse.non_affine_95, 1, " d"),
                            limits("disorder", fine.non_affine_share, coarse.non_affine_share, 1, ""),
                            limits("new neighbours", fine.exchanged, coarse.exchanged, 100, " %"),
                            limits("inverted", fine.flagged, coarse.flagged, 100, " %"),
                            limits("mesh matters", fine.mesh_difference, coarse.mesh_difference, 100, " %")},
                 .rows = {}};
  for (const meso::YarnComparison& yarn : data.comparison.yarns) {
    const meso::YarnContinuum& row = yarn.continuum;
    rows.rows.push_back({escaped(data.yarn(yarn).name), verdict_badge(row.verdict), number(row.non_affine_95),
                         number(row.non_affine_share), number(100 * row.exchanged, "{:.1f}"),
                         number(100 * row.flagged, "{:.1f}"), number(100 * row.mesh_difference, "{:.1f}")});
  }
  return table(rows);
}

}  // namespace trame::workflows
