#pragma once
/// \file
/// From a command line to a folder of results: what run_workflow and simulate_fibers share.

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "micro/core/timers.h"
#include "micro/states/cell_copies.h"
#include "workflows/program/output_directory.h"
#include "workflows/program/run_main.h"
#include "workflows/program/terminal.h"

namespace trame::workflows {

/// Results that a program derives from the saved states, after the simulation and the fibers' VTK files, with as many
/// copies of a periodic cell in its own VTK files. What it returns, an object, is merged into summary.json.
using FromStates = std::function<nlohmann::json(const OutputDirectory& out, const micro::Copies& copies, int n_threads,
                                                Timers& timers, Terminal& terminal)>;

/// What a program makes of all results, when the folder holds them.
using FromResults = std::function<void(const OutputDirectory& out, Terminal& terminal)>;

struct Program {
  std::string name;
  std::string description;
  FromStates from_states;    ///< may be empty
  FromResults from_results;  ///< may be empty
};

/// Runs `program` on a command line and returns its exit code. Every exception ends here as a message.
[[nodiscard]] int run_program(const Program& program, int argc, char** argv);

}  // namespace trame::workflows
