#pragma once
/// \file
/// How far the results of one run may be off, told without another run.

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "micro/states/snapshot.h"
#include "micro/simulate.h"
#include "workflows/accuracy/profile.h"

namespace trame::workflows {

/// Energies at an accepted increment.
struct EnergyPoint {
  std::string stage;
  micro::EnergyRecord energy;
};

/// Parts of the a posteriori estimate, relative errors; empty where there is nothing to tell it from. They are of first
/// order, so that none says more than 1: the result may be off by all of itself.
struct PosterioriEstimate {
  /// Energy that the last stage has gained or lost by its steps and detections, over the largest of its terms.
  std::optional<double> steps;
  /// Energy that contacts would need to give up their penetration, over the stored energy. First order in the penalty's
  /// compliance.
  std::optional<double> penetration;
  /// Bending energy that elements cannot follow, over the stored energy: both fiber models have a curvature κ that is
  /// linear in an element, which misses ½ E I κ''² h⁵/720 of it. κ'' from second differences of the curvature between
  /// elements of length h.
  std::optional<double> elements;
  /// Largest error of a straight line between two points of the force curve, over its largest force: second differences
  /// over 8. Not in the total, because points of the curve do not have it.
  std::optional<double> between_increments;

  /// Sum of steps, penetration (none without contact) and elements, at most 1; empty where steps or elements are not
  /// known.
  [[nodiscard]] std::optional<double> total() const;
};

/// Energy of fibers that are strained by 10⁻⁹ all over, J: what is below is round-off, and no error can be told from
/// it.
[[nodiscard]] double energy_noise(const micro::FiberMesh& mesh);
[[nodiscard]] std::optional<double> step_error(const std::vector<EnergyPoint>& energies, double noise = 0);
[[nodiscard]] std::optional<double> penetration_error(const micro::Increment& last, double noise = 0);
[[nodiscard]] std::optional<double> element_error(const micro::FiberMesh& mesh, const micro::Increment& last);
[[nodiscard]] std::optional<double> interpolation_error(const std::vector<micro::CurvePoint>& curve);

[[nodiscard]] PosterioriEstimate estimate_errors(const micro::SnapshotReader& states,
                                                 const std::vector<EnergyPoint>& energies,
                                                 const std::vector<micro::CurvePoint>& curve);

/// For summary.json: the estimate, which kind it is and what it covers. The kind is "profile" where `run` (may be null)
/// is a run of `profile` with the settings at hand, else "a posteriori"; the parts of the latter are always there.
[[nodiscard]] nlohmann::json error_estimate_json(const PosterioriEstimate& estimate, const Profile* profile,
                                                 const ProfileRun* run);

}  // namespace trame::workflows
