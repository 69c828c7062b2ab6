#pragma once
/// \file
/// Runs a scene: builds the model, follows its load path, saves states.

#include <array>
#include <atomic>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "micro/core/timers.h"
#include "micro/scene/scene.h"
#include "micro/states/snapshot.h"

namespace trame::micro {

/// How large a scene is, before it runs.
struct ModelSize {
  Index n_fibers = 0, n_nodes = 0, n_bodies = 0;
  std::int64_t n_dofs = 0;  ///< of the stage with most of them
  std::vector<std::int64_t> n_dofs_per_stage;
};
[[nodiscard]] ModelSize model_size(const Scene& scene);

/// One accepted increment, as told to whoever watches the run.
struct Progress {
  std::string stage;
  Index stage_index = 0, n_stages = 0;
  double stage_time = 0;  ///< 0…1
  double fraction = 0;    ///< of the whole load path, 0…1
  Index increment = 0;    ///< accepted so far
  const SolverRecord* solver = nullptr;
  Index n_contact_elements = 0;
};

struct SimulateOptions {
  std::filesystem::path states;                       ///< state file to write
  std::filesystem::path start_from;                   ///< states of another run to start from; empty: the scene's start
  std::string after;                                  ///< stage of that run at whose end to start
  bool resume = false;  ///< go on with the run that `states` holds, from its last increment; at the start where there is none
  /// What was changed in the scene since its text was read, in words. A run that is gone on with has had the same.
  std::string changes;
  int n_threads = 0;                                  ///< 0: all cores
  std::function<void(const Progress&)> on_increment;  ///< may be empty
  std::function<void(const std::string&)> log;        ///< Newton residuals line by line (-v); may be empty
  const std::atomic<bool>* stop = nullptr;            ///< end when true, without the increment under way
};

/// A point of the curves: strain and force of the patch's sides, per increment.
struct CurvePoint {
  std::string stage;
  double stage_time = 0;
  /// Warp, weft: relative change of the distance of the side bodies since the stages that drive them began; 0 without a
  /// weave.
  std::array<double, 2> side_strain{};
  std::array<double, 2> side_force{};  ///< warp, weft: mean of the pulling forces on both sides, N
  EnergyRecord energy;                 ///< of the increment

  void keep(Archive& archive) {
    archive(stage, stage_time, side_strain[0], side_strain[1], side_force[0], side_force[1], energy);
  }
};

struct SimulationSummary {
  enum class Status { done, interrupted, gave_up, cannot_write } status = Status::done;
  std::string message;  ///< why it gave up or cannot write, where, what to try
  ModelSize size;
  Index n_contact_elements_max = 0;
  Index n_increments = 0, n_cut_increments = 0, n_newton_iterations = 0, n_factorizations = 0;
  double max_penetration_over_radius = 0;            ///< at the end of the last stage
  double force_imbalance = 0, moment_imbalance = 0;  ///< at the end
  EnergyRecord energy;
  Index n_unstable_increments = 0;    ///< known to be: `SolverRecord::unstable`
  Index n_buried_ends = 0;            ///< fiber ends inside other fibers, at the end of the last stage
  std::vector<std::string> warnings;  ///< what is solved, but may not be what was meant
  bool crossing_order_ok = true;      ///< true without a weave
  Index n_crossings = 0, n_crossings_ok = 0;
  int n_threads = 0;
  std::vector<CurvePoint> curve;
  Timers timers;  ///< of this process

  /// Passes through what has added up over the increments.
  void keep(Archive& archive) {
    archive(n_contact_elements_max, n_increments, n_cut_increments, n_newton_iterations, n_factorizations,
            max_penetration_over_radius, force_imbalance, moment_imbalance, energy, n_unstable_increments, n_buried_ends,
            warnings, crossing_order_ok, n_crossings, n_crossings_ok, curve);
  }
};

/// Where a run begins.
struct StartPoint {
  std::size_t stage = 0;   ///< of the scene; the number of stages where nothing is left to do
  double stage_time = 0;   ///< done of that stage
  Index n_increments = 0;  ///< accepted before, by the run that is gone on with
};

/// Where the run would begin. Throws InputError where it cannot start from what the options name; touches nothing.
[[nodiscard]] StartPoint check_start(const Scene& scene, const SimulateOptions& options);

/// Runs `scene` and writes its states. A run that goes on (`resume`) leaves what it would have left without the
/// interruption, to the bit, but for times; the states it finds stay as they are until the next one is saved. A solver that gives up is reported in `status`, with the last good state saved;
/// so is a disk that is full after the first state. Throws InputError where the scene and the options cannot be run,
/// WriteError where not even the first state can be written.
[[nodiscard]] SimulationSummary simulate(const Scene& scene, const SimulateOptions& options);

}  // namespace trame::micro
