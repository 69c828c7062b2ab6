#include "micro/run/restart.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>

#include "micro/core/error.h"
#include "micro/core/name_table.h"
#include "micro/scene/stages.h"

namespace trame::micro {

namespace {

/// Increment with which the stage ends; throws where there is none.
Index end_of_stage(const SnapshotReader& states, const std::string& stage) {
  std::string finished;
  for (Index i = states.n_increments() - 1; i > 0; --i) {
    const Increment increment = states.read(i);
    if (increment.stage_time < 1) continue;
    if (increment.stage == stage) return i;
    finished += (finished.empty() ? "" : ", ") + increment.stage;
  }
  throw InputError(
      fmt::format("--after {}: the states to start from have not finished a stage of that name; finished: {}", stage,
                  finished.empty() ? "none" : finished));
}

/// Equal up to the round-off of unit conversions.
bool equal(const std::vector<double>& a, const std::vector<double>& b, double unit) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [&](double x, double y) { return std::abs(x - y * unit) <= 1e-9 * std::abs(x); });
}

void require_same_fibers(const SnapshotHeader& header, const Assembly& assembly, const Scales& scales) {
  const FiberMesh &theirs = header.mesh, &ours = assembly.mesh;
  const auto require = [](bool same, const char* what) {
    if (!same)
      throw InputError(
          fmt::format("--start-from: the states are of another scene: {} differ; only stages may differ", what));
  };
  require(theirs.first_node == ours.first_node, "numbers of fibers or elements");
  require(equal(theirs.radius, ours.radius, scales.length), "radii of fibers");
  require(equal(theirs.arc_length, ours.arc_length, scales.length), "lengths of fibers");
  require(equal(theirs.axial_stiffness, ours.axial_stiffness, scales.force()), "axial stiffnesses of fibers");
  const NameTable names(assembly.body_names);
  for (const std::string& name : header.body_names)
    if (!names.find(name))
      throw InputError(
          fmt::format("--start-from: the scene has no body \"{}\", which the states have; a scene may have "
                      "more bodies than they, not fewer",
                      name));
}

