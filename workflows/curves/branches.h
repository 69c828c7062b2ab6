#pragma once
/// \file
/// What is read off curves: loading and unloading apart, stiffness, energy of a cycle.

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "workflows/curves/curves_table.h"

namespace trame::workflows {

/// Curves of a kind go onto one pair of axes. In the order in which they are shown.
enum class CurveKind : std::uint8_t { plates, sides, translation, rotation };
inline constexpr std::array curve_kinds = {CurveKind::plates, CurveKind::sides, CurveKind::translation,
                                           CurveKind::rotation};

/// A reaction over a motion, through all stages of a run.
struct Curve {
  struct Point {
    std::string stage;
    double stage_time = 0, motion = 0, reaction = 0;
  };
  std::string name;                        ///< "warp sides", "plates", "right, x"
  std::string motion_unit, reaction_unit;  ///< "1", "m", "rad"; "N/m", "Pa", "N", "N m"
  std::vector<Point> points;
  std::set<std::string> stages;  ///< that drive it; not those in which it follows another body
  /// Its reaction does work along its motion; not so of sides that keep their distance, over the strain of the others.
  bool works = true;

  [[nodiscard]] bool is_of_sides() const { return motion_unit == "1"; }
  /// Pressure over how far plates have closed in.
  [[nodiscard]] bool is_of_plates() const { return reaction_unit == "Pa"; }
  [[nodiscard]] bool is_of_fabric() const { return is_of_sides() || is_of_plates(); }
  [[nodiscard]] bool turns() const { return motion_unit == "rad"; }
  [[nodiscard]] CurveKind kind() const {
    return is_of_plates()  ? CurveKind::plates
           : is_of_sides() ? CurveKind::sides
           : turns()       ? CurveKind::rotation
                           : CurveKind::translation;
  }
};

/// All curves of a table that some stage drives. Those of sides are strains and, where the scene is known, forces per
/// width of the fabric; that of the plates of a compaction is a pressure on yarns × spacing of both systems.
[[nodiscard]] std::vector<Curve> curves_of(const CurvesTable& table, const std::optional<micro::Scene>& scene);

/// Width of the fabric that the warp and the weft pull on, m: yarns × spacing.
[[nodiscard]] std::array<double, 2> side_widths(const micro::Weave& weave);

/// A part of a curve, within a stage, whose motion goes one way.
struct Branch {
  enum class Kind : std::uint8_t { loading, unloading, reversal } kind = Kind::loading;  ///< reversal: loads both ways
  std::size_t first = 0, last = 0;                                                       ///< points
  double initial_stiffness = 0, tangent_stiffness = 0;  ///< slopes of its first and of its last increment
  double work = 0;                                      ///< ∫ reaction d motion, trapezoidal
  /// Work over the cycle that it closes with the branch before: over the motions that both have, there and back.
  std::optional<double> loop = {};
};

/// Motions to and fro by less than a thousandth of the curve's range belong to the branch they are in.
[[nodiscard]] std::vector<Branch> branches_of(const Curve& curve);

/// Size of the work of the branch that took most; 0 without branches.
[[nodiscard]] double largest_work(const Curve& curve);

[[nodiscard]] std::string text(Branch::Kind kind);

/// branches.csv: a line for each branch of each curve. Throws WriteError.
void write_branches_csv(const std::filesystem::path& file, const std::vector<Curve>& curves);

}  // namespace trame::workflows
