#pragma once
/// \file
/// Programs that others start: gnuplot, render_patch.

#include <spawn.h>
#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace trame::workflows {

/// Starts a program, found along PATH where its name has no slash, with no signal blocked. Nothing where that failed.
[[nodiscard]] std::optional<pid_t> spawn(std::vector<std::string> command, const posix_spawn_file_actions_t& actions);

/// Runs a program, found along PATH where its name has no slash, in `folder` to its end, without what it prints.
/// Whether it was found and succeeded.
[[nodiscard]] bool run_quietly(const std::filesystem::path& folder, std::vector<std::string> command);

/// The folder of the running program, where the others of the build are too.
[[nodiscard]] std::filesystem::path program_folder();

}  // namespace trame::workflows
