#include "micro/run/record.h"

namespace trame::micro {

FiberConfiguration dimensional(const FiberConfiguration& configuration, const Scales& scales) {
  FiberConfiguration c = configuration;
  for (Vec3& r : c.r) r *= scales.length;
  return c;
}

FiberMesh dimensional(const FiberMesh& mesh, const Scales& scales) {
  FiberMesh m = mesh;
  for (double& r : m.radius) r *= scales.length;
  for (double& s : m.arc_length) s *= scales.length;
  for (double& ea : m.axial_stiffness) ea *= scales.force();
  return m;
}

ContactRecord record_contacts(const StageModel& model, const State& state, const Scales& scales) {
  ContactRecord record;
  if (!model.contact) return record;
  const std::vector<StickSlip>& stick_slip = model.contact->stick_slip();
  for (std::size_t i = 0; i < model.contact->elements().size(); ++i) {
    const ContactElement& e = model.contact->elements()[i];
    const Vec3 a = e.a.evaluate(model.layout, state), b = e.b.evaluate(model.layout, state);
    const double gap = e.gap();
    record.fiber_a.push_back(e.fiber_a);
    record.fiber_b.push_back(e.fiber_b);
    const PlacesInCell at = in_first_periods(model.field.mesh(), e.fiber_a, e.fiber_b, {e.s_a, e.s_b, e.pair.image()});
    record.s_a.push_back(at.s_a * scales.length);
    record.s_b.push_back(at.s_b * scales.length);
    record.position.push_back(0.5 * (a + b) * scales.length);
    record.normal.push_back(e.measured.force_direction.normalized());
    record.gap.push_back(gap * scales.length);
    record.normal_force.push_back(e.normal_force(model.contact->regularisation(e)) * scales.force());
    const bool rubs = !stick_slip.empty();
    record.friction_force.push_back(rubs ? Vec3(-friction(stick_slip[i], b - a).force * scales.force()) : Vec3::Zero());
    record.slip.push_back(rubs ? Vec3(stick_slip[i].tangential(b - a - stick_slip[i].x_start) * scales.length)
                               : Vec3::Zero());
    record.penalty.push_back(e.penalty * e.next_scale / e.penalty_scale * scales.force() / scales.length);
    record.length.push_back(e.length * scales.length);
    record.preload.push_back(e.next_preload * scales.length);
    record.point.push_back(e.crossing ? 1 : 0);
    record.stuck.push_back(e.stuck ? 1 : 0);
    record.image_warp.push_back(at.image[0]);
    record.image_weft.push_back(at.image[1]);
  }
  return record;
}

Increment start_record(const StageStart& start, const Scales& scales) {
  Increment record;
  record.stage = "start";
  record.fibers = dimensional(start.configuration, scales);
  for (const Pose& p : start.poses) {
    record.bodies.position.push_back(p.position * scales.length);
    record.bodies.rotation.push_back(p.rotation);
    record.bodies.force.emplace_back(Vec3::Zero());
    record.bodies.moment.emplace_back(Vec3::Zero());
  }
  return record;
}

BodyRecord record_bodies(const StageModel& model, const State& state, const std::vector<double>& motion,
                         const Scales& scales) {
  BodyRecord record;
  for (Index b = 0; b < model.bodies.n_bodies(); ++b) {
    const Pose pose = model.bodies.pose(state, b);
    const auto [force, moment] = model.pull(state, b);
    record.position.push_back(pose.position * scales.length);
    record.rotation.push_back(pose.rotation);
    record.force.push_back(force * scales.force());
    record.moment.push_back(moment * scales.energy());
    const double* six = motion.data() + std::ptrdiff_t{6} * b;
    record.motion.emplace_back(six[0], six[1], six[2]);
    record.turn.emplace_back(six[3], six[4], six[5]);
  }
  return record;
}

SolverRecord record_solver(const StageModel& model, const State& state, const IncrementReport& report,
                           const EnergyRecord& energy) {
  return {.n_newton_iterations = report.n_newton_iterations,
          .n_factorizations = report.n_factorizations,
          .n_geometry_updates = report.n_geometry_updates,
          .n_cuts = report.n_cuts,
          .residual = report.residual,
          .max_penetration_over_radius = model.max_penetration_over_radius(),
          .force_imbalance = report.residual,
          .moment_imbalance = moment_imbalance(model, state),
          .proximal = model.proximal ? model.proximal->eta() : 0,
          .energy = energy,
          .seconds = report.seconds,
          .unstable = report.unstable ? 1 : 0};
}

double moment_imbalance(const StageModel& model, const State& state) {
  if (!model.ties || model.field.is_periodic()) return 0;
  Vec3 sum = Vec3::Zero();
  double magnitude = 0;
  for (Index b = 0; b < model.bodies.n_bodies(); ++b) {
    const auto [force, moment] = model.ties->pull(state, b);
    const Vec3 lever = model.bodies.pose(state, b).position.cross(force);
    sum += lever + moment;
    magnitude += lever.norm() + moment.norm();
  }
  for (const Vec3& moment : model.fiber_loads ? model.fiber_loads->moments(state) : std::vector<Vec3>()) {
    sum += moment;
    magnitude += moment.norm();
  }
  return magnitude > 0 ? sum.norm() / magnitude : 0;
}

EnergyRecord dimensional(const Ledger& ledger, const Scales& scales) {
  const double unit = scales.energy();
  EnergyRecord energy{ledger.total_supplied() * unit, ledger.stored * unit,      ledger[Sink::friction] * unit,
                      ledger[Sink::damping] * unit,   ledger.imbalance() * unit, ledger[Sink::release] * unit};
  for (std::size_t s = 0; s < energy.work.size(); ++s) energy.work[s] = ledger.supplied[s] * unit;
  return energy;
}

Ledger natural(const EnergyRecord& energy, const Scales& scales) {
  const double unit = scales.energy();
  Ledger ledger{.stored = energy.stored / unit,
                .dissipated = {energy.friction / unit, energy.damping / unit, energy.release / unit}};
  for (std::size_t s = 0; s < energy.work.size(); ++s) ledger.supplied[s] = energy.work[s] / unit;
  // Older files do not say where it came from.
  ledger[Source::bodies] += energy.external_work / unit - ledger.total_supplied();
  return ledger;
}

}  // namespace trame::micro
