#include "workflows/workflow.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <ranges>
#include <utility>

#include "micro/core/error.h"
#include "micro/core/text.h"
#include "micro/simulate.h"
#include "micro/solve/threads.h"
#include "micro/states/fibers_vtk.h"
#include "micro/states/snapshot.h"
#include "micro/states/surfaces_vtk.h"
#include "workflows/accuracy/estimate.h"
#include "workflows/accuracy/profile.h"
#include "workflows/curves/curves_plot.h"
#include "workflows/load_ratio.h"
#include "workflows/memory.h"
#include "workflows/program/command_line.h"
#include "workflows/program/environment.h"
#include "workflows/program/file_probe.h"
#include "workflows/report.h"
#include "workflows/scene_overview.h"
#include "workflows/warnings.h"

namespace trame::workflows {

namespace {

/// What is simulated, and what is known beforehand about its accuracy.
struct Task {
  micro::Scene scene;
  Settings settings;                    ///< that `scene` has already
  std::optional<Profile> profile;       ///< of the scene, where there is one that fits
  std::optional<ProfileRun> known_run;  ///< of the profile, with these settings
};

/// The profile of a scene; where it is only of use and not asked for, one that is missing or does not fit is no error.
std::optional<Profile> load_profile(const std::filesystem::path& scene_file, const micro::Scene& scene,
                                    bool is_asked_for) {
  const std::filesystem::path file = profile_file(scene_file, data_directory());
  if (is_asked_for) return read_profile_of(file, scene);
  try {
    return read_profile_of(file, scene);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

Task load_task(const Options& options) {
  const std::filesystem::path file = find_scene(options.scene, data_directory());
  Task task{micro::read_scene(file), {}, {}, {}};
  const double accuracy = options.accuracy.empty() ? 0 : parse_accuracy(options.accuracy);
  const bool is_as_studied = !options.alpha && options.start_from.empty();
  if (is_as_studied) task.profile = load_profile(file, task.scene, accuracy > 0);
  for (const std::string& setting : options.settings) task.settings.push_back(parse_setting(setting));
  if (accuracy > 0) task.settings = choose_settings(*task.profile, accuracy).settings;
  if (const ProfileRun* run = task.profile ? find_run(*task.profile, task.settings) : nullptr) task.known_run = *run;
  task.scene = with_settings(std::move(task.scene), task.settings);
  if (options.alpha) task.scene = with_weft_ratio(std::move(task.scene), *options.alpha);
  return task;
}

std::string accuracy_text(const Profile& profile, const ProfileRun& run) {
  return fmt::format("Settings: {}. Expected error {:.2g} %: {}, against {}. In the study they took {} of CPU time.",
                     text(run.settings), 100 * profile.expected_error(run), profile.measure, profile.reference,
                     duration_text(run.cpu_seconds));
}

micro::SimulationSummary simulate(const micro::Scene& scene, const Options& options, micro::SimulateOptions run,
                                  Terminal& terminal) {
  run.n_threads = options.n_threads;
  run.stop = &stop_on_signals();
  run.on_increment = [&](const micro::Progress& progress) { terminal.progress(progress); };
  if (options.verbose) run.log = [&](const std::string& text) { terminal.line(text); };
  micro::SimulationSummary summary = micro::simulate(scene, run);
  terminal.end_progress();
  return summary;
}

void write_summary(const OutputDirectory& out, const Task& task, const Options& options,
                   const micro::SimulationSummary& summary, const nlohmann::json& derived) {
  nlohmann::json json = summary_json(task.scene.name, options.alpha, summary);
  json["settings"] = nlohmann::json::object();
  for (const Setting& setting : task.settings) json["settings"][setting.knob] = setting.value;
  json.update(derived);
  // Text that came with files need not be UTF-8.
  write_whole_file(out.summary(), json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

void write_fibers(const OutputDirectory& out, const micro::Copies& copies, Timers& timers) {
  const auto io = timers.measure(Phase::io);
  const micro::SnapshotReader states(out.states());
  micro::write_fibers_vtk(states, out.vtk(), copies);
  micro::write_surfaces_vtk(states, out.vtk(), copies);
}

void tell_outcome(Terminal& terminal, const micro::SimulationSummary& summary) {
  using Status = micro::SimulationSummary::Status;
  if (summary.status == Status::interrupted)
    terminal.line("Interrupted: everything up to the last increment is saved. The same command with --resume goes on.");
  if (summary.status == Status::cannot_write) terminal.line(fmt::format("Ended early: {}.", summary.message));
  if (summary.status == Status::gave_up)
    terminal.line(fmt::format("The solver gave up: {}\nThe last good state is saved.", summary.message));
  for (const std::string& warning : summary.warnings) terminal.line("Warning: " + warning + ".");
}

void tell_results(Terminal& terminal, const OutputDirectory& out, double seconds) {
  static constexpr std::array<std::pair<const char*, const char*>, 9> files = {{
      {"report.html", "all of it at a glance: open in a browser"},
      {"summary.json", "sizes, accuracy, energies, times"},
      {"curves.csv", "motion and reaction of everything that is driven"},
      {"branches.csv", "loading and unloading: stiffness, work, loops"},
      {"curves.svg", "their picture"},
      {"states.h5", "every saved state, for strain_post"},
      {"vtk/fibers.pvd", "ParaView: open, Apply; filter Tube, Scalars radius, Vary Radius By Absolute Scalar"},
      {"vtk/yarns.pvd", "ParaView: open, Apply; colour by E_axial"},
      {"vtk/surfaces.pvd", "ParaView: open, Apply: what fibers touch"},
  }};
  const auto is_there = [&](const auto& file) { return std::filesystem::exists(out.root() / file.first); };
  if (std::ranges::none_of(files, is_there)) return;
  terminal.line(fmt::format("\nResults in {} after {}:", out.root().string(), duration_text(seconds)));
  for (const auto& [file, meaning] : files | std::views::filter(is_there))
    terminal.line(fmt::format("  {:<18}{}", file, meaning));
}

void write_curves(const OutputDirectory& out, const micro::Scene& scene, const micro::SimulationSummary& summary,
                  Terminal& terminal) {
  const CurvesTable table = curves_table(scene, summary);
  if (table.columns.empty()) return;
  write_curves_csv(out.curves(), table);
  const std::vector<Curve> curves = curves_of(table, scene);
  write_branches_csv(out.branches(), curves);
  if (!plot_curves(out.root(), curves, scene.title))
    terminal.line("No picture of the curves: gnuplot is not installed, or failed on curves.gp.");
}

/// Where a run begins, and what it writes to.
struct Beginning {
  std::filesystem::path folder;
  micro::SimulateOptions run;
  micro::StartPoint at;
};

/// The changes of a scene that a command line asks for.
std::string changes_text(const Task& task, const Options& options) {
  std::string text;
  for (const Setting& setting : task.settings) text += fmt::format("--set {}={} ", setting.knob, setting.value);
  if (options.alpha) text += fmt::format("--alpha {} ", *options.alpha);
  return text.substr(0, text.size() - (text.empty() ? 0 : 1));
}

/// Checked before an earlier run is overwritten, and while the process has one thread.
Beginning beginning_of(const Task& task, const Options& options) {
  Beginning beginning{options.out.value_or(default_output(task.scene.name, options.alpha)), {}, {}};
  micro::SimulateOptions& run = beginning.run;
  run.states = states_in(beginning.folder);
  run.start_from = options.start_from;
  run.after = options.after;
  run.resume = options.resume;
  run.changes = changes_text(task, options);
  run.n_threads = options.n_threads;
  std::error_code none;
  if (std::filesystem::equivalent(run.start_from, run.states, none))
    throw InputError(
        fmt::format("--start-from {}: the results would be written over it; choose another --out", options.start_from));
  const std::filesystem::path read = run.resume ? run.states : run.start_from;
  if (read.empty() || !std::filesystem::exists(read)) return beginning;
  probe(read, [&] { (void)micro::check_start(task.scene, run); });
  beginning.at = micro::check_start(task.scene, run);
  return beginning;
}

/// Whether warp and weft come back to where they start.
std::array<bool, 2> periodic_systems(const micro::Scene& scene) {
  if (!scene.weave) return {false, false};
  return {scene.weave->warp.periodic, scene.weave->weft.periodic};
}

/// What is left to do of a scene, for an estimate of that.
micro::Scene what_is_left(micro::Scene scene, const micro::StartPoint& from) {
  scene.stages.erase(scene.stages.begin(), scene.stages.begin() + static_cast<std::ptrdiff_t>(from.stage));
  if (!scene.stages.empty()) {
    Index& n = scene.stages.front().n_increments;
    n = static_cast<Index>(std::ceil((1 - from.stage_time) * n - 1e-6));
  }
  return scene;
}

void tell_beginning(Terminal& terminal, const micro::Scene& scene, const Beginning& beginning) {
  if (!beginning.run.resume) return;
  const micro::StartPoint& at = beginning.at;
  if (at.n_increments == 0)
    terminal.line(fmt::format("Nothing to resume in {}: begins at the start.", beginning.folder.string()));
  else if (at.stage == scene.stages.size())
    terminal.line(fmt::format("All stages are done, in {} increments.", at.n_increments));
  else
    terminal.line(fmt::format("Goes on in stage {} at stage time {:.4f}, after {} increments.",
                              scene.stages[at.stage].name, at.stage_time, at.n_increments));
}

/// For summary.json; what it calls for is added to the warnings of `summary`.
nlohmann::json error_estimate(const OutputDirectory& out, const Task& task, micro::SimulationSummary& summary) {
  const auto io = summary.timers.measure(Phase::io);
  std::vector<EnergyPoint> energies;
  for (const micro::CurvePoint& point : summary.curve) energies.push_back({point.stage, point.energy});
  const PosterioriEstimate estimate = estimate_errors(micro::SnapshotReader(out.states()), energies, summary.curve);
  // What the profile says holds for a run that reached its end.
  const bool done = summary.status == micro::SimulationSummary::Status::done;
  const bool is_known = done && task.known_run;
  nlohmann::json json =
      error_estimate_json(estimate, is_known ? &*task.profile : nullptr, is_known ? &*task.known_run : nullptr);
  const nlohmann::json& error = json.at("relative_error");
  summary.warnings =
      all_warnings(summary, estimate, error.is_number() ? std::optional(error.get<double>()) : std::nullopt);
  return json;
}

/// The results that follow from the states. One that fails, for want of room or of a program, does not take the others
/// along: it is told in summary.json, and at the end.
class Outputs {
 public:
  explicit Outputs(Terminal& terminal) : terminal_(terminal) {}

  void make(const std::string& what, const std::function<void()>& make_it) {
    try {
      make_it();
    } catch (const std::exception& error) {
      const std::string failure = fmt::format("{}: {}", what, error.what());
      if (std::ranges::find(failures_, failure) != failures_.end()) return;  // of an output that is made again
      failures_.push_back(failure);
      terminal_.line("Not written: " + printable(failure));
    }
  }
  [[nodiscard]] const std::vector<std::string>& failures() const { return failures_; }

 private:
  Terminal& terminal_;
  std::vector<std::string> failures_;
};

void write_results(const Task& task, const Options& options, const Program& program, const OutputDirectory& out,
                   micro::SimulationSummary& summary, Outputs& outputs, Terminal& terminal) {
  nlohmann::json derived = nlohmann::json::object();
  const auto make_summary = [&] {
    derived["failed_outputs"] = outputs.failures();
    outputs.make("summary.json", [&] { write_summary(out, task, options, summary, derived); });
  };
  outputs.make("error estimate", [&] { derived["error_estimate"] = error_estimate(out, task, summary); });
  tell_outcome(terminal, summary);
  make_summary();  // what comes now may take long
  outputs.make("curves", [&] { write_curves(out, task.scene, summary, terminal); });
  outputs.make("vtk/fibers.pvd", [&] { write_fibers(out, options.copies, summary.timers); });
  const bool is_wanted_now = summary.status == micro::SimulationSummary::Status::interrupted;
  if (program.from_states && is_wanted_now)
    terminal.line(
        fmt::format("Without strains of yarns and report: strain_post {} makes them.", out.states().string()));
  if (program.from_states && !is_wanted_now)
    outputs.make("strains of yarns", [&] {
      derived.update(program.from_states(out, options.copies, summary.n_threads, summary.timers, terminal));
    });
  make_summary();
  if (program.from_results && !is_wanted_now) {
    const std::size_t n_failures = outputs.failures().size();
    outputs.make("report.html", [&] { program.from_results(out, terminal); });
    if (outputs.failures().size() > n_failures) make_summary();
  }
}

int run_scene(const Task& task, const Options& options, const Beginning& beginning, const Program& program,
              Terminal& terminal) {
  using Status = micro::SimulationSummary::Status;
  using Earlier = OutputDirectory::Earlier;
  const OutputDirectory out(beginning.folder, options.resume      ? Earlier::kept
                                              : options.overwrite ? Earlier::removed
                                                                  : Earlier::refused);
  micro::SimulationSummary summary = simulate(task.scene, options, beginning.run, terminal);
  Outputs outputs(terminal);
  write_results(task, options, program, out, summary, outputs, terminal);
  tell_results(terminal, out, summary.timers.total());
  const bool reached_its_end = summary.status == Status::done || summary.status == Status::interrupted;
  return reached_its_end && outputs.failures().empty() ? exit_done : exit_ended_early;
}

int run_command_line(const Program& program, int argc, char** argv) {
  const std::optional<Options> options = parse_command_line(argc, argv, program.description);
  Terminal terminal(stdout);
  if (!options) return exit_done;
  if (options->print_schema) {
    fmt::print("{}\n", micro::scene_schema());
    return exit_done;
  }
  const Task task = load_task(*options);
  const micro::Scene& scene = task.scene;
  micro::check_copies(options->copies, periodic_systems(scene));
  check_memory(scene, available_memory());
  const Beginning beginning = beginning_of(task, *options);
  take_blas_buffers(options->n_threads);
  const micro::Threads threads(options->n_threads);
  const micro::ModelSize size = micro::model_size(scene);
  terminal.line(fmt::format("{}: {}", scene.name, scene.title));
  const micro::CostEstimate cost = micro::estimate_cost(what_is_left(scene, beginning.at));
  terminal.line(options->check ? scene_overview(scene, size, cost) : size_text(size, cost));
  if (const std::string warning = start_warning(scene); !warning.empty() && beginning.run.start_from.empty())
    terminal.line(fmt::format("Warning: {}.", printable(warning)));
  tell_beginning(terminal, scene, beginning);
  if (!options->accuracy.empty()) terminal.line(accuracy_text(*task.profile, *task.known_run));
  if (options->check) return exit_done;
  if (options->verbose) terminal.line(fmt::format("OpenBLAS kernel {}", micro::blas_kernel()));
  return run_scene(task, *options, beginning, program, terminal);
}

}  // namespace

int run_program(const Program& program, int argc, char** argv) {
  return run_main(program.name, argv, [&] {
    prepare_blas(argv);
    watch_signals();
    return run_command_line(program, argc, argv);
  });
}

}  // namespace trame::workflows
