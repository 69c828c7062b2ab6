#include "workflows/accuracy/work_precision.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "workflows/accuracy/study_tables.h"
#include "workflows/program/gnuplot.h"

namespace trame::workflows {

namespace {

/// An error of nothing at all has no place on a logarithmic axis.
bool can_be_drawn(const CaseResult& r) { return r.is_done() && std::isfinite(r.error) && r.error > 0; }

using Error = double CaseResult::*;

std::string data_block(const std::string& name, const std::vector<const CaseResult*>& results,
                       Error error = &CaseResult::error) {
  std::string block = fmt::format("${} << END\n", name);
  for (const CaseResult* r : results)
    if (can_be_drawn(*r)) block += fmt::format("{:.6g} {:.6g}\n", r->cpu(), 100 * r->*error);
  return block + "END\n";
}

/// From coarse to fine: as planned, with the base put where its fineness belongs.
std::vector<const CaseResult*> line_of(const Study& study, const Knob& knob) {
  std::vector<const CaseResult*> line = along_knob(study, knob.name);
  const auto fine = [&](const CaseResult* r) {
    return fineness(r->what.settings.empty() ? Setting{knob.name, study.scene_values.at(knob.name)}
                                             : r->what.settings.front());
  };
  if (!line.empty() && std::isfinite(fine(line.front())))
    std::stable_sort(line.begin(), line.end(),
                     [&](const CaseResult* a, const CaseResult* b) { return fine(a) < fine(b); });
  return line;
}

}  // namespace

std::string work_precision_script(const Study& study) {
  std::string blocks;
  std::vector<std::string> plots;
  std::vector<const CaseResult*> combinations;
  for (const CaseResult& r : study.results)
    if (r.what.settings.size() > 1 && can_be_drawn(r)) combinations.push_back(&r);
  if (!combinations.empty()) {
    blocks += data_block("combinations", combinations);
    plots.push_back("$combinations using 1:2 with points pt 1 lc rgb '#999999' title 'several knobs'");
  }
  for (const Knob& knob : knobs()) {
    const std::vector<const CaseResult*> line = line_of(study, knob);
    if (std::none_of(line.begin(), line.end(), [](const CaseResult* r) { return can_be_drawn(*r); })) continue;
    blocks += data_block(knob.name, line);
    plots.push_back(fmt::format("${0} using 1:2 with linespoints pt 7 ps 0.6 dt {1} title {2}", knob.name,
                                knob.is_numerical ? 1 : 2,
                                gnuplot_string(knob.name + (knob.is_numerical ? "" : " (other effects)"))));
  }
  if (plots.empty()) return "";
  blocks += data_block("pareto", pareto_front(study), &CaseResult::trusted_error);
  plots.push_back("$pareto using 1:2 with steps lw 2 lc rgb '#000000' title 'Pareto front (trusted error)'");
  plots.push_back("$pareto using 1:2 with points pt 6 ps 1.5 lw 2 lc rgb '#000000' notitle");
  if (study.reference_uncertainty > 0)
    plots.push_back(fmt::format("{:.6g} with lines dt 3 lc rgb '#cc0000' title 'uncertainty of the reference'",
                                100 * study.reference_uncertainty));
  std::string script =
      blocks + fmt::format(
                   "set title {} noenhanced\nset logscale xy\nset xlabel 'CPU time (s)'\n"
                   "set ylabel {} noenhanced\nset key outside right noenhanced\nset grid\nplot ",
                   gnuplot_string("What accuracy costs: " + study.scene), gnuplot_string(study.measure + " (%)"));
  for (std::size_t i = 0; i < plots.size(); ++i) script += (i == 0 ? "" : ", \\\n     ") + plots[i];
  return script + "\n";
}

}  // namespace trame::workflows
