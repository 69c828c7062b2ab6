#include "workflows/accuracy/study_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "workflows/program/csv.h"
#include "workflows/program/terminal.h"

namespace trame::workflows {

namespace {

constexpr std::array count_names = {
    "n_dofs", "n_increments", "n_cut_increments", "n_newton_iterations", "n_factorizations", "n_contact_elements_max"};

/// An empty field where there is no number.
std::string number_field(double x) { return std::isfinite(x) ? fmt::format("{:.9g}", x) : ""; }

const Quantity* quantity(const CaseResult& result, const std::string& name) {
  const auto q = std::find_if(result.quantities.begin(), result.quantities.end(),
                              [&](const Quantity& x) { return x.name == name; });
  return q == result.quantities.end() ? nullptr : &*q;
}

std::vector<std::string> quantity_names(const Study& study) {
  std::vector<std::string> names;
  for (const CaseResult& r : study.results)
    for (const Quantity& q : r.quantities)
      if (std::find(names.begin(), names.end(), q.name) == names.end()) names.push_back(q.name);
  return names;
}

std::string csv_row(const CaseResult& r, const std::vector<std::string>& names) {
  const auto [low, high] = std::minmax_element(r.wall_seconds.begin(), r.wall_seconds.end());
  const bool ran = !r.wall_seconds.empty();
  std::string row = fmt::format("{},{},{},{},{},{},{},{},{},{}", csv_field(text(r.what.settings)), text(r.what.part),
                                r.status, r.wall_seconds.size(), number_field(r.seconds()),
                                ran ? number_field(*low) : "", ran ? number_field(*high) : "", number_field(r.cpu()),
                                r.peak_memory_bytes > 0 ? number_field(r.peak_memory_bytes) : "", r.what.same_effects);
  for (const char* name : count_names) row += "," + (r.counts.count(name) > 0 ? number_field(r.counts.at(name)) : "");
  row += "," + (r.errors.empty() ? "," : number_field(r.error) + "," + number_field(r.trusted_error)) + "," +
         (r.estimate ? number_field(*r.estimate) : "");
  for (const std::string& name : names) {
    const Quantity* q = quantity(r, name);
    row += fmt::format(",{},{}", q != nullptr ? number_field(q->value) : "",
                       r.errors.count(name) > 0 ? number_field(r.errors.at(name)) : "");
  }
  return row + "," + csv_field(r.message);
}

std::string percent(double x) { return std::isfinite(x) ? fmt::format("{:.2g} %", 100 * x) : "–"; }

const CaseResult& base_of(const Study& study) { return study.results.front(); }

/// Largest change of a group of quantities against the base, relative to its largest value there.
std::map<std::string, double> group_changes(const CaseResult& result, const CaseResult& base) {
  std::map<std::string, double> changes;
  const auto errors = relative_errors(result.quantities, base.quantities);
  for (const Quantity& q : result.quantities)
    if (errors.count(q.name) > 0) changes[q.group] = std::max(changes[q.group], errors.at(q.name));
  return changes;
}

std::vector<std::string> group_names(const CaseResult& result) {
  std::vector<std::string> names;
  for (const Quantity& q : result.quantities)
    if (std::find(names.begin(), names.end(), q.group) == names.end()) names.push_back(q.group);
  return names;
}

std::string effects_table(const Study& study) {
  const CaseResult& base = base_of(study);
  const std::vector<std::string> groups = group_names(base);
  std::string table = "| setting | status | CPU time | of base | memory |";
  for (const std::string& group : groups) table += " " + group + " |";
  table += "\n| --- | --- | --- | --- | --- |";
  for (std::size_t i = 0; i < groups.size(); ++i) table += " --- |";
  table += "\n";
  for (const CaseResult& r : study.results) {
    if (&r != &base && (r.what.same_effects || r.what.part != CasePart::one_knob)) continue;
    table += fmt::format("| {} | {} | {} | {:.2f} | {} |", text(r.what.settings), r.status, duration_text(r.cpu()),
                         r.cpu() / base.cpu(), bytes_text(r.peak_memory_bytes));
    const auto changes = group_changes(r, base);
    for (const std::string& group : groups)
      table += " " + (changes.count(group) > 0 ? percent(changes.at(group)) : "–") + " |";
    table += "\n";
  }
  return table;
}

std::string order_text(const std::optional<double>& order) { return order ? fmt::format("{:.1f}", *order) : ""; }

std::string orders_table(const Study& study) {
  std::string table =
      "| knob | value | CPU time | error | its order | distance from the finest | its order | theory |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- |\n";
  for (const Knob& knob : knobs())
    for (const OrderPoint& p : orders_along(study, knob))
      table += fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} |\n", knob.name, p.setting.value,
                           duration_text(p.cpu_seconds), percent(p.error), order_text(p.order), percent(p.distance),
                           order_text(p.own_order), knob.theory);
  return table;
}

std::string recommendation(const Profile& profile) {
  std::string table =
      "| error up to | settings | expected error | CPU time | wall clock | memory |\n| --- | --- | --- | --- | --- | "
      "--- |\n";
  for (const double level : {0.1, 0.03, 0.01, 0.003}) {
    const ProfileRun* run = cheapest(profile, level);
    table += run == nullptr ? fmt::format("| {:g} % | none held it | | | | |\n", 100 * level)
                            : fmt::format("| {:g} % | {} | {} | {} | {} | {} |\n", 100 * level, text(run->settings),
                                          percent(profile.expected_error(*run)), duration_text(run->cpu_seconds),
                                          duration_text(run->seconds), bytes_text(run->peak_memory_bytes));
  }
  return table;
}

