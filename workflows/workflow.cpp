#include "workflows/workflow.h"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "micro/core/error.h"
#include "micro/io/fibers_vtk.h"
#include "micro/io/snapshot.h"
#include "micro/simulate.h"
#include "workflows/command_line.h"
#include "workflows/curves_plot.h"
#include "workflows/environment.h"
#include "workflows/load_ratio.h"
#include "workflows/report.h"
#include "workflows/scene_overview.h"

namespace trame::workflows {

namespace {

micro::Scene load_scene(const Options& options) {
  micro::Scene scene = micro::read_scene(find_scene(options.scene, data_directory()));
  return options.alpha ? with_weft_ratio(std::move(scene), *options.alpha) : scene;
}

micro::SimulationSummary simulate(const micro::Scene& scene, const Options& options, micro::SimulateOptions run,
                                  const OutputDirectory& out, Terminal& terminal) {
  run.states = out.states();
  run.n_threads = options.n_threads;
  run.stop = &stop_on_signals();
  run.on_increment = [&](const micro::Progress& progress) { terminal.progress(progress); };
  if (options.verbose) run.log = [&](const std::string& text) { terminal.line(text); };
  micro::SimulationSummary summary = micro::simulate(scene, run);
  terminal.end_progress();
  return summary;
}

void write_summary(const OutputDirectory& out, const micro::Scene& scene, const Options& options,
                   const micro::SimulationSummary& summary, const nlohmann::json& derived) {
  nlohmann::json json = summary_json(scene.name, options.alpha, summary);
  json.update(derived);
  write_whole_file(out.summary(), json.dump(2) + "\n");
}

void write_fibers(const OutputDirectory& out, Timers& timers) {
  const auto io = timers.measure(Phase::io);
  micro::write_fibers_vtk(micro::SnapshotReader(out.states()), out.vtk());
}

void tell_outcome(Terminal& terminal, const micro::SimulationSummary& summary) {
  using Status = micro::SimulationSummary::Status;
  if (summary.status == Status::interrupted)
    terminal.line("Interrupted: everything up to the last increment is saved.");
  if (summary.status == Status::gave_up)
    terminal.line(fmt::format("The solver gave up: {}\nThe last good state is saved.", summary.message));
  if (!summary.crossing_order_ok)
    terminal.line(fmt::format("Crossing order: only {} of {} crossings agree with the weave.", summary.n_crossings_ok,
                              summary.n_crossings));
}

void tell_results(Terminal& terminal, const OutputDirectory& out, double seconds) {
  static constexpr std::array<std::pair<const char*, const char*>, 6> files = {{
      {"summary.json", "sizes, accuracy, energies, times"},
      {"curves.csv", "strains and forces of the sides"},
      {"curves.svg", "their picture"},
      {"states.h5", "every saved state, for strain_post"},
      {"vtk/fibers.pvd", "ParaView: open, Apply; filter Tube, Scalars radius, Vary Radius By Absolute Scalar"},
      {"vtk/yarns.pvd", "ParaView: open, Apply; colour by E_axial"},
  }};
  terminal.line(fmt::format("\nResults in {} after {}:", out.root().string(), duration_text(seconds)));
  for (const auto& [file, meaning] : files)
    if (std::filesystem::exists(out.root() / file)) terminal.line(fmt::format("  {:<16}{}", file, meaning));
}

void write_curves(const OutputDirectory& out, const micro::Scene& scene, const micro::SimulationSummary& summary,
                  Terminal& terminal) {
  if (!scene.weave) return;  // only a weave has sides
  write_whole_file(out.curves(), curves_csv(summary.curve));
  if (!plot_curves(out, summary.curve, scene.title))
    terminal.line("No picture of the curves: gnuplot is not installed, or failed on curves.gp.");
}

/// Where to start from; checked before an earlier run is overwritten.
micro::SimulateOptions start_of(const micro::Scene& scene, const Options& options, const std::filesystem::path& folder) {
  micro::SimulateOptions run;
  run.start_from = options.start_from;
  run.after = options.after;
  std::error_code none;
  if (std::filesystem::equivalent(run.start_from, folder / "states.h5", none))
    throw InputError(fmt::format("--start-from {}: the results would be written over it; choose another --out", options.start_from));
  micro::check_start(scene, run);
  return run;
}

int run_scene(const micro::Scene& scene, const Options& options, const Program& program, Terminal& terminal) {
  const std::filesystem::path folder = options.out.value_or(default_output(scene.name, options.alpha));
  const micro::SimulateOptions start = start_of(scene, options, folder);
  const OutputDirectory out(folder, options.overwrite);
  micro::SimulationSummary summary = simulate(scene, options, start, out, terminal);
  tell_outcome(terminal, summary);
  nlohmann::json derived = nlohmann::json::object();
  write_summary(out, scene, options, summary, derived);  // stays if something below fails
  write_curves(out, scene, summary, terminal);
  write_fibers(out, summary.timers);
  if (program.from_states) derived = program.from_states(out, summary.n_threads, summary.timers, terminal);
  write_summary(out, scene, options, summary, derived);
  tell_results(terminal, out, summary.timers.total());
  return summary.status == micro::SimulationSummary::Status::gave_up ? exit_gave_up : exit_done;
}

int run_command_line(const Program& program, int argc, char** argv) {
  const std::optional<Options> options = parse_command_line(argc, argv, program.description);
  Terminal terminal(stdout);
  if (!options) return exit_done;
  if (options->print_schema) {
    terminal.line(micro::scene_schema());
    return exit_done;
  }
  const micro::Scene scene = load_scene(*options);
  const micro::ModelSize size = micro::model_size(scene);
  terminal.line(fmt::format("{}: {}", scene.name, scene.title));
  terminal.line(options->check ? scene_overview(scene, size) : size_text(size));
  if (options->check) return exit_done;
  if (options->verbose) terminal.line(fmt::format("OpenBLAS kernel {}", blas_kernel()));
  return run_scene(scene, *options, program, terminal);
}

}  // namespace

int run_program(const Program& program, int argc, char** argv) {
  const auto fail = [&](const char* kind, const std::exception& error, int code) {
    std::fflush(stdout);
    fmt::print(stderr, "{}: {}{}\n", program.name, kind, error.what());
    return code;
  };
  choose_blas_kernel(argv);
  try {
    return run_command_line(program, argc, argv);
  } catch (const InputError& error) {
    return fail("", error, exit_bad_input);
  } catch (const SolverFailure& error) {
    return fail("the solver gave up: ", error, exit_gave_up);
  } catch (const std::exception& error) {
    return fail("unexpected failure: ", error, exit_unexpected);
  }
}

}  // namespace trame::workflows
