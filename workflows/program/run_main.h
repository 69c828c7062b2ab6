#pragma once
/// \file
/// What every program of ours does the same way: standard streams, its command line, and how it ends.

#include <functional>
#include <string>

namespace CLI {
class App;
}

namespace trame::workflows {

/// The same fault has the same code in all programs.
enum ExitCode {
  exit_done = 0,         ///< or ended by the user
  exit_unexpected = 1,   ///< a fault of the program
  exit_bad_input = 2,    ///< the message says what is allowed
  exit_ended_early = 3,  ///< the solver gave up, or what was computed could not be written; what is saved is whole
};

/// What --help says of them.
inline constexpr const char* exit_codes_text =
    "Exit codes: 0 done, or ended by Ctrl-C with everything saved; 1 unexpected failure; 2 bad input; 3 ended early, "
    "because the solver gave up or the disk is full, with everything up to there saved.";

/// The body of `main`: opens standard streams that are closed on /dev/null, runs `body`, and turns every exception into
/// one sentence on standard error and an exit code. A file that grows beyond a limit (ulimit -f) is an error of
/// writing, not the end of the process. Under a limit of address space (ulimit -v) OpenBLAS is prepared for it
/// (environment.h).
[[nodiscard]] int run_main(const std::string& program, char** argv, const std::function<int()>& body);

/// Reads a command line into what `app` has. False where it asked for help or the version, which are then printed.
/// Throws InputError.
[[nodiscard]] bool parse_arguments(CLI::App& app, int argc, const char* const* argv);

}  // namespace trame::workflows
