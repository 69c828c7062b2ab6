#include "micro/scene/stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "micro/scene/tables.h"
#include "micro/scene/weave.h"
#include "micro/scene/weaving_stages.h"

namespace trame::micro {

void add_new_name(const SceneValue& named, const std::string& name, NameTable& known) {
  if (!known.add(name)) named.fail(fmt::format("must be a name of its own, but \"{}\" is taken", name));
}

namespace {

/// Everything that a tie can name.
NameTable tieable_names(const Scene& scene) {
  NameTable names;
  for (const std::string& yarn : scene.weave ? yarn_names(*scene.weave) : Names())
    if (!(is_warp(yarn) ? scene.weave->warp : scene.weave->weft).periodic) names.add(yarn);
  for (const FiberSpec& fiber : scene.fibers) names.add(fiber.name);
  for (const BundleSpec& bundle : scene.bundles) names.add(bundle.name);
  return names;
}

}  // namespace

NameTable body_names(const Scene& scene) {
  NameTable names(scene.weave ? weave_body_names(*scene.weave) : Names());
  for (const BodySpec& body : scene.bodies) names.add(body.name);
  return names;
}

namespace {

/// Fails for keys that are of other shapes, and for those that the shape lacks.
void check_shape_keys(const SceneValue& table, SurfaceShape shape) {
  struct Own {
    Names needed, allowed;
  };
  static const std::array<Own, 5> keys = {{{{"normal"}, {"touch"}},
                                           {{"axis", "radius"}, {"length", "inside"}},
                                           {{"radius"}, {"inside"}},
                                           {{"size"}, {}},
                                           {{"unit"}, {"file", "triangles", "inside"}}}};
  const auto& [needed, allowed] = keys[static_cast<std::size_t>(shape)];
  const std::string name = table.find("shape")->text();
  for (const std::string& key : needed)
    if (!table.find(key)) table.fail_missing(key, fmt::format("what a {} needs", name));
  Names own = needed;
  own.insert(own.end(), allowed.begin(), allowed.end());
  for (const char* key : {"normal", "axis", "radius", "length", "size", "inside", "touch", "file", "triangles", "unit"})
    if (const auto value = table.find(key); value && std::find(own.begin(), own.end(), key) == own.end())
      value->fail(fmt::format("is none of a {}; it has {}", name, allowed_names(own)));
}

/// A unit vector.
Vec3 direction(const SceneValue& value, const Vec3& v) {
  if (v.norm() < 1e-9 * (1 + v.cwiseAbs().maxCoeff())) value.fail("must have a direction");
  return v.normalized();
}

std::shared_ptr<const TriangleMesh> read_mesh(const SceneValue& table, const SurfaceInput& input,
                                              const std::filesystem::path& folder) {
  constexpr double farthest = 1e6;  // of a coordinate, in units
  const auto own = table.find("triangles");
  if (own && input.file) own->fail("must not stand beside a file");
  if (!own && !input.file) table.fail_missing("file", "what a mesh needs, or triangles");
  const SceneValue source = own ? *own : *table.find("file");
  try {
    Triangles triangles = own ? joined(input.triangles) : read_triangles(folder / *input.file);
    for (const Vec3& p : triangles.points)
      if (!(p.cwiseAbs().maxCoeff() <= farthest)) source.fail(fmt::format("has a coordinate beyond {:g}", farthest));
    return std::make_shared<const TriangleMesh>(std::move(triangles));
  } catch (const MeshError& error) {
    source.fail(error.what());
  }
}

SurfaceSpec read_surface(const SceneValue& table, const Vec3& position, const std::filesystem::path& folder) {
  SurfaceInput input;
  read_table(table, surface_keys(), {}, input);
  Surface& surface = input.surface.surface;
  check_shape_keys(table, surface.shape);
  if (input.center) surface.center = *input.center - position;
  if (input.normal) surface.direction = direction(*table.find("normal"), *input.normal);
  if (input.axis) surface.direction = direction(*table.find("axis"), *input.axis);
  surface.radius = input.radius.value_or(0);
  surface.half_length = 0.5 * input.length.value_or(0);
  if (input.size) {
    if (input.size->minCoeff() <= 0) table.find("size")->fail("must be three lengths greater than 0");
    surface.half_size = 0.5 * *input.size;
  }
  if (surface.shape == SurfaceShape::mesh) {
    surface.mesh = read_mesh(table, input, folder);
    surface.unit = *input.unit;
  }
  return input.surface;
}

}  // namespace

void read_bodies(const SceneValue& root, const std::filesystem::path& folder, Scene& scene) {
  const auto bodies = root.find("body");
  if (!bodies) return;
  const NameTable fibers = tieable_names(scene);
  NameTable known = body_names(scene);
  const auto body_table = body_keys();
  const auto tie_table = tie_keys(fibers);
  std::set<std::pair<Index, FiberEnd>> tied;
  for (const SceneValue& table : bodies->tables()) {
    BodySpec body;
    read_table(table, body_table, {"tie", "surface"}, body);
    add_new_name(*table.find("name"), body.name, known);
    const auto ties = table.find("tie");
    for (const SceneValue& entry : ties ? ties->tables() : std::vector<SceneValue>()) {
      Tie& tie = body.ties.emplace_back();
      read_table(entry, tie_table, {}, tie);
      for (const Index fiber : fibers.fitting(tie.fibers))
        if (!tied.emplace(fiber, tie.end).second)
          entry.find("fibers")->fail(fmt::format("this end of \"{}\" must not be tied twice", fibers.names()[fiber]));
    }
    const auto surfaces = table.find("surface");
    for (const SceneValue& entry : surfaces ? surfaces->tables() : std::vector<SceneValue>()) {
      body.surfaces.push_back(read_surface(entry, body.position, folder));
      if (body.surfaces.back().touches && !body.ties.empty())
        entry.find("touch")->fail("must be false, because the body ties fiber ends, which would move with it");
    }
    scene.bodies.push_back(std::move(body));
  }
}

bool has_surfaces(const Scene& scene) {
  return std::any_of(scene.bodies.begin(), scene.bodies.end(), [](const BodySpec& b) { return !b.surfaces.empty(); });
}

std::size_t stage_number(const Scene& scene, const std::string& name) {
  const auto found =
      std::find_if(scene.stages.begin(), scene.stages.end(), [&](const Stage& s) { return s.name == name; });
  return static_cast<std::size_t>(found - scene.stages.begin());
}

std::size_t first_stage(const Scene& scene, const SurfaceSpec& surface) {
  return surface.from_stage.empty() ? 0 : stage_number(scene, surface.from_stage);
}

void check_surfaces(const SceneValue& root, const Scene& scene) {
  const auto bodies = root.find("body");
  if (!bodies) return;
  NameTable stages;
  for (const Stage& stage : scene.stages) stages.add(stage.name);
  const std::vector<SceneValue> tables = bodies->tables();
  for (std::size_t b = 0; b < tables.size(); ++b) {
    const auto surfaces = tables[b].find("surface");
    if (!surfaces) continue;
    const std::vector<SceneValue> entries = surfaces->tables();
    for (std::size_t i = 0; i < entries.size(); ++i) {
      if (const auto stage = entries[i].find("from_stage")) (void)stage->one_of(stages, "a stage");
      const Surface& surface = scene.bodies[b].surfaces[i].surface;
      const bool is_level = surface.shape == SurfaceShape::plane && std::abs(surface.direction.z()) > 1 - 1e-12;
      if (scene.weave && scene.weave->is_periodic() && !is_level)
        entries[i].find("shape")->fail(
            "must be a plane with a normal along z, because the weave is periodic: the surface would meet fibers of "
            "the next cells");
    }
  }
}

namespace {

/// Its points may not be nearer to each other than the increments of the stage: the first of these is not cut for them.
Amplitude read_amplitude(const SceneValue& value, Index n_increments) {
  constexpr std::size_t most = 1000;
  const std::string allowed = "must be a list of [stage time, share], with times that ascend from 0 to 1";
  const std::vector<SceneValue> rows = value.items(allowed);
  if (rows.size() > most) value.fail(fmt::format("{}, of at most {} points", allowed, most));
  Amplitude amplitude;
  double last = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::vector<SceneValue> row = rows[i].items(allowed);
    if (row.size() != 2) rows[i].fail("must be a stage time and a share of the value, such as [0.5, 1]");
    const double time = row[0].quantity(plain_number, between(0, 1)),
                 share = row[1].quantity(plain_number, between(-1000, 1000));
    if (i == 0 && time == 0) {
      if (share != 0) row[1].fail("must be 0 at stage time 0, where it begins");
      continue;
    }
    // A hair less, for times such as 1/3.
    if (time - last < (1 - 1e-9) / n_increments)
      row[0].fail(
          fmt::format("must be at least an increment, {:.6g}, after the one before; the stage has {} increments",
                      1.0 / n_increments, n_increments));
    amplitude.points.push_back({time, share});
    last = time;
  }
  if (last != 1) value.fail("must end at stage time 1");
  return amplitude;
}

/// The one of the four modes that a drive names, read in the measure of the dof.
Drive make_drive(const SceneValue& table, const DriveInput& input, const std::optional<Weave>& weave,
                 const std::string& bodies, BodyDof dof) {
  Drive drive{bodies, dof, DriveMode::displacement, 0, ""};
  const auto translations_only = [&](const char* mode) {
    if (is_rotation(dof))
      table.find(mode)->fail("is for the dofs x, y and z; rotations must have a displacement or a force");
  };
  const int n_modes = input.displacement.has_value() + input.force.has_value() + input.strain.has_value() +
                      input.force_per_width.has_value() + input.follow.has_value();
  if (n_modes != 1)
    table.fail("must have exactly one of \"displacement\", \"force\", \"strain\", \"force_per_width\" and \"follow\"");
  if (input.displacement) {
    drive.value = input.displacement->quantity(displacement_measure(dof), any());
  } else if (input.force) {
    drive.mode = DriveMode::force;
    drive.value = input.force->quantity(force_measure(dof), any());
  } else if (input.strain) {
    translations_only("strain");
    drive.mode = DriveMode::strain;
    drive.value = *input.strain;
  } else if (input.force_per_width) {
    if (!is_period(bodies))
      table.find("force_per_width")
          ->fail("is for the periods of a periodic weave, \"cell/warp\" and \"cell/weft\", by their own names");
    drive.mode = DriveMode::force;
    drive.value = *input.force_per_width * cell_width(*weave, bodies == period_name(true));
  } else {
    translations_only("follow");
    drive.mode = DriveMode::follow;
    drive.leader = *input.follow;
    if (input.amplitude) input.amplitude->fail("has no effect, because the drive follows a body");
  }
  return drive;
}

/// The drives of some bodies that a table asks for, before their amplitude: along axes, or along or about any
/// direction.
std::vector<Drive> make_drives(const SceneValue& table, const DriveInput& input, const std::optional<Weave>& weave,
                               const std::string& bodies) {
  if ((input.dofs.empty() ? 0 : 1) + (input.along ? 1 : 0) + (input.about ? 1 : 0) != 1)
    table.fail("must have exactly one of \"dof\", \"along\" and \"about\"");
  std::vector<Drive> drives;
  for (const BodyDof dof : input.dofs) drives.push_back(make_drive(table, input, weave, bodies, dof));
  if (!input.dofs.empty()) return drives;
  const char* name = input.along ? "along" : "about";
  const Vec3 direction = input.along ? *input.along : *input.about;
  if (direction.isZero(0)) table.find(name)->fail("must not be zero");
  if (input.strain || input.force_per_width || input.follow)
    table.find(name)->fail("is for displacements and forces; strain, force_per_width and follow must have a dof");
  if (weave && weave->is_skew())
    for (const Index body : NameTable(weave_body_names(*weave)).fitting(bodies))
      table.find(name)->fail(
          fmt::format("\"{}\" must have a dof: those of a skew weave's bodies, x and y, are along warp and weft",
                      weave_body_names(*weave)[body]));
  for (int d = 0; d < 3; ++d) {
    drives.push_back(make_drive(table, input, weave, bodies, static_cast<BodyDof>(input.along ? d : d + 3)));
    drives.back().value *= direction.normalized()[d];
  }
  return drives;
}

/// What the drives of a stage read so far do to each body.
struct Driven {
  std::set<std::pair<Index, BodyDof>> dofs;
  std::multimap<Index, Index> leaders;
  std::set<Index> leading;
};

/// Whether `follower` is reached from `leader` along leaders of leaders.
bool leads_back(const Driven& driven, Index follower, Index leader) {
  if (follower != leader && !driven.leading.contains(follower)) return false;
  std::vector<Index> open = {leader};
  std::set<Index> seen;
  while (!open.empty()) {
    const Index body = open.back();
    open.pop_back();
    if (body == follower) return true;
    if (!seen.insert(body).second) continue;
    const auto [first, last] = driven.leaders.equal_range(body);
    for (auto it = first; it != last; ++it) open.push_back(it->second);
  }
  return false;
}

/// Out of its plane and about it a cell does not move: turning it as a whole changes nothing.
void check_period_drive(const SceneValue& table, const Drive& drive, const std::string& period) {
  const bool along = period == period_name(true);
  if (drive.dof == BodyDof::x || (!along && drive.dof == BodyDof::y)) {
    if (drive.mode == DriveMode::follow) table.find("follow")->fail("is not for periods");
    return;
  }
  table.find("bodies")->fail(
      fmt::format("\"{}\" must be driven along {}: the cell stays in its plane, with the warp "
                  "along x",
                  period, along ? "x alone" : "x or y"));
}

void check_drive(const SceneValue& table, const Drive& drive, const NameTable& bodies, Driven& driven) {
  const Index leader = drive.mode == DriveMode::follow ? *bodies.find(drive.leader) : -1;
  if (leader >= 0 && is_period(drive.leader))
    table.find("follow")->fail("must be a body that turns and moves; a period is a vector");
  for (const Index body : bodies.fitting(drive.bodies)) {
    if (is_period(bodies.names()[body])) check_period_drive(table, drive, bodies.names()[body]);
    if (!driven.dofs.emplace(body, drive.dof).second)
      table.find("bodies")->fail(
          fmt::format("a dof of \"{}\" must not be driven twice in a stage", bodies.names()[body]));
    if (drive.mode != DriveMode::follow) continue;
    if (leads_back(driven, body, leader))
      table.find("follow")->fail(fmt::format("\"{}\" must not follow itself", bodies.names()[body]));
    driven.leaders.emplace(body, leader);
    driven.leading.insert(leader);
  }
}

void read_drives(const SceneValue& stage_table, const std::optional<Weave>& weave, const NameTable& bodies,
                 const std::vector<Key<DriveInput>>& keys, Stage& stage) {
  const auto drives = stage_table.find("drive");
  if (!drives) return;
  Driven driven;
  for (const SceneValue& table : drives->tables()) {
    DriveInput input;
    read_table(table, keys, {}, input);
    const Amplitude amplitude = input.amplitude ? read_amplitude(*input.amplitude, stage.n_increments) : Amplitude();
    for (const std::string& pattern : input.bodies)
      for (Drive& drive : make_drives(table, input, weave, pattern)) {
        drive.amplitude = amplitude;
        check_drive(table, drive, bodies, driven);
        stage.drives.push_back(std::move(drive));
      }
  }
}

/// Everything that a load can name, and the material of each.
struct Loadable {
  explicit Loadable(const Scene& scene) {
    const auto add = [&](const std::string& name, Index type) {
      names.add(name);
      materials.push_back(&scene.materials[scene.fiber_types[type].material]);
    };
    const Names yarns = scene.weave ? yarn_names(*scene.weave) : Names();
    for (Index i = 0; i < static_cast<Index>(yarns.size()); ++i) {
      const Index n_warp = scene.weave->warp.n_yarns;
      add(yarns[i], (i < n_warp ? scene.weave->warp.kind_of(i) : scene.weave->weft.kind_of(i - n_warp)).type);
    }
    for (const FiberSpec& fiber : scene.fibers) add(fiber.name, fiber.type);
    for (const BundleSpec& bundle : scene.bundles) add(bundle.name, bundle.type);
  }
  NameTable names;
  std::vector<const Material*> materials;
};

FiberLoad read_load(const SceneValue& table, const std::vector<Key<LoadInput>>& keys, const Loadable& loadable,
                    Index n_increments) {
  LoadInput input;
  read_table(table, keys, {}, input);
  if (input.force_per_length.has_value() == input.gravity.has_value())
    table.fail("must have either \"force_per_length\" or \"gravity\"");
  const char* given_by = input.gravity ? "gravity" : "force_per_length";
  FiberLoad load;
  load.name = input.name.value_or(given_by);
  load.fibers = input.fibers;
  load.kind = input.gravity ? LoadKind::gravity : LoadKind::force_per_length;
  load.value = input.gravity ? *input.gravity : *input.force_per_length;
  if (input.amplitude) load.amplitude = read_amplitude(*input.amplitude, n_increments);
  if (input.gravity)
    for (const std::string& pattern : load.fibers)
      for (const Index named : loadable.names.fitting(pattern))
        (void)known_density(*table.find(given_by), *loadable.materials[named]);
  return load;
}

void read_loads(const SceneValue& stage_table, const Scene& scene, const Loadable& loadable,
                const std::vector<Key<LoadInput>>& keys, Stage& stage) {
  const auto loads = stage_table.find("load");
  if (!loads) return;
  NameTable known;
  for (const SceneValue& table : loads->tables()) {
    if (scene.weave && scene.weave->is_periodic())
      table.fail("must not stand in a scene whose weave is periodic: nothing bears a force on all of a cell");
    FiberLoad load = read_load(table, keys, loadable, stage.n_increments);
    const auto name = table.find("name");
    if (!known.add(load.name))
      (name ? *name : table)
          .fail(fmt::format("must have a name of its own, but \"{}\" is another load of the stage", load.name));
    stage.loads.push_back(std::move(load));
  }
}

/// What a stage asks for must go with the rest of the scene.
void check_stage(const SceneValue& table, const Scene& scene, const Stage& stage) {
  if (stage.separate_yarns && !scene.weave) table.find("separate_yarns")->fail("needs a [weave]");
  if (stage.separate_yarns && scene.contact.scope == ContactScope::none)
    table.find("separate_yarns")
        ->fail("needs contact, or yarns would pass through each other again, but effects.contact is \"none\"");
  if (const auto friction = table.find("friction"); friction && stage.friction && !scene.contact.friction)
    friction->fail("has no effect, because friction is off for the scene");
  if (stage.proximal_end > 0 && stage.proximal_start == 0)
    table.find("proximal_end")->fail("needs a proximal_start greater than 0, because damping changes geometrically");
}

}  // namespace

