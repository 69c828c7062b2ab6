#pragma once
/// \file
/// Wall-clock time by phase of the computation.

#include <array>
#include <chrono>
#include <cstddef>
#include <string_view>

namespace trame {

enum class Phase { detection, assembly, symbolic, factorization, solve, io, meso, other };
inline constexpr std::size_t n_phases = 8;
inline constexpr std::array<std::string_view, n_phases> phase_names = {
    "detection", "assembly", "symbolic", "factorization", "solve", "io", "meso", "other"};

/// Seconds spent in each phase since the start of the run.
class Timers {
 public:
  using Clock = std::chrono::steady_clock;

  /// Adds the lifetime of the returned guard to `phase`.
  class Guard {
   public:
    Guard(Timers& timers, Phase phase) : timers_(timers), phase_(phase), start_(Clock::now()) {}
    ~Guard() { timers_.add(phase_, std::chrono::duration<double>(Clock::now() - start_).count()); }
    Guard(const Guard&) = delete;
    Guard& operator=(const Guard&) = delete;

   private:
    Timers& timers_;
    Phase phase_;
    Clock::time_point start_;
  };

  [[nodiscard]] Guard measure(Phase phase) { return {*this, phase}; }
  void add(Phase phase, double seconds) { seconds_[static_cast<std::size_t>(phase)] += seconds; }
  [[nodiscard]] double seconds(Phase phase) const { return seconds_[static_cast<std::size_t>(phase)]; }
  [[nodiscard]] double total() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  std::array<double, n_phases> seconds_{};
  Clock::time_point start_ = Clock::now();
};

}  // namespace trame
