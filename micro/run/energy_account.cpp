#include "micro/run/energy_account.h"

#include <Eigen/Geometry>
#include <numeric>

namespace trame::micro {

namespace {

State halfway(const State& from, const State& to) {
  State middle = from;
  for (std::size_t v = 0; v < from.q.size(); ++v) middle.q[v] = 0.5 * (from.q[v] + to.q[v]);
  for (std::size_t i = 0; i < from.rotations.size(); ++i)
    middle.rotations[i] =
        Eigen::Quaterniond(from.rotations[i]).slerp(0.5, Eigen::Quaterniond(to.rotations[i])).toRotationMatrix();
  return middle;
}

/// Gradient of the potential of all effects at a state, which they follow there.
std::vector<double> gradient(StageModel& model, const State& state) {
  std::vector<double> force(model.layout.n_dofs(), 0.0), magnitude(model.layout.n_vectors(), 0.0);
  Assembler assembler(model.layout, nullptr, 0, model.layout.n_nodes(), force.data(), magnitude.data(), nullptr,
                      Assembler::Tangent::none);
  for (const auto& effect : model.effects) {
    (void)effect->follow(state, Effect::Follow::renewal, everywhere);
    effect->add(state, assembler);
  }
  return force;
}

/// The sum over the effects of a stage.
Ledger effects_ledger(const StageModel& model, const State& state) {
  Ledger sum;
  for (const auto& effect : model.effects) sum += effect->ledger(state);
  return sum;
}

}  // namespace

void EnergyAccount::begin_stage(StageModel& model) {
  begin_at(model.effects, model.start, 0);
  beside_effects_ = total_;
  beside_effects_.stored = 0;
  add(Source::stages, effects_ledger(model, model.start).stored - total_.stored);
}

void EnergyAccount::close(const StageModel& model, const State& accepted) {
  total_ = beside_effects_;
  total_ += effects_ledger(model, accepted);
}

std::vector<double> body_motion(const StageModel& model, const State& from, const State& to) {
  std::vector<double> motion;
  for (Index b = 0; b < model.bodies.n_bodies(); ++b) {
    const Pose p = model.bodies.pose(from, b), q = model.bodies.pose(to, b);
    const Eigen::AngleAxisd turn(q.rotation * p.rotation.transpose());
    for (const Vec3& v : {Vec3(q.position - p.position), Vec3(turn.angle() * turn.axis())}) {
      const Vec3 dofs = model.bodies.in_dofs(b, v);
      motion.insert(motion.end(), dofs.data(), dofs.data() + 3);
    }
  }
  return motion;
}

double external_work(const StageModel& model, const std::vector<double>& motion, const std::vector<double>& forces_from,
                     const std::vector<double>& forces_to) {
  double work = 0;
  for (std::size_t i = 0; i < motion.size(); ++i)
    // What moves a follower is its leader, inside the system.
    if (model.drives[i].kind != DofDrive::Kind::follow) work += 0.5 * (forces_from[i] + forces_to[i]) * motion[i];
  return work;
}

double released_energy(StageModel& at_start, const State& first, double stage_time) {
  StageModel& model = at_start;
  const State& start = model.start;
  // Of bodies, what follows; what is driven is held.
  std::vector<Vec3> motion;
  for (std::size_t v = 0; v < start.q.size(); ++v) motion.emplace_back(first.q[v] - start.q[v]);
  for (Index b = 0; b < model.bodies.n_bodies(); ++b) {
    const Index position = model.layout.first_vector(model.bodies.node(b));
    Vec3 dofs = model.bodies.in_dofs(b, motion[position]);
    for (int d = 0; d < 3; ++d)
      if (model.drives[n_body_dofs * b + d].kind != DofDrive::Kind::follow) dofs[d] = 0;
    motion[position] = model.layout.change(position, dofs);
    motion[position + 1].setZero();
  }
  const auto force_along = [&](const State& state, double at) {
    begin_at(model.effects, start, at);
    const std::vector<double> force = gradient(model, state);
    return std::inner_product(force.begin(), force.end(), motion.front().data(), 0.0);
  };
  const double forces_at_start = force_along(start, 0), forces_at_end = force_along(first, stage_time);
  return -(forces_at_start + 4 * force_along(halfway(start, first), 0.5 * stage_time) - 2 * forces_at_end) / 6;
}

}  // namespace trame::micro
