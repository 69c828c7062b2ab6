#include "workflows/report/curves_plot.h"

#include <fmt/format.h>

#include <algorithm>

#include "workflows/report/gnuplot.h"

namespace trame::workflows {

std::optional<PlottedStage> strained_stage(const std::vector<micro::CurvePoint>& curve) {
  const auto last = std::find_if(curve.rbegin(), curve.rend(), [](const micro::CurvePoint& point) {
    return point.side_strain[0] != 0 || point.side_strain[1] != 0;
  });
  if (last == curve.rend()) return std::nullopt;
  const auto of_another_stage = [&](const micro::CurvePoint& point) { return point.stage != last->stage; };
  const auto first = std::find_if(last, curve.rend(), of_another_stage).base();
  const auto end = std::find_if(last.base(), curve.end(), of_another_stage);
  return PlottedStage{static_cast<std::size_t>(first - curve.begin()), static_cast<std::size_t>(end - curve.begin()),
                      last->side_strain[0] != 0 ? "warp" : "weft"};
}

std::string plot_script(const std::vector<micro::CurvePoint>& curve, const PlottedStage& stage,
                        const std::string& title) {
  const int side = stage.side == "warp" ? 0 : 1;
  std::string rows;
  for (std::size_t i = stage.first; i < stage.end; ++i)
    rows += fmt::format("{:.9g} {:.9g} {:.9g}\n", 100 * curve[i].side_strain[side], curve[i].side_force[0],
                        curve[i].side_force[1]);
  return fmt::format(R"(# Forces over strain of the patch sides: gnuplot curves.gp
set encoding utf8
set terminal svg size 800,600 dynamic background rgb 'white'
set output 'curves.svg'
set title {title} noenhanced
set xlabel '{side} strain (%)'
set ylabel 'force on a side (N)'
set key top left
set grid
# {side} strain (%), warp force (N), weft force (N): the stage's rows of curves.csv
$curve << EOD
{rows}EOD
plot $curve using 1:2 with linespoints title 'warp', \
     $curve using 1:3 with linespoints title 'weft'
)",
                     fmt::arg("title", gnuplot_string(title)), fmt::arg("side", stage.side), fmt::arg("rows", rows));
}

bool plot_curves(const OutputDirectory& out, const std::vector<micro::CurvePoint>& curve, const std::string& title) {
  const std::optional<PlottedStage> stage = strained_stage(curve);
  if (!stage) return true;
  write_whole_file(out.root() / "curves.gp",
                   plot_script(curve, *stage, title + ", stage " + curve[stage->first].stage));
  const bool drawn = run_gnuplot(out.root(), "curves.gp") && is_whole_svg(out.root() / "curves.svg");
  if (!drawn) std::filesystem::remove(out.root() / "curves.svg");
  return drawn;
}

}  // namespace trame::workflows
