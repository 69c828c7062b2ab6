#pragma once
/// \file
/// What a person at a terminal sees of a run, and the Ctrl-C that ends it.

#include <atomic>
#include <chrono>
#include <cstdio>
#include <string>
#include <string_view>

#include "micro/simulate.h"

namespace trame::workflows {

/// "850 ms", "12.3 s", "4 min 05 s", "2 h 10 min".
[[nodiscard]] std::string duration_text(double seconds);
/// "512 kB", "1.3 GB": powers of 1000.
[[nodiscard]] std::string bytes_text(double bytes);

/// One line about an accepted increment; the time that is left is extrapolated from the share of the load path behind.
[[nodiscard]] std::string progress_text(const micro::Progress& progress, double elapsed_seconds);

/// Lines, and a progress line that is rewritten in place on a terminal and a line for each increment anywhere else.
/// What cannot be printed, because the log's disk is full or its reader gone, is no reason to end a run.
class Terminal {
 public:
  explicit Terminal(std::FILE* stream);

  void line(std::string_view text);
  void progress(const micro::Progress& progress);
  /// Keeps the last progress line on the screen.
  void end_progress();

 private:
  void print(const std::string& text);

  std::FILE* stream_;
  bool is_screen_;
  bool progress_open_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Ctrl-C (or SIGTERM, or SIGXCPU, or SIGHUP where it was not ignored) ends the process from here on whatever libraries
/// do with these signals. To be called once, before there are other threads. Children block them unless they are given
/// a mask of their own.
void watch_signals();
/// From here on the first of these signals sets the returned flag and says so; a second one ends the process at once.
[[nodiscard]] const std::atomic<bool>& stop_on_signals();

}  // namespace trame::workflows
