#include "micro/model/model.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "micro/core/error.h"
#include "micro/core/name_table.h"
#include "micro/core/wildcard.h"
#include "micro/fiber/enriched_beam.h"
#include "micro/fiber/rod.h"
#include "micro/periodic/anchors.h"
#include "micro/scene/stages.h"

namespace trame::micro {

Scales natural_scales(const Scene& scene) {
  const std::vector<Index> types = fiber_types_in_use(scene);
  Scales scales{0, 0};
  for (const Index t : types) {
    const FiberType& type = scene.fiber_types[t];
    scales.length += type.radius / static_cast<double>(types.size());
    scales.stress = std::max(scales.stress, scene.materials[type.material].young_modulus_axial);
  }
  return scales;
}

Scene nondimensional(const Scene& scene, const Scales& scales) {
  Scene s = scene;
  const double length = scales.length;
  for (Material& m : s.materials)
    for (double* modulus : {&m.young_modulus_axial, &m.young_modulus_transverse, &m.shear_modulus_axial})
      *modulus /= scales.stress;
  for (FiberType& t : s.fiber_types) t.radius /= length;
  for (FiberSpec& f : s.fibers)
    for (Vec3& p : f.points) p /= length;
  for (BundleSpec& b : s.bundles)
    for (Vec3& p : b.points) p /= length;
  if (s.weave)
    for (YarnSystem* y : {&s.weave->warp, &s.weave->weft}) {
      y->yarn_spacing /= length;
      y->margin /= length;
      for (YarnKind& kind : y->kinds) kind.twist *= length;
    }
  for (BodySpec& b : s.bodies) {
    b.position /= length;
    for (SurfaceSpec& spec : b.surfaces) spec.surface = scaled(spec.surface, 1 / length);
  }
  for (Stage& stage : s.stages) {
    // Densities stay as they are: of a density in kg/m³, gravity makes a force per length in natural units.
    for (FiberLoad& load : stage.loads)
      load.value /= load.kind == LoadKind::gravity ? scales.stress / length : scales.stress * length;
    for (Drive& d : stage.drives) {
      const bool translation = d.dof <= BodyDof::z;
      if (d.mode == DriveMode::force) d.value /= scales.force() * (translation ? 1 : length);
      if (d.mode == DriveMode::displacement && translation) d.value /= length;
    }
  }
  return s;
}

std::vector<FiberModel> models_in_stage(const Scene& scene, const Assembly& assembly, const Stage& stage) {
  std::vector<FiberModel> models;
  for (const Index type : assembly.type_of_fiber)
    models.push_back(stage.fiber_model.value_or(scene.fiber_types[type].model));
  return models;
}

std::vector<YarnCrossing> ordered_crossings(const Assembly& assembly) {
  std::vector<YarnCrossing> crossings;
  for (const WeaveCrossing& c : assembly.crossings)
    crossings.push_back(c.warp_above ? YarnCrossing{c.warp_yarn, c.weft_yarn} : YarnCrossing{c.weft_yarn, c.warp_yarn});
  return crossings;
}

namespace {

/// Stiffness of ties and followers over that of a fiber element: their compliance stays below what is reported.
constexpr double tie_stiffness = 1e3;
/// Penetration that crossings are held to while yarns are parted over that of contact: held to the target itself, they
/// cost five times the iterations.
constexpr double over_target = 10;

const Material& material_of(const Scene& scene, const Assembly& assembly, Index fiber) {
  return scene.materials[scene.fiber_types[assembly.type_of_fiber[fiber]].material];
}

}  // namespace

std::vector<Material> fiber_materials(const Scene& scene, const Assembly& assembly) {
  std::vector<Material> materials;
  materials.reserve(static_cast<std::size_t>(assembly.mesh.n_fibers()));
  for (Index f = 0; f < assembly.mesh.n_fibers(); ++f) materials.push_back(material_of(scene, assembly, f));
  return materials;
}

StageModel::StageModel(const Scene& scene, const Assembly& assembly, const Stage& stage, const StageStart& from)
    : bodies(static_cast<Index>(assembly.body_names.size()), layout, assembly.n_skew_bodies, assembly.skew_axes),
      field(assembly.mesh, models_in_stage(scene, assembly, stage), layout, assembly.period_bodies),
      assembly_(assembly) {
  start.q.assign(layout.n_vectors(), Vec3::Zero());
  start.rotations.resize(bodies.n_bodies());
  field.read_configuration(from.configuration, start);
  for (Index b = 0; b < bodies.n_bodies(); ++b) bodies.set_pose(start, b, from.poses[b]);
  resolve_drives(scene, assembly, stage, from);
  add_fibers(scene, assembly);
  add_contact(scene, assembly, stage, from);
  add_surfaces(scene, assembly, stage, from);
  add_bodies(assembly, stage, from);
  add_fiber_loads(scene, assembly, stage, from);
  if (field.is_periodic()) effects.push_back(std::make_unique<Anchors>(field));
  if (contact && from.just_separated) contact->offset_gaps(start);
  if (stage.proximal_start > 0) {
    double stiffness = 0;  // mean E A / L
    for (Index f = 0; f < assembly.mesh.n_fibers(); ++f)
      stiffness += assembly.mesh.axial_stiffness[f] / assembly.mesh.length(f) / assembly.mesh.n_fibers();
    auto effect = std::make_unique<Proximal>(layout, Proximal::Settings{.first_node = bodies.n_bodies(),
                                                                        .start = stage.proximal_start * stiffness,
                                                                        .end = stage.proximal_end * stiffness});
    proximal = effect.get();
    effects.push_back(std::move(effect));
  }
}

void StageModel::resolve_drives(const Scene& scene, const Assembly& assembly, const Stage& stage,
                                const StageStart& from) {
  drives.assign(n_body_dofs * bodies.n_bodies(), {});
  double stiffness = 0;
  for (Index f = 0; f < assembly.mesh.n_fibers(); ++f)
    stiffness += tie_stiffness * assembly.mesh.axial_stiffness[f] / field.element_length(f) / bodies.n_bodies();
  const NameTable names(assembly.body_names);
  for (const Drive& d : stage.drives) {
    const Index leader = d.mode == DriveMode::follow ? *names.find(d.leader) : 0;
    for (const Index b : names.fitting(d.bodies)) {
      DofDrive& drive = drives[bodies.dof(b, d.dof)];
      const int axis = static_cast<int>(d.dof);
      switch (d.mode) {
        case DriveMode::displacement: drive = {DofDrive::Kind::displacement, d.value, d.amplitude}; break;
        case DriveMode::force: drive = {DofDrive::Kind::force, d.value, d.amplitude}; break;
        case DriveMode::strain: {
          const int along = b == assembly.period_bodies[0] ? 0 : b == assembly.period_bodies[1] ? 1 : axis;
          drive = {DofDrive::Kind::displacement, d.value * bodies.in_dofs(b, from.poses[b].position)[along],
                   d.amplitude};
          break;
        }
        case DriveMode::follow:
          if (axis > 2)
            throw InputError(
                fmt::format("{}: stage {}: follow drives x, y or z, not a rotation", scene.name, stage.name));
          drive = {DofDrive::Kind::follow};
          follow_terms_.push_back({.follower = b,
                                   .leader = leader,
                                   .axis = axis,
                                   .leader_start = from.poses[leader],
                                   .follower_start = from.poses[b].position,
                                   .stiffness = stiffness});
          break;
      }
    }
  }
}

void StageModel::add_fibers(const Scene& scene, const Assembly& assembly) {
  bool any_enriched = false, any_rod = false;
  for (Index f = 0; f < assembly.mesh.n_fibers(); ++f)
    (field.model(f) == FiberModel::enriched ? any_enriched : any_rod) = true;
  const std::vector<Material> materials = fiber_materials(scene, assembly);
  if (any_enriched)
    effects.push_back(std::make_unique<EnrichedBeams>(field, materials, assembly.configuration, scene.twist_stretch));
  if (any_rod) effects.push_back(std::make_unique<Rods>(field, materials));
}

namespace {

ContactLaw contact_law(const ContactSettings& c, const Stage& stage) {
  return {
      .search = {.spacing = c.spacing, .search_margin = c.search_margin, .self_contact = c.self_contact, .wanted = {}},
      .penalty = c.penalty,
      .target_penetration = c.target_penetration,
      .regularisation = c.regularisation,
      .adapt_penalty = c.adapt_penalty,
      .friction = c.friction && stage.friction && c.friction_coefficient > 0,
      .friction_coefficient = c.friction_coefficient,
      .reversible_slip = c.reversible_slip};
}

std::vector<double> transverse_moduli(const Scene& scene, const Assembly& assembly) {
  std::vector<double> moduli;
  for (const Material& m : fiber_materials(scene, assembly)) moduli.push_back(m.young_modulus_transverse);
  return moduli;
}

}  // namespace

bool comes_in(const SurfaceSpec& surface, const Scene& scene, const Stage& stage) {
  return stage_number(scene, stage.name) == first_stage(scene, surface);
}

bool is_there(const SurfaceSpec& surface, const Scene& scene, const Stage& stage) {
  return stage_number(scene, stage.name) >= first_stage(scene, surface);
}

void StageModel::add_surfaces(const Scene& scene, const Assembly& assembly, const Stage& stage,
                              const StageStart& from) {
  ContactLaw law = contact_law(scene.contact, stage);
  law.friction = scene.contact.friction && stage.friction;
  std::vector<BodySurface> surfaces;
  const NameTable names(assembly.body_names);
  for (const BodySpec& body : scene.bodies)
    for (const SurfaceSpec& spec : body.surfaces) {
      if (!is_there(spec, scene, stage)) continue;
      const double friction = spec.friction_coefficient.value_or(law.friction_coefficient);
      surfaces.push_back({*names.find(body.name), spec.surface, law.friction ? friction : 0, body.name});
    }
  if (surfaces.empty()) return;
  auto effect =
      std::make_unique<SurfaceContact>(field, bodies, std::move(surfaces), law, transverse_moduli(scene, assembly));
  effect->set_history(from.surface_history);
  surface_contact = effect.get();
  effects.push_back(std::move(effect));
}

void StageModel::add_contact(const Scene& scene, const Assembly& assembly, const Stage& stage, const StageStart& from) {
  const ContactSettings& c = scene.contact;
  if (c.scope != ContactScope::none) {
    ContactLaw law = contact_law(c, stage);
    const FiberMesh& mesh = assembly.mesh;
    const bool between_yarns = c.scope == ContactScope::between_yarns, separates = stage.separate_yarns;
    if (between_yarns || separates)
      law.search.wanted = [&mesh, between_yarns, separates](Index a, Index b) {
        const Index yarn_a = mesh.yarn_of_fiber[a], yarn_b = mesh.yarn_of_fiber[b];
        if (between_yarns && yarn_a == yarn_b && a != b) return false;  // self-contact is asked for by a key of its own
        // While the crossing order separates warp from weft, their vertical normals are its own.
        const YarnFamily a_is = mesh.yarns[yarn_a].family, b_is = mesh.yarns[yarn_b].family;
        return !separates || a_is == b_is || a_is == YarnFamily::free || b_is == YarnFamily::free;
      };
    auto effect = std::make_unique<Contact>(field, law, transverse_moduli(scene, assembly));
    effect->set_history(from.contact_history, from.contact_tractions);
    contact = effect.get();
    effects.push_back(std::move(effect));
  }
  if (stage.separate_yarns) {
    constexpr double reach = 2;  // R_a + R_b in units of the mean radius
    const auto target = c.adapt_penalty ? std::optional(over_target * c.target_penetration) : std::nullopt;
    const CrossingOrder::Settings settings{.start_depth = -assembly.flat_height / reach,
                                           .penalty = c.penalty * reach,
                                           .p_reg = c.regularisation,
                                           .target_penetration = target};
    auto effect = std::make_unique<CrossingOrder>(field, ordered_crossings(assembly), settings);
    crossing_order = effect.get();
    effects.push_back(std::move(effect));
  }
}

/// What holds the ends of fibers to bodies.
std::vector<TieTerm> StageModel::tie_terms(const Assembly& assembly, const Stage& stage) const {
  std::vector<TieTerm> terms;
  // Averages by body, end and kind, in the order of the ties.
  using AverageOf = std::tuple<Index, FiberEnd, TieKind>;
  std::vector<std::pair<AverageOf, TieTerm>> averages;
  const FiberMesh& mesh = assembly.mesh;
  for (const EndTie& tie : assembly.ties) {
    const bool at_start = tie.end == FiberEnd::start;
    const Index mesh_node = at_start ? mesh.first_node[tie.fiber] : mesh.first_node[tie.fiber + 1] - 1;
    const Index node = at_start ? field.element_node(tie.fiber, 0) : field.last_node(tie.fiber);
    const double stiffness = tie_stiffness * mesh.axial_stiffness[tie.fiber] / field.element_length(tie.fiber);
    const double radius = mesh.radius[tie.fiber];
    // References come from the stress-free layout, in which bodies stand unturned at their first positions.
    const FiberConfiguration& reference = assembly.configuration;
    const Vec3 x = reference.r[mesh_node] - assembly.body_positions[tie.body], axis = reference.tangent[mesh_node];
    TieTerm point{.body = tie.body, .members = {{node, 0}}, .reference = x, .stiffness = stiffness};
    const TieKind kind = matches(stage.sliding_ends, assembly.body_names[tie.body]) ? TieKind::sliding : tie.kind;
    if (kind != TieKind::clamped) {
      const Mat3 along = axis * axis.transpose(), across = Mat3::Identity() - along;
      const bool slides = kind == TieKind::sliding;
      point.projector = slides ? across : along;
      const AverageOf key(tie.body, tie.end, kind);
      auto found = std::find_if(averages.begin(), averages.end(), [&](const auto& a) { return a.first == key; });
      if (found == averages.end()) {
        const Mat3& of_mean = slides ? along : across;
        averages.push_back({key, {.body = tie.body, .members = {}, .projector = of_mean, .stiffness = stiffness}});
        found = averages.end() - 1;
      }
      found->second.members.emplace_back(node, 0);
      found->second.reference += x;
    }
    terms.push_back(point);
    const auto hold = [&](TieTerm::Holds what, int vector, const Vec3& held) {
      terms.push_back({.body = tie.body,
                       .members = {{node, vector}},
                       .holds = what,
                       .reference = held,
                       .stiffness = stiffness * radius * radius});
    };
    if (field.model(tie.fiber) == FiberModel::enriched) {
      // So do sections narrow at the end as elsewhere: what holds them in their shape reaches a radius, not an element.
      hold(TieTerm::Holds::direction, 1, reference.g1[mesh_node].normalized());
      hold(TieTerm::Holds::direction, 2, reference.g2[mesh_node].normalized());
    } else {
      // The length of r' is the stretch at the end, which no clamp holds.
      hold(TieTerm::Holds::direction, 1, axis.normalized());
    }
  }
  for (auto& [key, term] : averages) {
    term.reference /= static_cast<double>(term.members.size());
    terms.push_back(std::move(term));
  }
  return terms;
}

std::vector<LoadTerm> StageModel::load_terms(const StageStart& from) const {
  std::vector<LoadTerm> terms;
  for (Index i = 0; i < static_cast<Index>(drives.size()); ++i)
    if (drives[i].kind == DofDrive::Kind::force)
      terms.push_back({.body = i / n_body_dofs,
                       .dof = static_cast<BodyDof>(i % n_body_dofs),
                       .start = from.body_forces[i],
                       .end = drives[i].value,
                       .amplitude = drives[i].amplitude});
  return terms;
}

/// What acts on bodies, as far as there is any of it.
void StageModel::add_bodies(const Assembly& assembly, const Stage& stage, const StageStart& from) {
  if (bodies.n_bodies() == 0) return;
  const auto add = [&](auto& known_as, auto effect) {
    known_as = effect.get();
    effects.push_back(std::move(effect));
  };
  if (auto terms = tie_terms(assembly, stage); !terms.empty())
    add(ties, std::make_unique<Ties>(layout, bodies, std::move(terms)));
  if (!follow_terms_.empty()) add(follow, std::make_unique<Follow>(bodies, std::move(follow_terms_)));
  if (auto terms = load_terms(from); !terms.empty()) add(loads, std::make_unique<BodyLoads>(bodies, std::move(terms)));
}

void StageModel::add_fiber_loads(const Scene& scene, const Assembly& assembly, const Stage& stage,
                                 const StageStart& from) {
  const std::vector<LoadThroughStage> through = loads_through(scene, assembly, stage, from.loads);
  standing_loads = standing_after(through);
  std::vector<FiberLoadTerm> terms = fiber_load_terms(through);
  if (terms.empty()) return;
  auto effect = std::make_unique<FiberLoads>(field, std::move(terms));
  fiber_loads = effect.get();
  effects.push_back(std::move(effect));
}

double StageModel::next_turn(double time) const {
  constexpr double here = 1e-9;
  double next = 1;
  const auto look_at = [&](const Amplitude& amplitude) {
    for (const Amplitude::Point& point : amplitude.points)
      if (point.time > time + here) next = std::min(next, point.time);
  };
  for (const DofDrive& drive : drives) look_at(drive.amplitude);
  for (const FiberLoadTerm& term : fiber_loads ? fiber_loads->terms() : std::vector<FiberLoadTerm>())
    look_at(term.amplitude);
  return next;
}

PrescribedMotion StageModel::motion(const State& state, double from, double to) const {
  PrescribedMotion m;
  m.fixed.assign(layout.n_dofs(), 0);
  m.motion.assign(layout.n_dofs(), 0);
  for (Index i = 0; i < static_cast<Index>(drives.size()); ++i) {
    const DofDrive& drive = drives[i];
    if (drive.kind == DofDrive::Kind::force || drive.kind == DofDrive::Kind::follow) continue;
    m.fixed[i] = 1;
    const Index body = i / n_body_dofs;
    const int axis = i % n_body_dofs;
    const auto place = [&](const State& at) { return bodies.in_dofs(body, bodies.pose(at, body).position)[axis]; };
    // Positions aim at their place at the end of the step, so that errors do not add up; rotations advance by their
    // share.
    if (axis < 3)
      m.motion[i] = place(start) + drive.amplitude.at(to) * drive.value - place(state);
    else
      m.motion[i] = (drive.amplitude.at(to) - drive.amplitude.at(from)) * drive.value;
  }
  return m;
}

std::pair<Vec3, Vec3> StageModel::pull(const State& state, Index body) const {
  if (is_period(body)) return {period_force(state, body), Vec3::Zero()};
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  const auto add = [&](const std::pair<Vec3, Vec3>& more) {
    force += more.first;
    moment += more.second;
  };
  if (ties) add(ties->pull(state, body));
  if (follow) add(follow->pull(state, body));
  if (surface_contact) add(surface_contact->pull(state, body));
  return {force, moment};
}

/// The gradient by the period of all but the loads.
Vec3 StageModel::period_force(const State& state, Index body) const {
  std::vector<double> force(layout.n_dofs(), 0.0), magnitude(layout.n_vectors(), 0.0);
  const Index node = bodies.node(body);
  Assembler assembler(layout, nullptr, node, node + 1, force.data(), magnitude.data(), nullptr,
                      Assembler::Tangent::none);
  for (const auto& effect : effects)
    if (effect.get() != loads) effect->add(state, assembler);
  return Eigen::Map<const Vec3>(force.data() + layout.first_dof(node));
}

std::vector<double> StageModel::body_forces(const State& state) const {
  std::vector<double> forces;
  for (Index b = 0; b < bodies.n_bodies(); ++b) {
    const auto [force, moment] = pull(state, b);
    for (const Vec3& v : {bodies.force_in_dofs(b, force), bodies.force_in_dofs(b, moment)})
      forces.insert(forces.end(), v.data(), v.data() + 3);
  }
  return forces;
}

std::vector<double> StageModel::loads_at_start(const StageStart& from) const {
  std::vector<double> loads = body_forces(start);
  for (const FollowTerm& term : follow ? follow->outermost_first() : std::vector<FollowTerm>()) {
    const Vec3 force =
        loads[bodies.dof(term.follower, static_cast<BodyDof>(term.axis))] * bodies.unit_force(term.follower, term.axis);
    const Vec3 moment = (term.follower_start - term.leader_start.position).cross(force);
    for (int d = 0; d < 3; ++d) {
      loads[n_body_dofs * term.leader + d] += bodies.force_in_dofs(term.leader, force)[d];
      loads[n_body_dofs * term.leader + 3 + d] += bodies.force_in_dofs(term.leader, moment)[d];
    }
  }
  for (std::size_t i = 0; i < drives.size(); ++i)
    if (drives[i].kind == DofDrive::Kind::force) loads[i] = from.body_forces[i];
  return loads;
}

Index StageModel::n_contact_elements() const {
  return static_cast<Index>((contact ? contact->elements().size() : 0) +
                            (surface_contact ? surface_contact->elements().size() : 0) +
                            (crossing_order ? crossing_order->elements().size() : 0));
}

double StageModel::max_penetration_over_radius() const {
  return std::max(contact ? contact->max_penetration_over_radius() : 0,
                  surface_contact ? surface_contact->max_penetration_over_radius() : 0);
}

std::string StageModel::describe_dof(Index dof) const {
  if (dof < n_body_dofs * bodies.n_bodies()) return "body " + assembly_.body_names[dof / n_body_dofs];
  for (Index f = 0; f < assembly_.mesh.n_fibers(); ++f) {
    const Index first = layout.first_dof(field.element_node(f, 0)), last = layout.first_dof(field.last_node(f) + 1);
    if (dof < first || dof >= last) continue;
    const double share = static_cast<double>(dof - first) / (last - first);
    return field.describe(f, share * assembly_.mesh.length(f));
  }
  return "an unknown place";
}

}  // namespace trame::micro
