#pragma once
/// \file
/// One stage of a run: its increments are booked, recorded, saved.

#include <memory>
#include <optional>

#include "micro/run/continuation.h"
#include "micro/run/options.h"
#include "micro/run/state_file.h"

namespace trame::micro {

/// What the stages of a run share. Lengths, forces and energies are in natural units.
struct RunContext {
  RunContext(const Scene& dimensional_scene, const SimulateOptions& run_options)
      : options(run_options), scales(natural_scales(dimensional_scene)),
        scene(nondimensional(dimensional_scene, scales)), assembly(assemble_scene(scene)), state(assembly) {}

  const SimulateOptions& options;
  Scales scales;
  Scene scene;
  Assembly assembly;
  RunState state;
  std::unique_ptr<StateFile> states;
  std::string continuation;  ///< of the last accepted increment
  double begun_at = 0;       ///< fraction of the load path at which this run began or was gone on with

  /// Of the load path from the first stage on, in increments.
  [[nodiscard]] double fraction(std::size_t stage, double stage_time) const;
  [[nodiscard]] bool stop_requested() const { return options.stop && *options.stop; }
  void log(const std::string& text) const {
    if (options.log) options.log(text);
  }
  void warn(const std::string& text) {
    log("warning: " + text);
    state.summary.warnings.push_back(text);
  }
};

/// Follows stage number `index` of the scene, from its start or, where `resumption` is within it, from there on; it is
/// used up then. What came of it stands in the summary; the stage that follows can begin.
void run_stage(RunContext& run, std::size_t index, std::optional<Resumption>& resumption);

}  // namespace trame::micro