/// Where a body stands that comes in late: as if the ends that it ties had taken it along from their layout. The pose
/// in which it fits them best, where they have moved against each other.
Pose taken_along(Index body, const Assembly& assembly, const FiberConfiguration& now) {
  const Pose at_layout{assembly.body_positions[body], Mat3::Identity()};
  struct End {
    Index node;
    double weight;  // of directions against positions
  };
  std::vector<End> ends;
  Vec3 mean_then = Vec3::Zero(), mean_now = Vec3::Zero();
  const FiberMesh& mesh = assembly.mesh;
  const FiberConfiguration& then = assembly.configuration;
  for (const EndTie& tie : assembly.ties) {
    if (tie.body != body) continue;
    const Index node = tie.end == FiberEnd::start ? mesh.first_node[tie.fiber] : mesh.first_node[tie.fiber + 1] - 1;
    ends.push_back({node, mesh.radius[tie.fiber] * mesh.radius[tie.fiber]});
    mean_then += then.r[node];
    mean_now += now.r[node];
  }
  if (ends.empty()) return at_layout;
  mean_then /= static_cast<double>(ends.size());
  mean_now /= static_cast<double>(ends.size());
  Mat3 turned = Mat3::Zero();
  for (const End& end : ends) {
    turned += (now.r[end.node] - mean_now) * (then.r[end.node] - mean_then).transpose();
    turned += end.weight *
              (now.g1[end.node] * then.g1[end.node].transpose() + now.g2[end.node] * then.g2[end.node].transpose() +
               now.tangent[end.node] * then.tangent[end.node].transpose());
  }
  const Eigen::JacobiSVD<Mat3> modes(turned, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 mirror = Mat3::Identity();
  mirror(2, 2) = (modes.matrixU() * modes.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  const Mat3 rotation = modes.matrixU() * mirror * modes.matrixV().transpose();
  return {mean_now + rotation * (at_layout.position - mean_then), rotation};
}

/// The bodies of a state, in SI units, with those that the scene has beside them.
BodyRecord with_late_bodies(const BodyRecord& record, const std::vector<std::string>& names, const Assembly& assembly,
                            const FiberConfiguration& natural, const Scales& scales) {
  const NameTable table(names);
  BodyRecord all;
  for (std::size_t b = 0; b < assembly.body_names.size(); ++b) {
    const std::optional<Index> found = table.find(assembly.body_names[b]);
    const bool is_late = !found;
    const Index known = found.value_or(0);
    const Pose pose = is_late ? taken_along(static_cast<Index>(b), assembly, natural) : Pose{};
    all.position.push_back(is_late ? Vec3(pose.position * scales.length) : record.position[known]);
    all.rotation.push_back(is_late ? pose.rotation : record.rotation[known]);
    all.force.push_back(is_late ? Vec3::Zero() : record.force[known]);
    all.moment.push_back(is_late ? Vec3::Zero() : record.moment[known]);
  }
  return all;
}

FiberConfiguration in_natural_units(FiberConfiguration fibers, const Scales& scales) {
  for (Vec3& r : fibers.r) r /= scales.length;
  return fibers;
}

/// A damaged file may hold any numbers. Fails for those that no run leaves behind and that could not be gone on from.
void require_plausible(const Increment& state, const FiberMesh& mesh) {
  const auto require = [](bool plausible, const std::string& what) {
    if (!plausible) throw InputError(fmt::format("--start-from: the states are damaged: {}", what));
  };
  constexpr double most_stretch = 100, most_radii = 1e9;  // far beyond what solves
  for (Index f = 0; f < mesh.n_fibers(); ++f)
    for (Index n = mesh.first_node[f]; n < mesh.first_node[f + 1]; ++n) {
      const bool near = state.fibers.r[n].norm() <= most_radii * mesh.radius[f];
      const bool joined = n == mesh.first_node[f] || (state.fibers.r[n] - state.fibers.r[n - 1]).norm() <=
                                                         most_stretch * (mesh.arc_length[n] - mesh.arc_length[n - 1]);
      const bool shaped = state.fibers.tangent[n].norm() <= most_stretch && state.fibers.g1[n].norm() <= most_stretch &&
                          state.fibers.g2[n].norm() <= most_stretch;
      require(near && joined && shaped, fmt::format("node {} of fiber {} is out of place", n - mesh.first_node[f], f));
    }
  for (const Mat3& rotation : state.bodies.rotation)
    require((rotation * rotation.transpose() - Mat3::Identity()).norm() < 1e-6 && rotation.determinant() > 0,
            "the rotation of a body is none");
  const ContactRecord& contacts = state.contacts;
  const auto on_fiber = [&](double s, Index fiber) {
    return s >= -1e-6 * mesh.length(fiber) && s <= (1 + 1e-6) * mesh.length(fiber);
  };
  for (std::size_t c = 0; c < contacts.gap.size(); ++c)
    require(on_fiber(contacts.s_a[c], contacts.fiber_a[c]) && on_fiber(contacts.s_b[c], contacts.fiber_b[c]) &&
                std::abs(contacts.normal[c].norm() - 1) < 1e-3 && contacts.penalty[c] > 0 && contacts.length[c] > 0,
            fmt::format("contact {} cannot be", c));
}

std::vector<ContactHistory> contact_history(const ContactRecord& record, const Scene& scene, const Assembly& assembly,
                                            const Scales& scales) {
  const std::vector<Material> materials = fiber_materials(scene, assembly);
  std::vector<ContactHistory> history(record.gap.size());
  for (std::size_t i = 0; i < history.size(); ++i) {
    ContactHistory& h = history[i];
    h.fiber_a = record.fiber_a[i];
    h.fiber_b = record.fiber_b[i];
    PlacesInCell at{record.s_a[i] / scales.length, record.s_b[i] / scales.length, {}};
    if (!record.image_warp.empty()) at.image = {record.image_warp[i], record.image_weft[i]};
    at = counted_on(assembly.mesh, h.fiber_a, h.fiber_b, at);
    h.s_a = at.s_a;
    h.s_b = at.s_b;
    h.image = at.image;
    h.normal = record.normal[i].normalized();
    h.traction = static_cast<Index>(i);
    const double starting_penalty =
        scene.contact.penalty * record.length[i] / scales.length *
        std::min(materials[h.fiber_a].young_modulus_transverse, materials[h.fiber_b].young_modulus_transverse);
    h.penalty_scale = record.penalty[i] / (scales.force() / scales.length) / starting_penalty;
    h.touches = record.gap[i] < 0;
    h.length = record.length[i] / scales.length;
    h.preload = record.preload.empty() ? 0 : record.preload[i] / scales.length;
    h.point = !record.point.empty() && record.point[i] != 0;
    h.stuck = !record.stuck.empty() && record.stuck[i] != 0;
  }
  return history;
}

StageStart stage_start_at(const Increment& state, const Scene& scene, const Assembly& assembly, const Scales& scales) {
  StageStart start;
  start.configuration = in_natural_units(state.fibers, scales);
  for (std::size_t b = 0; b < state.bodies.position.size(); ++b) {
    start.poses.push_back({state.bodies.position[b] / scales.length, state.bodies.rotation[b]});
    const Vec3 force = state.bodies.force[b] / scales.force(), moment = state.bodies.moment[b] / scales.energy();
    for (const Vec3& v : {force, moment}) start.body_forces.insert(start.body_forces.end(), v.data(), v.data() + 3);
  }
  start.contact_history = contact_history(state.contacts, scene, assembly, scales);
  for (const Vec3& f : state.contacts.friction_force) start.contact_tractions.push_back(-f / scales.force());
  return start;
}

/// "gravity of up to 0.01 N/m, drag of up to 2 N/m".
std::string text_of(const std::vector<StandingLoad>& loads, const Scales& scales) {
  std::string text;
  for (const StandingLoad& load : loads) {
    double most = 0;
    for (const Vec3& f : load.force) most = std::max(most, f.norm());
    text += fmt::format("{}{} of up to {:.6g} N/m", text.empty() ? "" : ", ", load.name,
                        most * scales.force() / scales.length);
  }
  return text.empty() ? "none" : text;
}

/// The loads that are on where stage `after` has ended. The other run's scene says so, where its text is kept; a scene
/// that has none in its stages up to there takes them over.
std::vector<StandingLoad> loads_after(const std::string& after, const SnapshotHeader& header, const Scene& scene,
                                      const Assembly& assembly, const Scales& scales) {
  const std::vector<StandingLoad> ours = standing_loads(scene, assembly, stage_number(scene, after) + 1);
  std::optional<Scene> other;
  try {
    other = nondimensional(parse_scene(header.scene_text, header.scene_name), scales);
  } catch (const InputError&) {  // of a scene that was made in a program, or is of an earlier version
  }
  if (!other || stage_number(*other, after) == other->stages.size()) return ours;
  const std::vector<StandingLoad> theirs =
      standing_loads(*other, assemble_scene(*other), stage_number(*other, after) + 1);
  if (!ours.empty() && !are_alike(ours, theirs))
    throw InputError(fmt::format(
        "--start-from: the loads on fibers at the end of stage {} differ: in the states {}, in the scene {}; a stage "
        "after it may change them",
        after, text_of(theirs, scales), text_of(ours, scales)));
  return theirs;
}

}  // namespace

Restart restart_after(const std::string& after, const SnapshotReader& states, const Scene& scene,
                      const Assembly& assembly, const Scales& scales) {
  const auto stage =
      std::find_if(scene.stages.begin(), scene.stages.end(), [&](const Stage& s) { return s.name == after; });
  if (stage == scene.stages.end() || stage + 1 == scene.stages.end()) {
    std::string names;
    for (std::size_t i = 0; i + 1 < scene.stages.size(); ++i) names += (i > 0 ? ", " : "") + scene.stages[i].name;
    throw InputError(fmt::format("--after {}: must be a stage of {} that another one follows: {}", after, scene.name,
                                 names.empty() ? "it has none" : names));
  }
  require_same_fibers(states.header(), assembly, scales);
  Restart restart;
  restart.next_stage = static_cast<std::size_t>(stage - scene.stages.begin()) + 1;
  restart.reference = states.read(0);
  restart.state = states.read(end_of_stage(states, after));
  require_plausible(restart.state, states.header().mesh);
  for (Increment* i : {&restart.reference, &restart.state})
    i->bodies =
        with_late_bodies(i->bodies, states.header().body_names, assembly, in_natural_units(i->fibers, scales), scales);
  restart.start = stage_start_at(restart.state, scene, assembly, scales);
  restart.start.loads = loads_after(after, states.header(), scene, assembly, scales);
  restart.start.just_separated = stage->separate_yarns;
  return restart;
}

}  // namespace trame::micro
