#pragma once
/// \file
/// What a run leaves beside its states: sizes, sums over its increments, the curve, warnings.

#include <array>
#include <string>
#include <vector>

#include "micro/core/timers.h"
#include "micro/model/model_size.h"
#include "micro/states/snapshot.h"

namespace trame::micro {

/// A point of the curves: of an increment, or of the start of a stage.
struct CurvePoint {
  std::string stage;
  double stage_time = 0;
  std::array<double, 2> side_strain{}, side_force{};  ///< as in SideRecord
  EnergyRecord energy;                                ///< of the increment
  /// Six numbers for each body: motion (m) and turn (rad), as in BodyRecord; force (N) and moment (N m) on it.
  std::vector<double> motion, reaction;

  void keep(Archive& archive) {
    archive(stage, stage_time, side_strain[0], side_strain[1], side_force[0], side_force[1], energy, motion, reaction);
  }
};

struct SimulationSummary {
  enum class Status { done, interrupted, gave_up, cannot_write } status = Status::done;
  std::string message;  ///< why it gave up or cannot write, where, what to try
  ModelSize size;
  Index n_contact_elements_max = 0;
  Index n_increments = 0, n_cut_increments = 0, n_newton_iterations = 0, n_factorizations = 0;
  double max_penetration_over_radius = 0;            ///< at the end of the last stage
  double deepest_penetration_over_radius = 0;        ///< of all increments that nothing damps
  double force_imbalance = 0, moment_imbalance = 0;  ///< at the end
  EnergyRecord energy;
  Index n_unstable_increments = 0;    ///< known to be: `SolverRecord::unstable`
  Index n_buried_ends = 0;            ///< fiber ends inside other fibers, at the end of the last stage
  std::vector<std::string> warnings;  ///< what is solved, but may not be what was meant
  bool crossing_order_ok = true;      ///< true without a weave
  Index n_crossings = 0, n_crossings_ok = 0;
  int n_threads = 0;
  std::vector<std::string> body_names;
  std::vector<CurvePoint> curve;         ///< a point for each increment
  std::vector<CurvePoint> stage_starts;  ///< where the stages of the curve begin, before anything moves
  Timers timers;                         ///< of this process

  /// Adds an accepted increment with so many contact elements.
  void count(const SolverRecord& increment, Index n_contact_elements);

  /// Passes through what has added up over the increments.
  void keep(Archive& archive) {
    archive(n_contact_elements_max, n_increments, n_cut_increments, n_newton_iterations, n_factorizations,
            max_penetration_over_radius, deepest_penetration_over_radius, force_imbalance, moment_imbalance, energy,
            n_unstable_increments, n_buried_ends, warnings, crossing_order_ok, n_crossings, n_crossings_ok, curve,
            stage_starts);
  }
};

}  // namespace trame::micro
