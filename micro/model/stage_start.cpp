#include "micro/model/stage_start.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <vector>

#include "micro/core/name_table.h"
#include "micro/model/model.h"

namespace trame::micro {

void StageStart::forget_contacts() {
  contact_history.clear();
  contact_tractions.clear();
  surface_history.clear();
}

StageStart start_of(const Assembly& assembly) {
  StageStart start;
  start.configuration = assembly.configuration;
  for (const Vec3& p : assembly.body_positions) start.poses.push_back({p, Mat3::Identity()});
  start.body_forces.assign(n_body_dofs * start.poses.size(), 0.0);
  return start;
}

void place_leaders(const Assembly& assembly, const Stage& stage, std::vector<Pose>& poses) {
  const NameTable names(assembly.body_names);
  std::map<Index, std::vector<Index>> followers;
  for (const Drive& d : stage.drives) {
    if (d.mode != DriveMode::follow) continue;
    std::vector<Index>& of_leader = followers[*names.find(d.leader)];
    const std::vector<Index> bodies = names.fitting(d.bodies);
    of_leader.insert(of_leader.end(), bodies.begin(), bodies.end());
  }
  for (const EndTie& tie : assembly.ties) followers.erase(tie.body);
  for (const auto& [leader, bodies] : followers) {
    Vec3 sum = Vec3::Zero();
    for (const Index b : bodies) sum += poses[b].position;
    poses[leader].position = sum / static_cast<double>(bodies.size());
  }
}

namespace {

/// Where along its direction n the centre of a plane or sphere is as it touches the first fiber: the smallest n·x for
/// all particles of the fibers, between nodes on the parabolas of their elements. Infinite where a sphere passes by.
double place_of_touch(const Surface& surface, const Vec3& centre, const Vec3& n, const FiberMesh& mesh,
                      const FiberConfiguration& fibers) {
  constexpr int n_places = 4;  // of an element
  double nearest = std::numeric_limits<double>::infinity();
  for (Index f = 0; f < mesh.n_fibers(); ++f)
    for (Index first = mesh.first_node[f]; first + 2 < mesh.first_node[f + 1]; first += 2)
      for (int place = 0; place <= n_places; ++place) {
        const auto shape = quadratic_shape(2.0 * place / n_places - 1);
        Vec3 r = Vec3::Zero(), g1 = Vec3::Zero(), g2 = Vec3::Zero();
        for (int a = 0; a < 3; ++a) {
          r += shape[a] * fibers.r[first + a];
          g1 += shape[a] * fibers.g1[first + a];
          g2 += shape[a] * fibers.g2[first + a];
        }
        const double reach = surface.radius + mesh.radius[f], aside = n.cross(r - centre).norm();
        if (surface.shape == SurfaceShape::plane)
          nearest = std::min(nearest, n.dot(r) - mesh.radius[f] * std::hypot(n.dot(g1), n.dot(g2)));
        else if (aside < reach)
          nearest = std::min(nearest, n.dot(r) - std::sqrt(reach * reach - aside * aside));
      }
  return nearest;
}

}  // namespace

void place_touching(const Scene& scene, const Assembly& assembly, const Stage& stage, StageStart& start) {
  const NameTable names(assembly.body_names);
  for (const BodySpec& body : scene.bodies)
    for (const SurfaceSpec& spec : body.surfaces) {
      if (!spec.touches || !comes_in(spec, scene, stage)) continue;
      Pose& pose = start.poses[*names.find(body.name)];
      const Vec3 direction = pose.rotation * spec.surface.direction,
                 centre = pose.position + pose.rotation * spec.surface.center;
      const double touch = place_of_touch(spec.surface, centre, direction, assembly.mesh, start.configuration);
      if (std::isfinite(touch)) pose.position += (touch - direction.dot(centre)) * direction;
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
  if (model.surface_contact) start.surface_history = model.surface_contact->history();
  if (model.crossing_order) {
    const auto more = model.crossing_order->history();
    history.insert(history.end(), more.begin(), more.end());
    std::ranges::sort(history, {}, &ContactHistory::place);
  }
  start.loads = model.standing_loads;
  start.just_separated = stage.separate_yarns;
  return start;
}

}  // namespace trame::micro
