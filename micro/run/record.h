#pragma once
/// \file
/// From the dimensionless state of a stage to the records of an increment in SI units.

#include "micro/model/model.h"
#include "micro/states/snapshot.h"

namespace trame::micro {

[[nodiscard]] FiberConfiguration dimensional(const FiberConfiguration& configuration, const Scales& scales);
[[nodiscard]] FiberMesh dimensional(const FiberMesh& mesh, const Scales& scales);
/// The layout of the scene, before anything has moved.
[[nodiscard]] Increment start_record(const StageStart& start, const Scales& scales);
[[nodiscard]] ContactRecord record_contacts(const StageModel& model, const State& state, const Scales& scales);
/// `motion`: as in CurvePoint.
[[nodiscard]] BodyRecord record_bodies(const StageModel& model, const State& state, const std::vector<double>& motion,
                                       const Scales& scales);

/// What the solver did for an increment that ended at `state`.
[[nodiscard]] SolverRecord record_solver(const StageModel& model, const State& state, const IncrementReport& report,
                                         const EnergyRecord& energy);

/// Moment about the origin of all pulls of bodies and loads at fibers over the sum of the magnitudes that cancel in it.
[[nodiscard]] double moment_imbalance(const StageModel& model, const State& state);
[[nodiscard]] EnergyRecord dimensional(const Ledger& ledger, const Scales& scales);
[[nodiscard]] Ledger natural(const EnergyRecord& energy, const Scales& scales);

}  // namespace trame::micro
