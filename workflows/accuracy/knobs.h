#pragma once
/// \file
/// What can be changed about a scene to buy accuracy with time, or time with accuracy.

#include <functional>
#include <string>
#include <vector>

#include "micro/scene/scene.h"

namespace trame::workflows {

/// A knob at a value, both as text: elements=0.5.
struct Setting {
  std::string knob, value;
  bool operator==(const Setting&) const = default;
};
/// At most one setting of each knob. None: the scene as it is.
using Settings = std::vector<Setting>;

/// "elements=0.5 increments=2", or "as the scene" for none.
[[nodiscard]] std::string text(const Settings& settings);

struct Knob {
  std::string name;
  std::string meaning;
  std::string allowed;
  std::vector<std::string> values;  ///< that a study tries, coarse to fine
  /// Whether it decides how well the equations are solved, and not which ones they are.
  bool is_numerical = true;
  /// Whether a larger number is the finer one.
  bool larger_is_finer = false;
  /// Exponent with which the error should fall as the knob is refined, and why; empty where theory gives none.
  std::string theory;
  /// Throws InputError for a value that is not allowed.
  std::function<void(micro::Scene&, const std::string& value)> apply;
  /// Value of the scene; empty where the scene has no use for the knob.
  std::function<std::string(const micro::Scene&)> current;
};

/// All knobs, those of the numerics first.
[[nodiscard]] const std::vector<Knob>& knobs();
/// Throws InputError, with the names there are.
[[nodiscard]] const Knob& find_knob(const std::string& name);

/// Reads knob=value. Throws InputError for an unknown knob or a value that it does not allow.
[[nodiscard]] Setting parse_setting(const std::string& text);
/// Reads knob=value,value,… into one setting each.
[[nodiscard]] Settings parse_values(const std::string& text);

/// A value as a number; NaN for words.
[[nodiscard]] double number_of(const std::string& value);
/// Fineness as a number that grows with accuracy, for knobs with numbers; NaN for words.
[[nodiscard]] double fineness(const Setting& setting);

/// `scene` with the settings, which its text then names in a comment. Throws InputError for values that are not
/// allowed, and for knobs that the scene has no use for or that are set twice.
[[nodiscard]] micro::Scene with_settings(micro::Scene scene, const Settings& settings);

}  // namespace trame::workflows
