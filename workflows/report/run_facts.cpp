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
#include "workflows/report/html.h"
#include "workflows/report/report_data.h"
#include "workflows/report/report_plots.h"
#include "workflows/report/scene_settings.h"

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

std::vector<std::string> crossing_row(const RunSummary& summary) {
  const std::string meaning = "Crossings where the yarn that the pattern puts on top is on top, at the end of the run.";
  if (!summary.crossings) return {"Crossing order", "not known", "all", "", meaning};
  const auto [ok, all] = *summary.crossings;
  return {"Crossing order", fmt::format("{} of {}", ok, all), "all", badge(ok == all), meaning};
}

/// What certificates are held against.
struct CertificateLimits {
  double penetration = 0.05;  ///< of R
  double imbalance = micro::SolverSettings().geometry_tolerance;
  double energy = 0.01;  ///< of the external work
};

/// A scene may ask for contact that is softer than usual; its geometry tolerance is what increments end on.
CertificateLimits certificate_limits(const micro::SnapshotHeader& header) {
  CertificateLimits limits;
  if (const std::optional<micro::Scene> scene = scene_of(header)) {
    limits.penetration = std::max(limits.penetration, scene->contact.target_penetration);
    limits.imbalance = scene->solver.geometry_tolerance;
  }
  return limits;
}

std::vector<std::string> limited_row(const char* name, double share, double limit, const char* of,
                                     const std::string& meaning) {
  return {name, percent(share) + of, fmt::format("≤ {}{}", percent(limit), of), badge(std::abs(share) <= limit),
          meaning};
}

std::vector<std::vector<std::string>> solver_rows(const micro::SolverRecord& solver, const CertificateLimits& limits,
                                                  bool is_weave) {
  const micro::EnergyRecord& energy = solver.energy;
  const double balance = energy.external_work != 0 ? energy.imbalance / std::abs(energy.external_work) : 0;
  return {limited_row("Penetration", solver.max_penetration_over_radius, limits.penetration, " of R",
                      "Deepest overlap of two fibers over the fiber radius; contact is a stiff spring, so it is never "
                      "quite zero."),
          limited_row("Force imbalance", solver.force_imbalance, limits.imbalance, "",
                      "Forces that are left over, against the forces that cancel; the limit is the scene’s "
                      "<code>geometry_tolerance</code>."),
          limited_row("Moment imbalance", solver.moment_imbalance, limits.imbalance, "",
                      "The same for the moments of all bodies’ pulls."),
          {"Damping η", fmt::format("{:.2g}", solver.proximal), "0", badge(solver.proximal == 0),
           "Artificial resistance that helps the solver; 0 means that this state is an equilibrium."},
          limited_row("Energy balance", balance, limits.energy, "",
                      fmt::format("Work that is not accounted for, against the external work, {:.3g} µJ, since the "
                                  "start{}. {:.3g} µJ are stored, {:.3g} µJ rubbed off, {:.3g} µJ "
                                  "damped.",
                                  1e6 * energy.external_work, is_weave ? ", weaving included" : "", 1e6 * energy.stored,
                                  1e6 * energy.friction, 1e6 * energy.damping))};
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

std::string warnings_html(const RunSummary& summary) {
  std::string text;
  for (const std::string& warning : summary.warnings) text += note("<b>Warning:</b> " + escaped(warning) + ".");
  return text;
}

std::string certificates_html(const micro::SnapshotHeader& header, const micro::Increment& b,
                              const RunSummary& summary) {
  std::vector<std::vector<std::string>> rows;
  const bool is_weave = has_weave(header.mesh);
  if (is_weave) rows.push_back(crossing_row(summary));
  for (auto& row : solver_rows(b.solver, certificate_limits(header), is_weave)) rows.push_back(std::move(row));
  return table({.header = {"", "found", "wanted", "", "what it means"}, .rows = std::move(rows), .kind = "text"});
}

std::string work_html(const RunSummary& summary) {
  if (summary.work.empty()) return {};
  HtmlTable sizes{.header = {}, .rows = {{}}};
  for (const auto& [what, how_much] : summary.work) {
    sizes.header.push_back(what);
    sizes.rows[0].push_back(how_much);
  }
  return "<h3>Size and work</h3>\n" + table(sizes);
}

std::string timing_html(const RunSummary& summary) {
  if (summary.total_seconds <= 0) return note("Times are in the run’s summary.json, which was not given.");
  std::vector<std::pair<std::string, double>> parts = summary.seconds;
  double rest = summary.total_seconds;
  for (const auto& part : parts) rest -= part.second;
  if (rest > 0) parts.emplace_back("not measured", rest);
  return figure(share_bar_svg(std::move(parts)),
                fmt::format("Where the run’s {:.4g} s of wall-clock time went.", summary.total_seconds));
}

}  // namespace trame::workflows
