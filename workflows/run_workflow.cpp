/// Simulates a scene, computes the strains of its yarns and writes a report: the whole way from a TOML file to a folder
/// of results.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "meso/strain_series.h"
#include "workflows/report/fabric_table.h"
#include "workflows/report/html_report.h"
#include "workflows/workflow.h"

namespace trame::workflows {

namespace {

/// The yarns of a run, and its report's pairs of states.
struct YarnResults {
  meso::RunStates states;
  meso::YarnComparer comparer;
  std::vector<meso::Comparison> comparisons = {};

  YarnResults(const std::filesystem::path& file, int n_threads)
      : states(file),
        comparer(states, {.bands_of = detailed_yarns(states.header().mesh.yarns, {}), .n_threads = n_threads}) {}
};

/// Strains from the flat start to the end of the run, for summary.json.
nlohmann::json yarns_json(const micro::FiberMesh& mesh, const std::vector<meso::YarnStrain>& strains) {
  nlohmann::json yarns = nlohmann::json::array();
  for (const meso::YarnStrain& strain : strains)
    if (strain.n_tets > 0)
      yarns.push_back({{"name", mesh.yarns[strain.yarn].name},
                       {"n_tets", strain.n_tets},
                       {"n_flagged", strain.n_flagged},
                       {"E_axial_mean", strain.axial.mean},
                       {"E_axial_min", strain.axial.min},
                       {"E_axial_max", strain.axial.max}});
  return {{"yarns", yarns}};
}

/// Strains of all yarns from the flat start to every saved state, and everything between the report's pairs.
nlohmann::json analyse_yarns(YarnResults& results, const OutputDirectory& out, const micro::Copies& copies,
                             Terminal& terminal) {
  const Index n_states = results.states.n_increments();
  const std::vector<meso::StatePair> pairs = meso::pairs_of_run(results.states);
  std::vector<meso::YarnStrain> last;
  meso::StrainSeries series{.vtk_folders = {out.vtk()}, .copies = copies};
  for (const meso::StatePair& pair : pairs)
    if (pair.from == 0) series.compare.push_back(pair.to);
  series.on_state = [&](const meso::StateStrains& strains) { last = strains.meshes.front().summaries; };
  results.comparisons = follow(results.comparer, series);
  for (const meso::StatePair& pair : pairs)
    if (pair.from != 0) results.comparisons.push_back(results.comparer.compare(pair));
  terminal.line(fmt::format("Strains of yarns: {} tetrahedra, {} saved states",
                            results.comparer.n_tets(meso::MeshKind::delaunay), n_states));
  nlohmann::json json = yarns_json(results.states.header().mesh, last);
  if (const auto& fabric = results.comparisons.back().fabric) {
    json["fabric"] = fabric_json(*fabric);
    terminal.line(fabric_text(*fabric));
  }
  return json;
}

void report(const YarnResults& results, const OutputDirectory& out, Terminal& terminal) {
  ReportInput input{.states = results.states, .comparisons = {}, .file = out.report(), .summary = out.summary()};
  for (const meso::Comparison& comparison : results.comparisons) input.comparisons.push_back(&comparison);
  if (std::filesystem::exists(out.curves())) input.curves = out.curves();
  const std::string lacks = write_report(input);
  if (!lacks.empty()) terminal.line("The report lacks something: " + lacks);
}

}  // namespace

}  // namespace trame::workflows

int main(int argc, char** argv) {
  using namespace trame::workflows;
  std::unique_ptr<YarnResults> results;
  return run_program(
      {.name = "run_workflow",
       .description = "Simulates the fibers of a scene, then computes the strains of its yarns and writes a report.",
       .from_states =
           [&](const OutputDirectory& out, const trame::micro::Copies& copies, int n_threads, trame::Timers& timers,
               Terminal& terminal) {
             const auto time = timers.measure(trame::Phase::meso);
             results = std::make_unique<YarnResults>(out.states(), n_threads);
             return analyse_yarns(*results, out, copies, terminal);
           },
       .from_results = [&](const OutputDirectory& out, Terminal& terminal) { report(*results, out, terminal); }},
      argc, argv);
}
