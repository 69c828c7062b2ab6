#pragma once
/// \file
/// What a caller may ask of a run beside its scene.

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>

#include "micro/states/snapshot.h"

namespace trame::micro {

/// One accepted increment, as told to whoever watches the run.
struct Progress {
  std::string stage;
  Index stage_index = 0, n_stages = 0;
  double stage_time = 0;  ///< 0…1
  double fraction = 0;    ///< of the whole load path, 0…1
  double begun_at = 0;    ///< the same where this run began or was gone on with
  Index increment = 0;    ///< accepted so far
  const SolverRecord* solver = nullptr;
  Index n_contact_elements = 0;
};

struct SimulateOptions {
  std::filesystem::path states;      ///< state file to write
  std::filesystem::path start_from;  ///< states of another run to start from; empty: the scene's start
  std::string after;                 ///< stage of that run at whose end to start
  bool resume =
      false;  ///< go on with the run that `states` holds, from its last increment; at the start where there is none
  /// What was changed in the scene since its text was read, in words. A run that is gone on with has had the same.
  std::string changes;
  int n_threads = 0;                                  ///< 0: all cores
  std::function<void(const Progress&)> on_increment;  ///< may be empty
  std::function<void(const std::string&)> log;        ///< Newton residuals line by line (-v); may be empty
  const std::atomic<bool>* stop = nullptr;            ///< end when true, without the increment under way
};

}  // namespace trame::micro
