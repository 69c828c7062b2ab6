/// Measures what accuracy costs: runs a scene with many settings, compares, and writes the scene's accuracy profile.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <array>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "micro/core/error.h"
#include "workflows/accuracy/study.h"
#include "workflows/accuracy/study_tables.h"
#include "workflows/accuracy/work_precision.h"
#include "workflows/program/child_process.h"
#include "workflows/program/command_line.h"
#include "workflows/program/environment.h"
#include "workflows/program/gnuplot.h"
#include "workflows/program/output_directory.h"
#include "workflows/program/run_main.h"
#include "workflows/program/terminal.h"

namespace trame::workflows {

namespace {

namespace fs = std::filesystem;

struct StudyCommand {
  std::string scene;
  fs::path out;
  bool overwrite = false;
  int n_threads = StudyOptions{}.n_threads, n_repeats = StudyOptions{}.n_repeats;
  std::vector<std::string> knobs, values, grid, reference;
};

std::string knob_list() {
  std::string list = "Knobs, and the values that a study tries:\n";
  for (const Knob& knob : knobs())
    list +=
        fmt::format("  {:<20} {:<32} {}\n", knob.name, fmt::format("{}", fmt::join(knob.values, ",")), knob.meaning);
  return list;
}

/// Nothing where the command line asked for help.
std::optional<StudyCommand> parse(int argc, char** argv) {
  StudyCommand command;
  CLI::App app("Runs a scene with many settings, each in a process of its own, and tells what accuracy costs in time.");
  app.footer(knob_list());
  app.set_version_flag("--version", std::string("Trame ") + TRAME_VERSION);
  app.add_option("SCENE", command.scene, "Scene file, or the name of one in data/scenes")->required();
  app.add_option("--knobs", command.knobs, "Knobs to vary one at a time [all that the scene has a use for]")
      ->delimiter(',');
  app.add_option("--values", command.values, "knob=a,b,c: values to try instead of the knob's own");
  app.add_option("--grid", command.grid, "knob=a,b,c: try all combinations of these, besides");
  app.add_option("--reference", command.reference,
                 "knob=value: what the reference has, instead of the knob's finest value");
  app.add_option("--repeat", command.n_repeats,
                 fmt::format("Runs of each case, for medians of times [{}]", command.n_repeats))
      ->check(CLI::Range(1, 100));
  app.add_option(
         "--threads", command.n_threads,
         fmt::format("Threads of each run [{}: threads that wait for each other count as CPU time]", command.n_threads))
      ->check(CLI::Range(1, 1024));
  app.add_option("--out", command.out, "Folder for the results [results/<scene>_accuracy]");
  app.add_flag("--overwrite", command.overwrite, "Replace the files of an earlier study in that folder");
  if (!parse_arguments(app, argc, argv)) return std::nullopt;
  return command;
}

CaseOptions case_options(const StudyCommand& command) {
  CaseOptions options;
  options.knobs = command.knobs;
  for (const std::string& text : command.values) options.values.push_back(parse_values(text));
  for (const std::string& text : command.grid) options.grid.push_back(parse_values(text));
  for (const std::string& text : command.reference) options.reference.push_back(parse_setting(text));
  return options;
}

/// The command as one would type it again.
std::string command_text(const StudyCommand& command) {
  std::string text = "accuracy_cost " + command.scene;
  const auto add = [&](const char* option, const std::vector<std::string>& values) {
    for (const std::string& value : values) text += fmt::format(" {} {}", option, value);
  };
  if (!command.knobs.empty()) text += fmt::format(" --knobs {}", fmt::join(command.knobs, ","));
  add("--values", command.values);
  add("--grid", command.grid);
  add("--reference", command.reference);
  return text + fmt::format(" --repeat {} --threads {}", command.n_repeats, command.n_threads);
}

/// <scene>.closed_form.json beside the profile, where there is one.
std::optional<ClosedForm> read_closed_form(const fs::path& profile, const std::string& scene) {
  const fs::path file = profile.parent_path() / (scene + ".closed_form.json");
  std::ifstream stream(file);
  if (!stream) return std::nullopt;
  try {
    const nlohmann::json object = nlohmann::json::parse(stream);
    return ClosedForm{object.at("values"), object.at("uncertainty"), object.at("source")};
  } catch (const nlohmann::json::exception& error) {
    throw InputError(fmt::format("{}: must hold values, uncertainty and source ({})", file.string(), error.what()));
  }
}

constexpr std::array outputs = {"runs.csv", "study.md", "work_precision.gp", "work_precision.svg"};

std::unique_ptr<FolderLock> prepare(const fs::path& folder, bool overwrite) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError(fmt::format("--out {}: cannot be created: {}", folder.string(), error.message()));
  auto lock = std::make_unique<FolderLock>("--out", folder);
  for (const char* name : outputs) {
    if (!fs::exists(folder / name)) continue;
    if (!overwrite)
      throw InputError(fmt::format("--out {}: holds {} of an earlier study; choose another folder, or --overwrite",
                                   folder.string(), name));
    fs::remove(folder / name);
  }
  return lock;
}

void write_results(const Study& study, const Profile& profile, const std::string& command, const fs::path& folder) {
  write_study_csv(folder / "runs.csv", study);
  write_whole_file(folder / "study.md", study_markdown(study, profile, command));
  const std::string script = work_precision_script(study);
  if (script.empty()) return;
  write_whole_file(folder / "work_precision.gp", script);
  if (const auto svg = gnuplot_svg(script, "1000,600")) write_whole_file(folder / "work_precision.svg", *svg);
}

int measure(const StudyCommand& command, Terminal& terminal) {
  const fs::path file = find_scene(command.scene, data_directory()),
                 profile_path = profile_file(file, data_directory());
  const micro::Scene scene = micro::read_scene(file);
  const std::vector<Case> cases = plan_cases(scene, case_options(command));
  const std::optional<ClosedForm> closed_form = read_closed_form(profile_path, scene.name);
  const fs::path folder = command.out.empty() ? fs::path("results") / (scene.name + "_accuracy") : command.out;
  const std::unique_ptr<FolderLock> lock = prepare(folder, command.overwrite);
  const std::atomic<bool>& stop = stop_on_signals();
  const StudyOptions options{.scene_file = fs::absolute(file),
                             .program = program_folder() / "simulate_fibers",
                             .folder = fs::absolute(folder),
                             .n_threads = command.n_threads,
                             .n_repeats = command.n_repeats,
                             .stop = [&] { return stop.load(); },
                             .tell = [&](const std::string& text) { terminal.line(text); },
                             .read = read_quantities};
  Study study = run_study(scene, cases, closed_form, options);
  compare(study);
  const Profile profile = profile_of(study, scene, command_text(command));
  write_results(study, profile, command_text(command), folder);
  terminal.line(fmt::format("Results in {}: runs.csv, study.md, work_precision.svg", folder.string()));
  if (stop.load() || !study.has_reference) {
    terminal.line(
        stop.load()
            ? "Interrupted: no profile is written."
            : "A reference run did not end well, see study.md: no profile is written. --reference chooses another.");
    return stop.load() ? exit_done : exit_ended_early;
  }
  fs::create_directories(profile_path.parent_path());
  write_whole_file(profile_path, profile_json(profile));
  terminal.line(fmt::format("Profile for --accuracy: {}", profile_path.string()));
  return exit_done;
}

int run(int argc, char** argv) {
  prepare_blas(argv);
  watch_signals();
  Terminal terminal(stdout);
  const std::optional<StudyCommand> command = parse(argc, argv);
  return command ? measure(*command, terminal) : exit_done;
}

}  // namespace

}  // namespace trame::workflows

int main(int argc, char** argv) {
  return trame::workflows::run_main("accuracy_cost", argv, [&] { return trame::workflows::run(argc, argv); });
}
