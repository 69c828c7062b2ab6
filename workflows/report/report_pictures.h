#pragma once
/// \file
/// Pictures of the patch for the report. The program render_patch draws them, so that VTK's rendering, which needs an X
/// server and ends the process without one, stays out of the programs that write reports.

#include <string>
#include <vector>

#include "meso/fiber_states.h"

namespace trame::workflows {

struct ReportPicture {
  std::string png;      ///< bytes
  std::string caption;  ///< HTML
  bool wide = false;    ///< much wider than high
};

struct PatchPictures {
  std::vector<ReportPicture> pictures;
  std::string missing;   ///< why there are none; empty where there are
  bool of_cell = false;  ///< copies of a periodic cell
};

/// The reference state and another one, each in perspective, from above and cut open along a yarn: the middle warp yarn
/// of a weave, else the one that reaches farthest. There must be a yarn. Of a periodic cell, several copies.
/// `name`: of that state in captions, HTML. On the X server of DISPLAY where one answers, else on one that xvfb-run
/// starts.
[[nodiscard]] PatchPictures patch_pictures(const meso::FiberStates& states, Index state, const std::string& name);

}  // namespace trame::workflows
