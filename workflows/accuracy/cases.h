#pragma once
/// \file
/// Which runs a study makes.

#include <string>
#include <vector>

#include "workflows/accuracy/knobs.h"

namespace trame::workflows {

/// Why a case is in the study.
enum class CasePart { base, one_knob, grid, reference, looser_reference };
[[nodiscard]] std::string text(CasePart part);

struct Case {
  Settings settings;  ///< canonical: none that is the scene's own value, in the order of the knobs
  CasePart part = CasePart::base;
  bool same_effects = true;
};

/// What the user wants of a study; empty lists: the defaults.
struct CaseOptions {
  std::vector<std::string> knobs;  ///< to vary one at a time
  std::vector<Settings> values;    ///< for a knob, instead of its own
  std::vector<Settings> grid;      ///< for a knob; all combinations
  Settings reference;              ///< instead of the finest value of a knob
};

/// Whether two values of a knob are the same, as words or as numbers.
[[nodiscard]] bool same_value(const std::string& a, const std::string& b);
/// The settings that change something about `scene`.
[[nodiscard]] Settings canonical(const micro::Scene& scene, const Settings& settings);
/// Values at which a study tries a knob on a scene, its own among them where it is one of a kind; coarse to fine.
[[nodiscard]] Settings values_to_try(const micro::Scene& scene, const Knob& knob, const CaseOptions& options);

/// The base, each knob in turn, the grid, and last the reference and one that is a value looser in every knob. No
/// settings twice. Throws InputError for knobs that the scene has no use for.
[[nodiscard]] std::vector<Case> plan_cases(const micro::Scene& scene, const CaseOptions& options);

}  // namespace trame::workflows
