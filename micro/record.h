#pragma once
/// \file
/// From the dimensionless state of a stage to the records of an increment in SI units.

#include "micro/states/snapshot.h"
#include "micro/model.h"

namespace trame::micro {

[[nodiscard]] FiberConfiguration dimensional(const FiberConfiguration& configuration, const Scales& scales);
[[nodiscard]] FiberMesh dimensional(const FiberMesh& mesh, const Scales& scales);
[[nodiscard]] ContactRecord record_contacts(const StageModel& model, const State& state, const Scales& scales);
[[nodiscard]] BodyRecord record_bodies(const StageModel& model, const State& state, const Scales& scales);

/// Moment about the origin of all pulls of bodies at fibers over the sum of the magnitudes that cancel in it.
[[nodiscard]] double moment_imbalance(const StageModel& model, const State& state);
/// Work of the external forces on the bodies between two states, by the trapezoidal rule.
[[nodiscard]] double external_work(const StageModel& model, const State& from, const State& to,
                                   const std::vector<double>& forces_from, const std::vector<double>& forces_to);
/// Force with which each body pulls at its fibers and followers, 6 per body.
[[nodiscard]] std::vector<double> body_forces(const StageModel& model, const State& state);
/// Gradient of the potential of all effects at a state, which they follow there.
[[nodiscard]] std::vector<double> gradient(const StageModel& model, const State& state);
/// The energy books of a stage: the sum over its effects.
[[nodiscard]] Ledger energy_books(const StageModel& model, const State& state);
[[nodiscard]] EnergyRecord dimensional(const Ledger& ledger, const Scales& scales);
[[nodiscard]] Ledger natural(const EnergyRecord& energy, const Scales& scales);

}  // namespace trame::micro
