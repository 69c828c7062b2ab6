#include "workflows/report/curve_chapters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "micro/scene/weave.h"
#include "workflows/curves/curves_plot.h"
#include "workflows/program/gnuplot.h"
#include "workflows/report/html.h"

namespace trame::workflows {

namespace {

CurvesLayout layout_of(const micro::SnapshotHeader& header, const std::optional<micro::Scene>& scene,
                       const micro::BodyRecord& last) {
  if (scene && !scene->stages.empty()) return curves_layout(*scene, header.body_names);
  CurvesLayout layout{false, header.body_names, {}};
  for (std::size_t b = 0; b < header.body_names.size(); ++b)
    for (int d = 0; d < micro::n_body_dofs; ++d)
      if ((d < 3 ? last.motion : last.turn)[b][d % 3] != 0)
        layout.dofs.push_back({static_cast<Index>(b), static_cast<micro::BodyDof>(d), {}});
  return layout;
}

/// `micro::n_body_dofs` numbers for each body.
std::vector<double> interleaved(const std::vector<Vec3>& translations, const std::vector<Vec3>& rotations) {
  std::vector<double> numbers;
  for (std::size_t b = 0; b < translations.size(); ++b)
    for (const Vec3& v : {translations[b], rotations[b]}) numbers.insert(numbers.end(), v.data(), v.data() + 3);
  return numbers;
}

std::string number(double value, const Shown& as) { return fmt::format("{:.3g} {}", as.factor * value, as.unit); }
std::string from_to(double start, double end, const Shown& as) {
  const double small = 1e-6 * std::max(std::abs(start), std::abs(end));
  const auto clean = [&](double x) { return std::abs(x) <= small ? 0.0 : as.factor * x; };
  return fmt::format("{:.4g} → {:.4g} {}", clean(start), clean(end), as.unit);
}

void add_rows(const Curve& curve, HtmlTable& rows) {
  const CurveKind& kind = curve.kind();
  for (const Branch& b : branches_of(curve)) {
    const Curve::Point &start = curve.points[b.first], &end = curve.points[b.last];
    rows.rows.push_back(
        {escaped(curve.name), escaped(start.stage), text(b.kind), from_to(start.motion, end.motion, kind.motion),
         from_to(start.reaction, end.reaction, kind.reaction), number(b.initial_stiffness, kind.stiffness),
         number(b.tangent_stiffness, kind.stiffness), curve.works ? number(b.work, kind.work) : "",
         curve.works && b.loop ? number(*b.loop, kind.work) : ""});
  }
}

std::string curves_figure(const std::vector<Curve>& curves) {
  const std::string commands = plot_commands(curves);
  if (commands.empty()) return {};
  const Axes axes = axes_of(curves.front());
  const std::string what = fmt::format("{} over {}", axes.reaction, axes.motion);
  const std::optional<std::string> svg = gnuplot_svg(commands, "760,430");
  if (!svg) return note("No curves: gnuplot draws them, and it is not installed or failed.");
  return figure(inline_image(*svg, "image/svg+xml", what), filled("curves_caption", {{"what", what}}));
}

/// Sides, and the periods of a cell along its yarns, are shown as such.
bool is_shown_as_sides(const Curve& curve) {
  return curve.name == fmt::format("{}, x", micro::period_name(true)) ||
         curve.name == fmt::format("{}, y", micro::period_name(false)) ||
         (curve.name.starts_with("side/warp/") && curve.name.ends_with(", x")) ||
         (curve.name.starts_with("side/weft/") && curve.name.ends_with(", y"));
}

/// How yarns were woven tells nothing about the fabric: of a weave, what comes with and after the first stage that
/// strains its sides, else the last stage.
void leave_out_weaving(std::vector<Curve>& curves) {
  std::vector<std::string> stages;
  for (const Curve::Point& point : curves.front().points)
    if (stages.empty() || stages.back() != point.stage) stages.push_back(point.stage);
  const auto strains = [&](const std::string& stage) {
    return std::any_of(curves.begin(), curves.end(),
                       [&](const Curve& curve) { return curve.is_of_fabric() && curve.stages.contains(stage); });
  };
  if (stages.empty()) return;
  auto first = std::find_if(stages.begin(), stages.end(), strains);
  if (first == stages.end()) --first;
  for (Curve& curve : curves)
    std::erase_if(curve.stages,
                  [&](const std::string& stage) { return std::find(first, stages.end(), stage) == stages.end(); });
}

/// Of dofs, those whose work is not small beside that of others.
std::vector<Curve> worth_showing(const std::vector<Curve>& curves) {
  constexpr double small = 0.05;
  double most = 0;
  for (const Curve& curve : curves)
    if (!curve.is_of_fabric()) most = std::max(most, largest_work(curve));
  const bool has_fabric = std::any_of(curves.begin(), curves.end(), std::mem_fn(&Curve::is_of_fabric));
  const auto is_shown_else = [&](const Curve& curve) {
    return (has_fabric && is_shown_as_sides(curve)) ||
           std::any_of(curves.begin(), curves.end(),
                       [&](const Curve& test) { return test.parts.contains(curve.name); });
  };
  std::vector<Curve> kept;
  for (const Curve& curve : curves)
    if (curve.is_of_fabric() || (largest_work(curve) >= small * most && !is_shown_else(curve))) kept.push_back(curve);
  return kept;
}

}  // namespace

CurvesLayout saved_layout(const micro::SnapshotHeader& header, const std::optional<micro::Scene>& scene,
                          const micro::Increment& last) {
  if (header.body_names.empty() || last.bodies.motion.empty()) return {};
  return layout_of(header, scene, last.bodies);
}

std::vector<double> saved_values(const CurvesLayout& layout, const micro::Increment& state) {
  return layout.values(state.sides.strain, state.sides.force, interleaved(state.bodies.motion, state.bodies.turn),
                       interleaved(state.bodies.force, state.bodies.moment));
}

CurvesTable saved_curves(const meso::FiberStates& states, const std::optional<micro::Scene>& scene, Index last) {
  const CurvesLayout layout = saved_layout(states.header(), scene, states.read(last));
  CurvesTable table{layout.columns(), {}};
  for (Index i = 0; i <= last && !table.columns.empty(); ++i) {
    const micro::Increment state = states.read(i);
    table.rows.push_back({state.stage, state.stage_time, saved_values(layout, state)});
  }
  return table;
}

std::string curves_html(std::vector<Curve> curves, bool is_weave, bool are_saved) {
  if (curves.empty()) return {};
  if (is_weave) leave_out_weaving(curves);
  const std::vector<Curve> worth = worth_showing(curves);
  std::string figures;
  HtmlTable rows{.header = {"driven", "stage", "branch", "motion", "reaction", "initial stiffness", "tangent at end",
                            "work", "loop"},
                 .rows = {}};
  std::size_t n_shown = 0, n_dofs = 0;
  for (const CurveKind& kind : curve_kinds()) {
    const std::vector<Curve> shown = curves_to_draw(kind, worth);
    figures += curves_figure(shown);
    for (const Curve& curve : shown) {
      add_rows(curve, rows);
      n_shown += curve.is_of_fabric() ? 0 : 1;
    }
  }
  if (rows.rows.empty()) return {};
  for (const Curve& curve : curves) n_dofs += curve.is_of_fabric() ? 0 : 1;
  return filled("curves", {{"sides", std::any_of(worth.begin(), worth.end(), std::mem_fn(&Curve::is_of_sides))},
                           {"figures", figures},
                           {"table", table(rows)},
                           {"cut", n_shown < n_dofs},
                           {"all", std::to_string(n_dofs)},
                           {"saved", are_saved}});
}

}  // namespace trame::workflows
