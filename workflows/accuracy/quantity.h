#pragma once
/// \file
/// A number that a run is made for.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "micro/scene/scene.h"

namespace trame::workflows {

struct Quantity {
  std::string name;  ///< with its unit, such as "warp_force_at_2%_N"
  double value = 0;
  std::string group;        ///< errors are relative to the largest reference value of the group
  bool is_primary = false;  ///< one of those that the accuracy of a run is told by
};

/// Reads the quantities of interest of `scene` from the folder of a finished run, always the same in the same order.
/// Throws InputError for files that are missing or damaged.
[[nodiscard]] std::vector<Quantity> read_quantities(const micro::Scene& scene, const std::filesystem::path& folder);

/// Values that are known without a simulation.
struct ClosedForm {
  std::map<std::string, double> values;  ///< by name of the quantity
  double uncertainty = 0;                ///< relative: what its assumptions leave out
  std::string source;
};

}  // namespace trame::workflows
