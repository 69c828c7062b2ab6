#pragma once
/// \file
/// Fabric facts as people and programs get them: one list of numbers, for the terminal, for the report and for
/// summary.json.

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "meso/comparison.h"

namespace trame::workflows {

/// A table for the terminal, with numbers in the units of the trade.
[[nodiscard]] std::string fabric_text(const meso::FabricFacts& facts);
/// The same table for the report.
[[nodiscard]] std::string fabric_html(const meso::FabricFacts& facts);
/// The same numbers in SI units: of the fabric, and in "warp" and "weft" of these; null where one is not known.
[[nodiscard]] nlohmann::json fabric_json(const meso::FabricFacts& facts);

}  // namespace trame::workflows
