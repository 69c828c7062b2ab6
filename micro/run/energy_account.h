#pragma once
/// \file
/// The energy of a run since its start, over all stages, in natural units.

#include "micro/model/model.h"

namespace trame::micro {

class EnergyAccount {
 public:
  EnergyAccount() = default;
  /// Goes on from another run's.
  explicit EnergyAccount(const Ledger& so_far) : total_(so_far) {}

  /// Books the stored energy that comes and goes with the effects and fiber models of a stage, before anything moves.
  void begin_stage(StageModel& model);
  void add(Source from, double energy) { beside_effects_[from] += energy; }
  void add(Sink to, double energy) { beside_effects_[to] += energy; }
  /// Closes the books of an accepted increment: what was added, and what the stage's effects know.
  void close(const StageModel& model, const State& accepted);

  [[nodiscard]] const Ledger& total() const { return total_; }
  void keep(Archive& archive) { archive(total_, beside_effects_); }

 private:
  Ledger total_;           // at the last accepted increment
  Ledger beside_effects_;  // without what the effects of the current stage know
};

/// How far bodies go and turn between two states, 6 numbers each.
[[nodiscard]] std::vector<double> body_motion(const StageModel& model, const State& from, const State& to);

/// Work of the external forces on the bodies along a motion, by the trapezoidal rule. Forces: 6 per body.
[[nodiscard]] double external_work(const StageModel& model, const std::vector<double>& motion,
                                   const std::vector<double>& forces_from, const std::vector<double>& forces_to);

/// Energy that fibers lose on the way to `first`, the first increment of a stage, which finds them out of balance: the
/// work of what nothing holds on the way, by Simpson's rule, on `at_start`, a model of the stage as it begins. (What
/// that lacks at the end, preloads that were raised on the way, has risen linearly.) Forces on bodies are part of what
/// the bodies' work is counted with, but for followers.
[[nodiscard]] double released_energy(StageModel& at_start, const State& first, double stage_time);

}  // namespace trame::micro
