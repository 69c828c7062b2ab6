#include "workflows/program/command_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <vector>

#include "micro/core/error.h"
#include "workflows/program/run_main.h"

namespace trame::workflows {

namespace fs = std::filesystem;

namespace {

std::vector<std::string> scene_names(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

std::optional<Options> parse_command_line(int argc, const char* const* argv, const std::string& description) {
  Options options;
  CLI::App app(description);
  app.footer(exit_codes_text);
  app.set_version_flag("--version", std::string("Trame ") + TRAME_VERSION);
  auto* scene = app.add_option("SCENE", options.scene, "Scene file, or the name of one in data/scenes");
  app.add_option("--out", options.out, "Folder for the results [results/<scene>]");
  auto* overwrite =
      app.add_flag("--overwrite", options.overwrite, "Replace the files of an earlier run in that folder");
  auto* resume = app.add_flag("--resume", options.resume,
                              "Go on with the run in that folder, from the last state it has saved; at the start where "
                              "there is none. The scene may have more stages at its end");
  app.add_option("--threads", options.n_threads, "Threads [all cores]")->check(CLI::Range(1, 1024));
  auto* alpha = app.add_option("--alpha", options.alpha,
                               "Weft strain over warp strain in the last stage, instead of the scene's");
  auto* accuracy = app.add_option(
      "--accuracy", options.accuracy,
      "Such as 1%: the cheapest settings whose error stayed below it in the scene's study by accuracy_cost");
  auto* settings =
      app.add_option("--set", options.settings, "knob=value: a change of the scene, as accuracy_cost makes them")
          ->allow_extra_args(false);
  auto* start_from = app.add_option("--start-from", options.start_from,
                                    "State file of another run of these fibers: begin where its stage --after ended");
  auto* after =
      app.add_option("--after", options.after, "Stage of that run; the scene's stages after it are simulated");
  start_from->needs(after)->check(CLI::ExistingFile);
  after->needs(start_from);
  // The study knows the scene as it is, from its start.
  resume->excludes(overwrite)->excludes(start_from);
  accuracy->excludes(settings)->excludes(alpha)->excludes(start_from);
  std::string copies;
  app.add_option("--copies", copies,
                 "Copies of a periodic cell in the VTK files, along warp and weft, such as 2x2 [1x1]");
  app.add_flag("--check", options.check, "Check the scene, say what would be simulated, and stop");
  auto* print_schema = app.add_flag("--print-schema", options.print_schema, "Print every key of a scene, and stop");
  app.add_flag("-v,--verbose", options.verbose, "Print the residual of every Newton iteration");
  if (!parse_arguments(app, argc, argv)) return std::nullopt;
  if (scene->empty() && print_schema->empty()) throw InputError("SCENE is required (--help explains the options)");
  if (!copies.empty()) options.copies = micro::parse_copies(copies);
  return options;
}

fs::path data_directory() {
  const char* from_environment = std::getenv("TRAME_DATA");
  return from_environment != nullptr ? from_environment : TRAME_DATA_DIR;
}

fs::path find_scene(const std::string& scene, const fs::path& data) {
  const fs::path folder = data / "scenes";
  const bool is_path = scene.find('/') != std::string::npos || scene.ends_with(".toml");
  const fs::path file = is_path ? fs::path(scene) : folder / (scene + ".toml");
  std::error_code unreadable;  // names without bound, links in circles: there is no such file
  if (fs::is_regular_file(file, unreadable)) return file;
  if (fs::is_directory(file, unreadable) || (!is_path && fs::is_directory(scene, unreadable)))
    throw InputError(fmt::format("scene {}: is a folder; must be a file, such as {}, or a scene of {}: {}", scene,
                                 (fs::path(scene) / "scene.toml").string(), folder.string(),
                                 fmt::join(scene_names(folder), ", ")));
  throw InputError(fmt::format("scene {}: there is no file {}; must be a file, or a scene of {}: {}", scene,
                               file.string(), folder.string(), fmt::join(scene_names(folder), ", ")));
}

fs::path default_output(const std::string& scene_name, std::optional<double> alpha) {
  return fs::path("results") / (alpha ? fmt::format("{}_alpha_{}", scene_name, *alpha) : scene_name);
}

}  // namespace trame::workflows
