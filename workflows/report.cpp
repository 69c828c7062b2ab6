#include "workflows/report.h"

#include <fmt/format.h>

#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>

#include "workflows/curves/test_curve.h"

namespace trame::workflows {

namespace {

/// Largest resident memory of this program so far; the kernel counts kilobytes. Not that of getrusage, which starts
/// with the memory of the process that started this one.
std::int64_t peak_memory_bytes() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
    if (std::int64_t kilobytes = 0; word == "VmHWM:" && status >> kilobytes) return 1024 * kilobytes;
  return 0;
}

nlohmann::json seconds_json(const Timers& timers) {
  nlohmann::json seconds;
  for (std::size_t phase = 0; phase < n_phases; ++phase)
    seconds[std::string(phase_names[phase])] = timers.seconds(static_cast<Phase>(phase));
  seconds["total"] = timers.total();
  return seconds;
}

}  // namespace

CurvesTable curves_table(const micro::Scene& scene, const micro::SimulationSummary& summary) {
  const CurvesLayout layout = curves_layout(scene, summary.body_names);
  CurvesTable table{layout.columns(), {}};
  const auto add = [&](const micro::CurvePoint& point) {
    table.rows.push_back({point.stage, point.stage_time,
                          layout.values(point.side_strain, point.side_force, point.motion, point.reaction)});
  };
  auto start = summary.stage_starts.begin();
  for (const micro::CurvePoint& point : summary.curve) {
    if (start != summary.stage_starts.end() && start->stage == point.stage) add(*start++);
    add(point);
  }
  if (const auto test = scene.test_curve ? measured(*scene.test_curve, table) : std::nullopt) add_columns(*test, table);
  return table;
}

std::string status_text(micro::SimulationSummary::Status status) {
  using Status = micro::SimulationSummary::Status;
  switch (status) {
    case Status::done: return "done";
    case Status::interrupted: return "interrupted";
    case Status::gave_up: return "gave_up";
    case Status::cannot_write: return "cannot_write";
  }
  return "";
}

nlohmann::json summary_json(const std::string& scene, std::optional<double> alpha,
                            const micro::SimulationSummary& summary) {
  const micro::EnergyRecord& energy = summary.energy;
  nlohmann::json work;
  for (std::size_t s = 0; s < energy.work.size(); ++s) work[std::string(micro::source_names[s])] = energy.work[s];
  return {
      {"version", TRAME_VERSION},
      {"scene", scene},
      {"alpha", alpha ? nlohmann::json(*alpha) : nlohmann::json()},
      {"status", status_text(summary.status)},
      {"message", summary.message},
      {"threads", summary.n_threads},
      {"n_fibers", summary.size.n_fibers},
      {"n_nodes", summary.size.n_nodes},
      {"n_bodies", summary.size.n_bodies},
      {"n_dofs", summary.size.n_dofs},
      {"n_contact_elements_max", summary.n_contact_elements_max},
      {"n_increments", summary.n_increments},
      {"n_cut_increments", summary.n_cut_increments},
      {"n_newton_iterations", summary.n_newton_iterations},
      {"n_factorizations", summary.n_factorizations},
      {"max_penetration_over_radius", summary.max_penetration_over_radius},
      {"force_imbalance", summary.force_imbalance},
      {"moment_imbalance", summary.moment_imbalance},
      {"energy",
       {{"external_work", energy.external_work},
        {"stored", energy.stored},
        {"friction", energy.friction},
        {"damping", energy.damping},
        {"release", energy.release},
        {"imbalance", energy.imbalance},
        {"work", work}}},
      {"n_unstable_increments", summary.n_unstable_increments},
      {"n_buried_ends", summary.n_buried_ends},
      {"warnings", summary.warnings},
      {"crossing_order_ok", summary.crossing_order_ok},
      {"n_crossings", summary.n_crossings},
      {"n_crossings_ok", summary.n_crossings_ok},
      {"seconds", seconds_json(summary.timers)},
      {"peak_memory_bytes", peak_memory_bytes()},
  };
}

}  // namespace trame::workflows
