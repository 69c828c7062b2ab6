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
  constexpr std::array<const char*, 4> kinds = {"good", "fair", "bad", "none"};
  return fmt::format("<span class=\"badge {}\">{}</span>", kinds[static_cast<std::size_t>(verdict)],
                     escaped(text(verdict)));
}

std::string limits(const char* what, double fine, double coarse, double factor, const char* unit) {
  if (!std::isfinite(coarse)) return fmt::format("{}<br>≤ {:g}{}", what, factor * fine, unit);
  return fmt::format("{}<br>≤ {:g}{} (≤ {:g}{})", what, factor * fine, unit, factor * coarse, unit);
}

}  // namespace

std::string yarns_html(const ReportData& data) {
  HtmlTable rows{.header = {"yarn", "width, µm", "height, µm", "fill, %", "lens-shaped, %", "E<sub>axial</sub>, %",
                            "E<sub>horizontal</sub>, %", "E<sub>vertical</sub>, %", "γ<sub>max</sub>, %",
                            "axial: sides, %", "centre, %", "ratio"},
                 .rows = {}};
  for (const YarnMeans& yarn : data.means) {
    rows.rows.push_back({escaped(data.header.mesh.yarns[yarn.yarn].name),
                         change(1e6 * yarn.a.width, 1e6 * yarn.b.width, "{:.1f}"),
                         change(1e6 * yarn.a.height, 1e6 * yarn.b.height, "{:.1f}"),
                         change(100 * yarn.a.fill, 100 * yarn.b.fill, "{:.1f}"),
                         change(100 * yarn.a.lenticular, 100 * yarn.b.lenticular, "{:.0f}")});
    for (const double strain : yarn.strain) rows.rows.back().push_back(number(100 * strain));
    // A ratio to next to nothing, or of opposite signs, says nothing.
    const double ratio = yarn.axial_side / yarn.axial_centre;
    for (const double value : {100 * yarn.axial_side, 100 * yarn.axial_centre, ratio > 0 && ratio < 100 ? ratio : NAN})
      rows.rows.back().push_back(number(value));
  }
  return table(rows) + paragraph(
                           "Sizes are means over sections along the yarn, A → B; fill is the share of the section’s "
                           "outline that fibers occupy; lens-shaped is the share of the sections that a lens fits "
                           "better than an ellipse. Strains are means over the yarn’s volume. The last three "
                           "columns compare the fibers’ own axial strain in the outer quarters of the width, the "
                           "sides, with that in the middle half, the centre.");
}

std::string fibers_html(const ReportData& data) {
  const micro::FiberMesh& mesh = data.header.mesh;
  const auto length = [&](const std::vector<Vec3>& r, Index fiber) {
    double sum = 0;
    for (Index n = mesh.first_node[fiber] + 1; n < mesh.first_node[fiber + 1]; ++n) sum += (r[n] - r[n - 1]).norm();
    return sum;
  };
  HtmlTable rows{.header = {"yarn", "fibers", "mean elongation, %", "smallest, %", "largest, %"}, .rows = {}};
  for (const micro::Yarn& yarn : mesh.yarns) {
    double sum = 0, low = INFINITY, high = -INFINITY;
    for (Index f = yarn.first_fiber; f < yarn.first_fiber + yarn.n_fibers; ++f) {
      const double percent = 100 * (length(data.b.fibers.r, f) / length(data.a.fibers.r, f) - 1);
      sum += percent;
      low = std::min(low, percent);
      high = std::max(high, percent);
    }
    rows.rows.push_back({escaped(yarn.name), fmt::format("{}", yarn.n_fibers), number(sum / yarn.n_fibers, "{:.3f}"),
                         number(low, "{:.3f}"), number(high, "{:.3f}")});
  }
  return table(rows) + paragraph("Elongation: length of a fiber from node to node in B over that in A, less 1.");
}

std::string validity_html(const ReportData& data) {
  const meso::ContinuumLimits &fine = meso::fiber_by_fiber, &coarse = meso::on_average;
  HtmlTable rows{.header = {"yarn", "as a continuum",
                            limits("off affine, 95 %", fine.non_affine_95, coarse.non_affine_95, 1, " d"),
                            limits("disorder", fine.non_affine_share, coarse.non_affine_share, 1, ""),
                            limits("new neighbours", fine.exchanged, coarse.exchanged, 100, " %"),
                            limits("inverted", fine.flagged, coarse.flagged, 100, " %"),
                            limits("mesh matters", fine.mesh_difference, coarse.mesh_difference, 100, " %")},
                 .rows = {}};
  for (const meso::YarnContinuum& row : data.continuum)
    rows.rows.push_back({escaped(data.header.mesh.yarns[row.yarn].name), verdict_badge(row.verdict),
                         number(row.non_affine_95), number(row.non_affine_share), number(100 * row.exchanged, "{:.1f}"),
                         number(100 * row.flagged, "{:.1f}"), number(100 * row.mesh_difference, "{:.1f}")});
  return table(rows) +
         paragraph(
             "<i>Off affine</i>: how far fibers are from where the affine motion of their neighbourhood would put "
             "them, "
             "in distances d between fibers; 95 % of them stay below. <i>Disorder</i>: the median of that over the "
             "typical strain. <i>New neighbours</i>: pairs of neighbouring fibers that another fiber has parted. "
             "<i>Inverted</i>: tetrahedra between fibers that have changed places. <i>Mesh matters</i>: how much the "
             "strain differs between two ways to mesh the yarn. Limits in the heading: for a continuum fiber by fiber, "
             "and in brackets for one on average over sections. A yarn that keeps neither should be read fiber by "
             "fiber; its strain maps are a guide for the eye.");
}

}  // namespace trame::workflows
