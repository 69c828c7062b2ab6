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

#include "workflows/curves/curve_units.h"
#include "workflows/curves/curves_table.h"

namespace trame::workflows {

/// A reaction over a motion, through all stages of a run.
struct Curve {
  struct Point {
    std::string stage;
    double stage_time = 0, motion = 0, reaction = 0;
  };
  std::string name;                        ///< "warp sides", "plates", "right, x"
  std::string motion_unit, reaction_unit;  ///< of a `CurveKind`
  std::vector<Point> points;
  std::set<std::string> stages;  ///< that drive it; not those in which it follows another body
  /// Its reaction does work along its motion; not so of sides that keep their distance, over the strain of the others.
  bool works = true;
  std::set<std::string> parts = {};  ///< names of curves that it is made of

  [[nodiscard]] const CurveKind& kind() const { return curve_kind(motion_unit, reaction_unit); }
  [[nodiscard]] bool is_of_sides() const { return motion_unit == "1"; }
  [[nodiscard]] bool is_of_fabric() const { return kind().is_of_fabric; }
};

/// Name of the curve of a dof of a body.
[[nodiscard]] std::string curve_name(const std::string& body, micro::BodyDof dof);

/// All curves of a table that some stage drives. Those of sides are strains and, where the scene is known, forces per
/// width of the fabric; the one that a test by name is done for comes first.
[[nodiscard]] std::vector<Curve> curves_of(const CurvesTable& table, const std::optional<micro::Scene>& scene);

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
