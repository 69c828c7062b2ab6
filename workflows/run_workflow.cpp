/// Simulates a scene, computes the strains of its yarns and writes a report: the whole way from a TOML file to a folder
/// of results.

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "meso/analyse.h"
#include "workflows/report/html_report.h"
#include "workflows/workflow.h"

namespace trame::workflows {

namespace {

/// The yarns at the end of the run, for summary.json.
nlohmann::json yarns_json(const micro::SnapshotReader& states, const meso::Analysis& analysis) {
  nlohmann::json yarns = nlohmann::json::array();
  for (const meso::YarnStrain& strain : analysis.strains) {
    if (strain.increment != states.n_increments() - 1) continue;
    yarns.push_back({{"name", states.header().mesh.yarns[strain.yarn].name},
                     {"n_tets", strain.n_tets},
                     {"n_flagged", strain.n_flagged},
                     {"E_axial_mean", strain.axial.mean},
                     {"E_axial_min", strain.axial.min},
                     {"E_axial_max", strain.axial.max}});
  }
  return {{"yarns", yarns}};
}

/// Strains of all yarns from the flat start to every saved state.
nlohmann::json analyse_yarns(const OutputDirectory& out, int n_threads, Timers& timers, Terminal& terminal) {
  const auto time = timers.measure(Phase::meso);
  const micro::SnapshotReader states(out.states());
  meso::AnalyseOptions options;
  options.vtk_folder = out.vtk();
  options.n_threads = n_threads;
  const meso::Analysis analysis = meso::analyse(states, options);
  terminal.line(
      fmt::format("Strains of yarns: {} tetrahedra, {} saved states", analysis.n_tets(), states.n_increments()));
  return yarns_json(states, analysis);
}

void report(const OutputDirectory& out, Terminal& terminal) {
  const meso::RunStates states(out.states());
  const std::string lacks = write_report({.states = states,
                                          .pairs = pairs_of_run(states),
                                          .file = out.report(),
                                          .yarns = {},
                                          .summary = out.summary(),
                                          .curves = std::filesystem::exists(out.curves()) ? out.curves() : ""});
  if (!lacks.empty()) terminal.line("The report lacks something: " + lacks);
}

}  // namespace

}  // namespace trame::workflows

int main(int argc, char** argv) {
  using namespace trame::workflows;
  return run_program(
      {.name = "run_workflow",
       .description = "Simulates the fibers of a scene, then computes the strains of its yarns and writes a report.",
       .from_states = analyse_yarns,
       .from_results = report},
      argc, argv);
}
