#include "workflows/curves/curve_units.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <numbers>

namespace trame::workflows {

namespace {

constexpr Shown micrometres{1e6, "µm"}, degrees{180 / std::numbers::pi, "°"}, per_millimetre{1e-3, "1/mm"};

constexpr std::array kinds = {
    CurveKind{
        "m", "Pa", "plates closed in", "pressure", micrometres, {1e-3, "kPa"}, {1e-9, "kPa/µm"}, {1, "J/m²"}, true},
    CurveKind{
        "1/m", "N", "curvature", "moment per width", per_millimetre, {1e3, "mN"}, {1e6, "µN m"}, {1e3, "mJ/m²"}, true},
    CurveKind{"1/m", "N m", "curvature", "moment", per_millimetre, {1e6, "µN m"}, {1e9, "mN mm²"}, {1e6, "µJ/m"}, true},
    CurveKind{
        "rad", "N/m", "shear angle", "shear force per length", degrees, {1, "N/m"}, {1, "N/m/rad"}, {1, "J/m²"}, true},
    CurveKind{"1",
              "N/m",
              "strain of the sides",
              "force per width",
              {100, "%"},
              {1, "N/m"},
              {1e-3, "kN/m"},
              {1, "J/m²"},
              true},
    CurveKind{"1", "N", "strain of the sides", "force on a side", {100, "%"}, {1, "N"}, {1e-3, "kN"}, {1, "N"}, true},
    CurveKind{"m",
              "N",
              "motion of the body",
              "force along the axis",
              micrometres,
              {1e3, "mN"},
              {1, "N/m"},
              {1e6, "µJ"},
              false},
    CurveKind{"rad",
              "N m",
              "turn of the body",
              "moment about the axis",
              degrees,
              {1e6, "µN m"},
              {1e6, "µN m/rad"},
              {1e6, "µJ"},
              false}};

}  // namespace

std::span<const CurveKind> curve_kinds() { return kinds; }

const CurveKind& curve_kind(const std::string& motion_unit, const std::string& reaction_unit) {
  const auto* const found = std::find_if(kinds.begin(), kinds.end(), [&](const CurveKind& kind) {
    return kind.motion_unit == motion_unit && kind.reaction_unit == reaction_unit;
  });
  assert(found != kinds.end());
  return *found;
}

}  // namespace trame::workflows
