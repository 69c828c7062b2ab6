#pragma once
/// \file
/// A program run as a child, and what it took.

#include <filesystem>
#include <string>
#include <vector>

namespace trame::workflows {

struct MeasuredRun {
  int exit_code = 0;                         ///< -1 where a signal ended it, or it could not be started
  int signal = 0;                            ///< that ended it
  double wall_seconds = 0, cpu_seconds = 0;  ///< user and system
};

/// Runs `command` to its end; what it prints goes to `log`.
[[nodiscard]] MeasuredRun run_measured(std::vector<std::string> command, const std::filesystem::path& log);

}  // namespace trame::workflows
