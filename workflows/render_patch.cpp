/// \file
/// render_patch: a picture of the fibers of a saved state.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "micro/core/error.h"
#include "micro/core/quantity.h"
#include "micro/states/snapshot.h"
#include "workflows/picture/display.h"
#include "workflows/picture/patch_picture.h"
#include "workflows/program/file_probe.h"
#include "workflows/program/run_main.h"
#include "workflows/program/saved_state.h"

namespace {

namespace fs = std::filesystem;
using namespace trame::workflows;
using trame::InputError;
using trame::micro::Copies;
using trame::micro::SnapshotReader;

struct Arguments {
  fs::path states, out;
  std::string increment = "last", view = "perspective", at = "x=0um", copies;
  int width = PictureOptions{}.width;
  /// View, increment, width and file of each.
  std::vector<std::tuple<std::string, std::string, int, fs::path>> pictures;
};

const std::map<std::string, View> views = {{"perspective", View::perspective}, {"top", View::top}, {"cut", View::cut}};

void define(CLI::App& app, Arguments& arguments) {
  app.set_version_flag("--version", TRAME_VERSION);
  app.footer(
      "Warp yarns are blue, weft yarns orange. A cut at x = const is seen along -x with y to the right, one at\n"
      "y = const along +y with x to the right; z is up, and what lies behind the cut is paler.\n"
      "Needs an X server; without a screen: xvfb-run -a render_patch ...\n"
      "Without an X server the exit code is 2. " +
      std::string(exit_codes_text));
  app.add_option("states", arguments.states, "State file of a run (HDF5)")->required();
  auto* out = app.add_option("--out", arguments.out, "Picture to write, .png");
  app.add_option("--increment", arguments.increment, "Number of an increment, name of a stage (its end), or \"last\"")
      ->capture_default_str();
  app.add_option("--view", arguments.view, "From where the patch is seen")
      ->check(CLI::IsMember({"perspective", "top", "cut"}))
      ->type_name("perspective|top|cut")
      ->capture_default_str();
  app.add_option("--at", arguments.at, "Plane of the cut, such as x=0um or y=-65um")->capture_default_str();
  app.add_option(
      "--copies", arguments.copies,
      "Copies of a periodic cell, along warp and weft [2x2; where yarns have ends one way, 3 along the other];\n"
      "a thin line goes around the cell itself");
  app.add_option("--width", arguments.width, "Width of the picture, pixels; the height follows")
      ->check(CLI::Range(200, 6000))
      ->capture_default_str();
  app.add_option("--picture", arguments.pictures,
                 "Instead of --out: view, increment, width and file of a picture; as often as there are pictures,\n"
                 "which takes less time than as many runs")
      ->type_name("VIEW INCREMENT WIDTH FILE")
      ->excludes(out);
}

/// "x=0um" or "y=-65 um".
CutPlane parse_cut(const std::string& text) {
  const std::string what = fmt::format("--at {}: ", text);
  if (text.size() < 3 || (text[0] != 'x' && text[0] != 'y') || text[1] != '=')
    throw InputError(what + "must be x or y, =, and a length with its unit, such as x=0um");
  try {
    return {text[0] == 'x' ? 0 : 1, trame::parse_quantity(text.substr(2), "m")};
  } catch (const InputError& error) {
    throw InputError(what + error.what());
  }
}

void check_out(const char* option, const fs::path& out) {
  if (out.extension() != ".png") throw InputError(fmt::format("{} {}: must end in .png", option, out.string()));
  if (out.has_parent_path() && !fs::is_directory(out.parent_path()))
    throw InputError(fmt::format("{} {}: there is no folder {}", option, out.string(), out.parent_path().string()));
}

/// What is asked for, in one form.
struct Task {
  PictureOptions options;
  trame::Index increment = 0;
  fs::path file;
};

std::vector<Task> tasks_of(const Arguments& arguments, const SnapshotReader& reader) {
  const trame::meso::RunStates states(reader);
  const CutPlane cut = parse_cut(arguments.at);
  if (arguments.pictures.empty())
    return {{{views.at(arguments.view), cut, arguments.width},
             find_state(states, "--increment", arguments.increment),
             arguments.out}};
  std::vector<Task> tasks;
  for (const auto& [view, increment, width, file] : arguments.pictures) {
    if (!views.contains(view))
      throw InputError(fmt::format("--picture {}: the view must be perspective, top or cut", view));
    if (width < 200 || width > 6000)
      throw InputError(fmt::format("--picture: width {}: allowed are 200 … 6000 pixels", width));
    tasks.push_back({{views.at(view), cut, width}, find_state(states, "--picture", increment), file});
  }
  return tasks;
}

void run(const Arguments& arguments) {
  if (arguments.pictures.empty() && arguments.out.empty()) throw InputError("--out: a picture to write is required");
  if (arguments.pictures.empty()) check_out("--out", arguments.out);
  for (const auto& picture : arguments.pictures) check_out("--picture", std::get<3>(picture));
  std::optional<Copies> copies;
  if (!arguments.copies.empty()) copies = trame::micro::parse_copies(arguments.copies);
  probe(arguments.states, [&] {
    const SnapshotReader states(arguments.states);
    for (const Task& task : tasks_of(arguments, states))
      (void)patch_of(states.header(), states.read(task.increment), copies);
  });
  const SnapshotReader states(arguments.states);
  const std::vector<Task> tasks = tasks_of(arguments, states);
  if (copies)
    trame::micro::check_copies(*copies, trame::micro::is_periodic(periods_of(states.header(), states.read(0))));
  // VTK would end the process.
  if (!display_answers())
    throw InputError(
        "no X server answers at DISPLAY, and VTK draws through X11 only; run: xvfb-run -a render_patch ...");
  for (const Task& task : tasks) {
    write_picture(patch_of(states.header(), states.read(task.increment), copies), task.options, task.file);
    fmt::print("Increment {}: {}\n", task.increment, task.file.string());
  }
}

}  // namespace

int main(int argc, char** argv) {
  return run_main("render_patch", argv, [&]() -> int {
    CLI::App app("A picture of the fibers of a saved state.");
    Arguments arguments;
    define(app, arguments);
    if (parse_arguments(app, argc, argv)) run(arguments);
    return exit_done;
  });
}