void read_stages(const SceneValue& root, Scene& scene) {
  const auto stages = root.find("stage");
  if (!stages && scene.weave && scene.contact.scope != ContactScope::none) {
    scene.stages = weaving_stages(scene);
    scene.stages_are_chosen = true;
  }
  if (!stages) return;
  const NameTable bodies = body_names(scene);
  const auto stage_table = stage_keys();
  const auto drive_table = drive_keys(bodies);
  const Loadable loadable(scene);
  const auto load_table = load_keys(loadable.names);
  NameTable known;
  for (const SceneValue& table : stages->tables()) {
    Stage stage;
    read_table(table, stage_table, {"drive", "load"}, stage);
    add_new_name(*table.find("name"), stage.name, known);
    check_stage(table, scene, stage);
    stage.friction = stage.friction && scene.contact.friction;
    read_drives(table, scene.weave, bodies, drive_table, stage);
    read_loads(table, scene, loadable, load_table, stage);
    scene.stages.push_back(std::move(stage));
  }
}

void check_increments(const SceneValue& root, const Scene& scene) {
  constexpr double most = 1e6;  // a run keeps some numbers of each
  const auto list = root.find("stage");
  const std::vector<SceneValue> tables = list ? list->tables() : std::vector<SceneValue>();
  double n = 0;
  for (std::size_t i = 0; i < scene.stages.size(); ++i) {
    n += scene.stages[i].n_increments;
    if (n > most)
      (i < tables.size() ? tables[i] : *root.find("test"))
          .fail(fmt::format("{:.0f} increments up to this stage; must be at most {:.0f}", n, most));
  }
}

}  // namespace trame::micro
