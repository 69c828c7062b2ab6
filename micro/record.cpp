#include "micro/record.h"

#include <Eigen/Geometry>

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
    record.s_a.push_back(e.s_a * scales.length);
    record.s_b.push_back(e.s_b * scales.length);
    record.position.push_back(0.5 * (a + b) * scales.length);
    const Vec3 direction = e.measured.force_direction;
    record.normal.push_back(direction.normalized());
    record.gap.push_back(gap * scales.length);
    record.normal_force.push_back(e.force(model.contact->regularisation(e)) * direction.norm() * scales.force());
    const bool rubs = !stick_slip.empty();
    record.friction_force.push_back(rubs ? Vec3(-friction(stick_slip[i], b - a).force * scales.force()) : Vec3::Zero());
    record.slip.push_back(rubs ? Vec3(stick_slip[i].tangential(b - a - stick_slip[i].x_start) * scales.length)
                               : Vec3::Zero());
    record.penalty.push_back(e.penalty * e.next_scale / e.penalty_scale * scales.force() / scales.length);
    record.length.push_back(e.length * scales.length);
    record.preload.push_back(e.next_preload * scales.length);
    record.point.push_back(e.crossing ? 1 : 0);
    record.stuck.push_back(e.stuck ? 1 : 0);
  }
  return record;
}

BodyRecord record_bodies(const StageModel& model, const State& state, const Scales& scales) {
  BodyRecord record;
  for (Index b = 0; b < model.bodies.n_bodies(); ++b) {
    const Pose pose = model.bodies.pose(state, b);
    const auto [force, moment] = model.pull(state, b);
    record.position.push_back(pose.position * scales.length);
    record.rotation.push_back(pose.rotation);
    record.force.push_back(force * scales.force());
    record.moment.push_back(moment * scales.energy());
  }
  return record;
}

std::vector<double> body_forces(const StageModel& model, const State& state) {
  std::vector<double> forces;
  for (Index b = 0; b < model.bodies.n_bodies(); ++b) {
    const auto [force, moment] = model.pull(state, b);
    for (const Vec3& v : {force, moment}) forces.insert(forces.end(), v.data(), v.data() + 3);
  }
  return forces;
}

double moment_imbalance(const StageModel& model, const State& state) {
  if (!model.ties) return 0;
  Vec3 sum = Vec3::Zero();
  double magnitude = 0;
  for (Index b = 0; b < model.bodies.n_bodies(); ++b) {
    const auto [force, moment] = model.ties->pull(state, b);
    const Vec3 lever = model.bodies.pose(state, b).position.cross(force);
    sum += lever + moment;
    magnitude += lever.norm() + moment.norm();
  }
  return magnitude > 0 ? sum.norm() / magnitude : 0;
}

double external_work(const StageModel& model, const State& from, const State& to,
                     const std::vector<double>& forces_from, const std::vector<double>& forces_to) {
  double work = 0;
  for (Index b = 0; b < model.bodies.n_bodies(); ++b) {
    const Pose p = model.bodies.pose(from, b), q = model.bodies.pose(to, b);
    const Eigen::AngleAxisd turn(q.rotation * p.rotation.transpose());
    const Vec3 motion = q.position - p.position, rotation = turn.angle() * turn.axis();
    for (int d = 0; d < 6; ++d) {
      const Index i = 6 * b + d;
      // What moves a follower is its leader, inside the system.
      if (model.drives[i].kind == DofDrive::Kind::follow) continue;
      work += 0.5 * (forces_from[i] + forces_to[i]) * (d < 3 ? motion[d] : rotation[d - 3]);
    }
  }
  return work;
}

std::vector<double> gradient(const StageModel& model, const State& state) {
  std::vector<double> force(model.layout.n_dofs(), 0.0), magnitude(model.layout.n_vectors(), 0.0);
  Assembler assembler(model.layout, nullptr, 0, model.layout.n_nodes(), force.data(), magnitude.data(), nullptr,
                      Assembler::Tangent::none);
  for (const auto& effect : model.effects) {
    (void)effect->follow(state, Effect::Follow::renewal);
    effect->add(state, assembler);
  }
  return force;
}

Ledger energy_books(const StageModel& model, const State& state) {
  Ledger sum;
  for (const auto& effect : model.effects) sum += effect->ledger(state);
  return sum;
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
