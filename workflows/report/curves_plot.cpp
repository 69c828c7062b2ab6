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
  return PlottedStage{last->stage, last->side_strain[0] != 0 ? "warp" : "weft"};
}

std::string plot_script(const PlottedStage& stage, const std::string& title) {
  return fmt::format(R"(# Forces over strain of the patch sides: gnuplot curves.gp
set datafile separator comma
set terminal svg size 800,600 dynamic background rgb 'white'
set output 'curves.svg'
set title {title} noenhanced
set xlabel '{side} strain (%)'
set ylabel 'force on a side (N)'
set key top left
set grid
stage = {stage}
in_stage(strain) = strcol('stage') eq stage ? 100 * strain : NaN
plot 'curves.csv' using (in_stage(column('{side}_strain'))):'warp_force_N' with linespoints title 'warp', \
     'curves.csv' using (in_stage(column('{side}_strain'))):'weft_force_N' with linespoints title 'weft'
)",
                     fmt::arg("title", gnuplot_string(title)), fmt::arg("side", stage.side),
                     fmt::arg("stage", gnuplot_string(stage.name)));
}

bool plot_curves(const OutputDirectory& out, const std::vector<micro::CurvePoint>& curve, const std::string& title) {
  const std::optional<PlottedStage> stage = strained_stage(curve);
  if (!stage) return true;
  write_whole_file(out.root() / "curves.gp", plot_script(*stage, title + ", stage " + stage->name));
  return run_gnuplot(out.root(), "curves.gp");
}

}  // namespace trame::workflows
