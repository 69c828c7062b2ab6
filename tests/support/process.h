#pragma once
/// \file
/// Programs as a user starts them: arguments, exit code, what they print, signals.

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace trame::test {

struct Outcome {
  int exit_code = 0;  ///< 128 + signal where a signal ended it
  std::string out, err;
};

/// A running program. What it prints goes to files in `folder`, which is also its working directory.
class Process {
 public:
  /// `command`: program and arguments. `environment`: NAME=VALUE, on top of this process's.
  Process(const std::filesystem::path& folder, std::vector<std::string> command,
          const std::vector<std::string>& environment = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// Waits until the program has printed `text`; false if it ends or `seconds` pass before.
  [[nodiscard]] bool wait_for_output(const std::string& text, double seconds);
  void send(int signal) const;
  [[nodiscard]] Outcome wait();

 private:
  [[nodiscard]] bool has_ended();

  std::filesystem::path out_, err_;
  pid_t id_ = 0;
  int status_ = 0;
  bool ended_ = false;
};

/// Runs a program to its end. Where the environment has TRAME_JUDGE, the command of tests/judge/judge.py, a program
/// that ends well and was told to write a run to `--out` must have left states that this calls right.
[[nodiscard]] Outcome run(const std::filesystem::path& folder, const std::vector<std::string>& command,
                          const std::vector<std::string>& environment = {});

}  // namespace trame::test
