#include "workflows/report/run_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "micro/core/error.h"
#include "micro/scene/tolerances.h"
#include "workflows/report/html.h"
#include "workflows/report/report_data.h"
#include "workflows/report/report_plots.h"

namespace trame::workflows {

namespace {

std::string percent(double share) {
  return std::abs(share) < 1 ? fmt::format("{:.2g} %", 100 * share) : fmt::format("{:.0f} %", 100 * share);
}

/// A number with commas between thousands.
std::string with_commas(std::int64_t number) {
  std::string digits = std::to_string(number);
  for (int at = static_cast<int>(digits.size()) - 3; at > 0; at -= 3) digits.insert(at, ",");
  return digits;
}

std::vector<std::pair<std::string, std::string>> work_of(const nlohmann::json& json) {
  constexpr std::array<std::pair<const char*, const char*>, 7> counts = {
      {{"unknowns", "n_dofs"},
       {"contact elements, at most", "n_contact_elements_max"},
       {"increments", "n_increments"},
       {"of these cut", "n_cut_increments"},
       {"Newton iterations", "n_newton_iterations"},
       {"factorisations", "n_factorizations"},
       {"threads", "threads"}}};
  std::vector<std::pair<std::string, std::string>> work;
  for (const auto& [what, key] : counts)
    if (json.contains(key)) work.emplace_back(what, with_commas(json[key].get<std::int64_t>()));
  if (json.contains("peak_memory_bytes"))
    work.emplace_back("memory", fmt::format("{:.3g} GB", 1e-9 * json["peak_memory_bytes"].get<double>()));
  return work;
}

RunSummary run_summary(const nlohmann::json& json) {
  RunSummary summary;
  summary.work = work_of(json);
  if (json.value("status", "") == "gave_up")
    summary.warnings.push_back("the solver gave up: " + json.value("message", ""));
  if (json.value("status", "") == "interrupted") summary.warnings.emplace_back("the run was interrupted");
  if (json.value("status", "") == "cannot_write")
    summary.warnings.push_back("the run ended early: " + json.value("message", ""));
  if (json.contains("warnings"))
    for (const nlohmann::json& warning : json["warnings"]) summary.warnings.push_back(warning.get<std::string>());
  if (json.contains("n_crossings") && json.contains("n_crossings_ok"))
    summary.crossings = {json["n_crossings_ok"].get<int>(), json["n_crossings"].get<int>()};
  if (!json.contains("seconds")) return summary;
  for (const auto& [phase, seconds] : json["seconds"].items())
    if (phase == "total")
      summary.total_seconds = seconds.get<double>();
    else
      summary.seconds.emplace_back(phase, seconds.get<double>());
  return summary;
}

std::string badge(bool good) {
  return good ? "<span class=\"badge good\">good</span>" : "<span class=\"badge fair\">look</span>";
}

/// What is found, what is wanted, and whether that is good: cells of a row.
std::string cells(const std::string& found, const std::string& wanted, const std::string& verdict) {
  return fmt::format("<td>{}</td><td>{}</td><td>{}</td>", found, wanted, verdict);
}

std::string crossing_cells(const RunSummary& summary) {
  if (!summary.crossings) return cells("not known", "all", "");
  const auto [ok, all] = *summary.crossings;
  return cells(fmt::format("{} of {}", ok, all), "all", badge(ok == all));
}

/// What certificates are held against.
struct CertificateLimits {
  double penetration = 0.05;  ///< of R
  double imbalance = micro::friction_tolerance(micro::SolverSettings());
  double energy = 0.01;  ///< of the external work
};

/// A scene may ask for contact that is softer than usual, and for other tolerances.
CertificateLimits certificate_limits(const std::optional<micro::Scene>& scene) {
  CertificateLimits limits;
  if (scene) {
    limits.penetration = std::max(limits.penetration, scene->contact.target_penetration);
    limits.imbalance = micro::friction_tolerance(scene->solver);
  }
  return limits;
}

std::string limited_cells(double share, double limit, const char* of = "") {
  return cells(percent(share) + of, fmt::format("≤ {}{}", percent(limit), of), badge(std::abs(share) <= limit));
}

}  // namespace

RunSummary read_run_summary(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw InputError(fmt::format("{}: cannot be read", file.string()));
  try {
    return run_summary(nlohmann::json::parse(stream));
  } catch (const nlohmann::json::exception& error) {
    throw InputError(fmt::format("{}: not the summary of a run: {}", file.string(), error.what()));
  }
}

std::string what_is_missing(const std::optional<micro::Scene>& scene, const micro::Increment& last) {
  if (!scene || scene->stages.empty()) return {};
  const auto& stages = scene->stages;
  const auto at =
      std::find_if(stages.begin(), stages.end(), [&](const auto& stage) { return stage.name == last.stage; });
  if (at + 1 == stages.end() && last.stage_time == 1) return {};
  const auto n_left = (at == stages.end() ? stages.size() : static_cast<std::size_t>(stages.end() - at - 1));
  return fmt::format(
      "the run has not reached its end: its last state is at {:.0f} % of stage {}{}, and what follows is of "
      "the run so far",
      100 * last.stage_time, last.stage,
      n_left == 0 ? "" : fmt::format(", with {} of {} stages not begun", n_left, stages.size()));
}

std::string warnings_html(const RunSummary& summary) {
  std::string text;
  for (const std::string& warning : summary.warnings) text += note("<b>Warning:</b> " + escaped(warning) + ".");
  return text;
}

std::string certificates_html(const micro::FiberMesh& mesh, const std::optional<micro::Scene>& scene,
                              const micro::Increment& b, const RunSummary& summary) {
  const micro::SolverRecord& solver = b.solver;
  const micro::EnergyRecord& energy = solver.energy;
  const CertificateLimits limits = certificate_limits(scene);
  const double balance = energy.external_work != 0 ? energy.imbalance / std::abs(energy.external_work) : 0;
  const auto microjoules = [](double joules) { return fmt::format("{:.3g}", 1e6 * joules); };
  return filled("certificates",
                {{"weave", has_weave(mesh)},
                 {"crossings", crossing_cells(summary)},
                 {"penetration", limited_cells(solver.max_penetration_over_radius, limits.penetration, " of R")},
                 {"force", limited_cells(solver.force_imbalance, limits.imbalance)},
                 {"moment", limited_cells(solver.moment_imbalance, limits.imbalance)},
                 {"damping", cells(fmt::format("{:.2g}", solver.proximal), "0", badge(solver.proximal == 0))},
                 {"energy", limited_cells(balance, limits.energy)},
                 {"work", microjoules(energy.external_work)},
                 {"stored", microjoules(energy.stored)},
                 {"friction", microjoules(energy.friction)},
                 {"damped", microjoules(energy.damping)},
                 {"released", microjoules(energy.release)}});
}

std::string work_table(const RunSummary& summary) {
  if (summary.work.empty()) return {};
  HtmlTable sizes{.header = {}, .rows = {{}}};
  for (const auto& [what, how_much] : summary.work) {
    sizes.header.push_back(what);
    sizes.rows[0].push_back(how_much);
  }
  return table(sizes);
}

std::string timing_figure(const RunSummary& summary) {
  if (summary.total_seconds <= 0) return {};
  std::vector<std::pair<std::string, double>> parts = summary.seconds;
  double rest = summary.total_seconds;
  for (const auto& part : parts) rest -= part.second;
  if (rest > 0) parts.emplace_back("not measured", rest);
  return figure(share_bar_svg(std::move(parts)),
                filled("timing_caption", {{"seconds", fmt::format("{:.4g}", summary.total_seconds)}}));
}

}  // namespace trame::workflows
