#pragma once
/// \file
/// The one list of what an increment holds in a state file: path, unit, field. Creating, appending and reading all walk
/// it, so that they cannot disagree. Included by snapshot_*.cpp only; described for readers in README.md.

#include <string>

#include "micro/core/text.h"
#include "micro/states/snapshot.h"

namespace trame::micro::layout {

inline constexpr const char* name = "trame-states";
inline constexpr Index version = 3, oldest_version = 2;
inline constexpr std::size_t max_stage_bytes = max_name_bytes;
static_assert(max_stage_bytes == 128, "part of the layout");

/// Walks the fields of every node. `visit.fixed(path, unit, field, rows)`: one value per node or body;
/// `visit.later_fixed`: the same, which older files do not have.
template <class Fibers, class Visitor>
void visit_fibers(Fibers& fibers, std::size_t n_nodes, Visitor& visit) {
  visit.fixed("fibers/r", "m", fibers.r, n_nodes);
  visit.fixed("fibers/g1", "1", fibers.g1, n_nodes);
  visit.fixed("fibers/g2", "1", fibers.g2, n_nodes);
  visit.fixed("fibers/tangent", "1", fibers.tangent, n_nodes);
}

template <class Bodies, class Visitor>
void visit_bodies(Bodies& bodies, std::size_t n_bodies, Visitor& visit) {
  visit.fixed("bodies/position", "m", bodies.position, n_bodies);
  visit.fixed("bodies/rotation", "1", bodies.rotation, n_bodies);
  visit.fixed("bodies/force", "N", bodies.force, n_bodies);
  visit.fixed("bodies/moment", "N m", bodies.moment, n_bodies);
  visit.later_fixed("bodies/motion", "m", bodies.motion, n_bodies);
  visit.later_fixed("bodies/turn", "rad", bodies.turn, n_bodies);
}

template <class Sides, class Visitor>
void visit_sides(Sides& sides, Visitor& visit) {
  visit.later_scalar("sides/warp_strain", "1", sides.strain[0]);
  visit.later_scalar("sides/weft_strain", "1", sides.strain[1]);
  visit.later_scalar("sides/warp_force", "N", sides.force[0]);
  visit.later_scalar("sides/weft_force", "N", sides.force[1]);
}

/// `visit.ragged(path, unit, field, single)`: as many values as the increment has contact elements; `single`: stored in
/// 32 bits, which keep far more digits than a penalty solution has. `visit.later_ragged`: the same, which older files
/// do not have.
template <class Contacts, class Visitor>
void visit_contacts(Contacts& contacts, Visitor& visit) {
  visit.ragged("contacts/fiber_a", "1", contacts.fiber_a, false);
  visit.ragged("contacts/fiber_b", "1", contacts.fiber_b, false);
  visit.ragged("contacts/s_a", "m", contacts.s_a, false);
  visit.ragged("contacts/s_b", "m", contacts.s_b, false);
  visit.ragged("contacts/position", "m", contacts.position, true);
  visit.ragged("contacts/normal", "1", contacts.normal, true);
  visit.ragged("contacts/gap", "m", contacts.gap, true);
  visit.ragged("contacts/normal_force", "N", contacts.normal_force, true);
  visit.ragged("contacts/friction_force", "N", contacts.friction_force, true);
  visit.ragged("contacts/slip", "m", contacts.slip, true);
  visit.ragged("contacts/penalty", "N/m", contacts.penalty, false);
  visit.ragged("contacts/length", "m", contacts.length, false);
  visit.later_ragged("contacts/preload", "m", contacts.preload, false);
  visit.later_ragged("contacts/point", "1", contacts.point, false);
  visit.later_ragged("contacts/stuck", "1", contacts.stuck, false);
  visit.later_ragged("contacts/image_warp", "1", contacts.image_warp, false);
  visit.later_ragged("contacts/image_weft", "1", contacts.image_weft, false);
}

/// `visit.scalar(path, unit, field)`: one value per increment; `visit.later_scalar`: the same, which older files do not
/// have.
template <class Solver, class Visitor>
void visit_solver(Solver& solver, Visitor& visit) {
  visit.scalar("solver/n_newton_iterations", "1", solver.n_newton_iterations);
  visit.scalar("solver/n_factorizations", "1", solver.n_factorizations);
  visit.scalar("solver/n_geometry_updates", "1", solver.n_geometry_updates);
  visit.scalar("solver/n_cuts", "1", solver.n_cuts);
  visit.scalar("solver/residual", "1", solver.residual);
  visit.scalar("solver/max_penetration_over_radius", "1", solver.max_penetration_over_radius);
  visit.scalar("solver/force_imbalance", "1", solver.force_imbalance);
  visit.scalar("solver/moment_imbalance", "1", solver.moment_imbalance);
  visit.scalar("solver/proximal", "1", solver.proximal);
  visit.scalar("solver/seconds", "s", solver.seconds);
  visit.later_scalar("solver/unstable", "1", solver.unstable);
  visit.scalar("energy/external_work", "J", solver.energy.external_work);
  visit.scalar("energy/stored", "J", solver.energy.stored);
  visit.scalar("energy/friction", "J", solver.energy.friction);
  visit.scalar("energy/damping", "J", solver.energy.damping);
  visit.scalar("energy/imbalance", "J", solver.energy.imbalance);
  visit.later_scalar("energy/release", "J", solver.energy.release);
  for (std::size_t s = 0; s < source_names.size(); ++s)
    visit.later_scalar(std::string("energy/work_") + std::string(source_names[s]), "J", solver.energy.work[s]);
}

/// Everything of an increment; `visit.label(path, text)`: a short text per increment.
template <class AnyIncrement, class Visitor>
void visit_increment(AnyIncrement& increment, std::size_t n_nodes, std::size_t n_bodies, Visitor& visit) {
  visit.label("stage", increment.stage);
  visit.scalar("stage_time", "1", increment.stage_time);
  visit_fibers(increment.fibers, n_nodes, visit);
  visit_bodies(increment.bodies, n_bodies, visit);
  visit_sides(increment.sides, visit);
  visit_contacts(increment.contacts, visit);
  visit_solver(increment.solver, visit);
}

/// Where increment i has its contact elements: rows first … first + count − 1.
struct ContactRows {
  std::uint64_t first = 0, count = 0;
};

template <class Rows, class Visitor>
void visit_contact_rows(Rows& rows, Visitor& visit) {
  visit.scalar("contacts/first", "1", rows.first);
  visit.scalar("contacts/count", "1", rows.count);
}

/// Where the bytes are that a run needs to go on from its `n_increments`-th saved increment: in turn, so that while
/// those of one are written, those of the one before stay.
inline std::string continuation_path(std::uint64_t n_increments) {
  return n_increments % 2 == 0 ? "continuation/even" : "continuation/odd";
}
/// Stands before those bytes. A write that was cut short is known by the checksum.
struct ContinuationHead {
  std::uint64_t n_increments = 0, n_bytes = 0, checksum = 0;
};
/// FNV-1a.
inline std::uint64_t checksum(const std::string& bytes) {
  std::uint64_t sum = 14695981039346656037ULL;
  for (const char c : bytes) sum = (sum ^ static_cast<std::uint8_t>(c)) * 1099511628211ULL;
  return sum;
}

}  // namespace trame::micro::layout