std::string failures(const Study& study) {
  std::string list;
  for (const CaseResult& r : study.results)
    if (!r.is_done()) list += fmt::format("- {}: {}. {}\n", text(r.what.settings), r.status, r.message);
  return list.empty() ? "None.\n" : list;
}

std::string pareto_table(const Study& study) {
  std::string table =
      "| settings | CPU time | error | trusted error | a posteriori estimate |\n| --- | --- | --- | --- | --- |\n";
  for (const CaseResult* r : pareto_front(study))
    table += fmt::format("| {} | {} | {} | {} | {} |\n", text(r->what.settings), duration_text(r->cpu()),
                         percent(r->error), percent(r->trusted_error), r->estimate ? percent(*r->estimate) : "–");
  return table;
}

}  // namespace

void write_study_csv(const std::filesystem::path& file, const Study& study) {
  const std::vector<std::string> names = quantity_names(study);
  std::string header =
      "settings,part,status,n_repeats,wall_s,wall_min_s,wall_max_s,cpu_s,peak_memory_bytes,same_effects";
  for (const char* name : count_names) header += fmt::format(",{}", name);
  header += ",error,trusted_error,a_posteriori_estimate";
  for (const std::string& name : names) header += fmt::format(",{},error of {}", csv_field(name), csv_field(name));
  CsvFile out(file, header + ",message");
  for (const CaseResult& r : study.results) out << csv_row(r, names) << '\n';
  out.write();
}

std::vector<const CaseResult*> along_knob(const Study& study, const std::string& knob) {
  std::vector<const CaseResult*> found;
  for (const CaseResult& r : study.results)
    if (r.is_done() && r.what.settings.size() == 1 && r.what.settings.front().knob == knob) found.push_back(&r);
  if (!found.empty() && base_of(study).is_done()) found.push_back(&base_of(study));
  return found;
}

std::vector<const CaseResult*> pareto_front(const Study& study) {
  std::vector<const CaseResult*> done, front;
  for (const CaseResult& r : study.results)
    if (r.is_done() && r.what.same_effects && std::isfinite(r.error)) done.push_back(&r);
  std::stable_sort(done.begin(), done.end(),
                   [](const CaseResult* a, const CaseResult* b) { return a->cpu() < b->cpu(); });
  for (const CaseResult* r : done)
    if (front.empty() || r->trusted_error < front.back()->trusted_error) front.push_back(r);
  return front;
}

std::vector<OrderPoint> orders_along(const Study& study, const Knob& knob) {
  std::vector<std::pair<Setting, const CaseResult*>> runs;
  for (const CaseResult* r : along_knob(study, knob.name)) {
    const Setting setting =
        r->what.settings.empty() ? Setting{knob.name, study.scene_values.at(knob.name)} : r->what.settings.front();
    if (std::isfinite(fineness(setting))) runs.emplace_back(setting, r);
  }
  std::sort(runs.begin(), runs.end(),
            [](const auto& a, const auto& b) { return fineness(a.first) < fineness(b.first); });
  if (runs.size() < 2) return {};
  const std::vector<Quantity>& finest = runs.back().second->quantities;
  const auto order = [](double coarse, double fine, double refinement) -> std::optional<double> {
    if (!(coarse > 0 && fine > 0)) return std::nullopt;
    return std::log(coarse / fine) / std::log(refinement);
  };
  std::vector<OrderPoint> points;
  for (const auto& [setting, run] : runs) {
    const double distance = primary_error(run->quantities, relative_errors(run->quantities, finest));
    OrderPoint point{setting, run->cpu(), run->error, distance, {}, {}};
    if (!points.empty()) {
      const double refinement = fineness(setting) / fineness(points.back().setting);
      point.order = order(points.back().error, point.error, refinement);
      point.own_order = order(points.back().distance, point.distance, refinement);
    }
    points.push_back(point);
  }
  return points;
}

std::string study_markdown(const Study& study, const Profile& profile, const std::string& command) {
  std::string page = fmt::format("# What accuracy costs: {}\n\n{}\n\n    {}\n\n", study.scene, study.title, command);
  page += fmt::format(
      "{} cases, each in a process of its own on {} threads, medians of {} runs in alternating order (of the "
      "references one run). "
      "Time is CPU time: it does not depend on what else the machine did. Trame {}.\n\n",
      study.results.size(), study.n_threads, study.n_repeats, TRAME_VERSION);
  if (study.has_reference)
    page += fmt::format(
        "Error: {}, against {}, which is itself uncertain by {}.\n\n## Settings for an error\n\n{}\n"
        "Expected error: the trusted error plus the uncertainty of the reference. Trusted is the largest error of a "
        "case and of all that are at "
        "least as fine in every knob: a coarse one may be close to the reference by chance.\n\n## Pareto "
        "front\n\n{}\n",
        study.measure, study.reference, percent(study.reference_uncertainty), recommendation(profile),
        pareto_table(study));
  else
    page += "No errors: a reference run did not end well.\n\n";
  page +=
      "## What each effect costs, and what changes without it\n\nLargest change of each group of quantities against "
      "the base.\n\n" +
      effects_table(study);
  page += fmt::format(
      "\n## Convergence\n\nOne knob at a time, all others as in the scene. The error holds what they contribute; the "
      "distance "
      "from the knob's finest value does not, but is too small near that value. Orders since the value before.\n\n{}\n",
      orders_table(study));
  return page + "## Failures\n\n" + failures(study);
}

}  // namespace trame::workflows
