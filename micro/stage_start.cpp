#include "micro/stage_start.h"

#include <algorithm>
#include <tuple>

#include "micro/core/wildcard.h"
#include "micro/model.h"

namespace trame::micro {

void StageStart::forget_contacts() {
  contact_history.clear();
  contact_tractions.clear();
}

StageStart start_of(const Assembly& assembly) {
  StageStart start;
  start.configuration = assembly.configuration;
  for (const Vec3& p : assembly.body_positions) start.poses.push_back({p, Mat3::Identity()});
  start.body_forces.assign(6 * start.poses.size(), 0.0);
  return start;
}

void place_leaders(const Assembly& assembly, const Stage& stage, std::vector<Pose>& poses) {
  for (Index leader = 0; leader < static_cast<Index>(poses.size()); ++leader) {
    if (std::any_of(assembly.ties.begin(), assembly.ties.end(), [&](const EndTie& t) { return t.body == leader; }))
      continue;
    Vec3 sum = Vec3::Zero();
    int n = 0;
    for (const Drive& d : stage.drives)
      for (std::size_t b = 0; b < poses.size() && d.mode == DriveMode::follow; ++b)
        if (d.leader == assembly.body_names[leader] && matches(d.bodies, assembly.body_names[b])) {
          sum += poses[b].position;
          ++n;
        }
    if (n > 0) poses[leader].position = sum / n;
  }
}

StageStart after_stage(const Stage& stage, const StageModel& model, const State& state, StageStart start) {
  model.field.write_configuration(state, start.configuration);
  for (Index b = 0; b < model.bodies.n_bodies(); ++b) start.poses[b] = model.bodies.pose(state, b);
  start.body_forces = model.body_forces(state);
  auto& history = start.contact_history;
  if (model.contact) {
    history = model.contact->history();
    start.contact_tractions = model.contact->tractions();
  }
  if (model.crossing_order) {
    const auto more = model.crossing_order->history();
    history.insert(history.end(), more.begin(), more.end());
    std::sort(history.begin(), history.end(), [](const ContactHistory& a, const ContactHistory& b) {
      return std::tie(a.fiber_a, a.fiber_b, a.s_a) < std::tie(b.fiber_a, b.fiber_b, b.s_a);
    });
  }
  start.just_separated = stage.separate_yarns;
  return start;
}

}  // namespace trame::micro
