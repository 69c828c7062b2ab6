#pragma once
/// \file
/// Kinds of curves, and the units in which each is spoken of.

#include <cstdint>
#include <span>
#include <string>

namespace trame::workflows {

/// A factor from SI, and the unit that it leads to.
struct Shown {
  double factor = 1;
  const char* unit = "";
};

/// Curves of the same units in SI are of a kind and go onto one pair of axes.
struct CurveKind {
  const char *motion_unit, *reaction_unit;  ///< SI
  const char *motion_label, *reaction_label;
  Shown motion, reaction, stiffness, work;
  bool is_of_fabric;  ///< a fabric, not a body; rests on a test or on sides
};

/// All kinds, in the order in which they are shown.
[[nodiscard]] std::span<const CurveKind> curve_kinds();
[[nodiscard]] const CurveKind& curve_kind(const std::string& motion_unit, const std::string& reaction_unit);

}  // namespace trame::workflows
