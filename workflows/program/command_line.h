#pragma once
/// \file
/// Command line of the programs that run scenes.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "micro/states/cell_copies.h"

namespace trame::workflows {

struct Options {
  std::string scene;                         ///< path or name, as given
  std::optional<std::filesystem::path> out;  ///< default: results/<scene>
  bool overwrite = false, resume = false, check = false, print_schema = false, verbose = false;
  int n_threads = 0;            ///< 0: all cores
  std::optional<double> alpha;  ///< weft strain over warp strain
  std::string accuracy;         ///< "1%": take the cheapest settings that held it in the scene's study; empty: none
  std::vector<std::string> settings;       ///< knob=value, changes of the scene
  std::string start_from;                  ///< state file of another run; empty: the scene's own start
  std::string after;                       ///< stage at whose end to start
  micro::Copies copies = micro::one_cell;  ///< of a periodic cell, in VTK files
};

/// Reads the command line; nothing where it asked for help or the version, which are then printed. Throws InputError.
[[nodiscard]] std::optional<Options> parse_command_line(int argc, const char* const* argv,
                                                        const std::string& description);

/// Data folder: TRAME_DATA from the environment, or that of the source tree.
[[nodiscard]] std::filesystem::path data_directory();

/// The file of a scene. What ends in .toml or holds a slash is a path; anything else names a file of `data`/scenes.
/// Throws InputError, with the names there are.
[[nodiscard]] std::filesystem::path find_scene(const std::string& scene, const std::filesystem::path& data);

/// results/<scene name>, with the ratio where one is given, so that two ratios do not meet in one folder.
[[nodiscard]] std::filesystem::path default_output(const std::string& scene_name, std::optional<double> alpha);

}  // namespace trame::workflows
