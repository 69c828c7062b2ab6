#include "micro/scene/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>
#include <set>
#include <string_view>

#include "micro/core/error.h"
#include "micro/core/text.h"
#include "micro/scene/named_test.h"
#include "micro/scene/stages.h"
#include "micro/scene/tables.h"
#include "micro/scene/test_stages.h"
#include "micro/scene/weave.h"

namespace trame::micro {

namespace {

/// More is no scene, and reading it would take hundreds of times as much memory.
constexpr std::size_t max_scene_bytes = 16'000'000;

const Names tables = {"material", "fiber_type", "yarn",    "fiber",   "bundle", "weave",
                      "body",     "stage",      "effects", "contact", "solver", "test"};

/// The compliance of a transversely isotropic material is positive definite.
void check_stability(const SceneValue& table, const Material& m) {
  const double ratio = m.young_modulus_axial / m.young_modulus_transverse;
  if (m.poisson_ratio_transverse + 2 * m.poisson_ratio_axial * m.poisson_ratio_axial / ratio >= 1)
    table.find("poisson_ratio_transverse")
        ->fail(
            "must be less than 1 - 2 poisson_ratio_axial² young_modulus_transverse / young_modulus_axial, "
            "or the material is unstable");
}

Material read_material(const SceneValue& table) {
  Material material;
  MaterialInput input;
  const auto model = table.find("model");
  const auto model_key = material_keys().front();
  if (!model) table.fail_missing("model", model_key.allowed);
  model_key.read(*model, input);
  if (input.model == MaterialModel::isotropic) {
    IsotropicInput isotropic;
    read_table(table, isotropic_keys(), {"model"}, isotropic);
    const double e = isotropic.young_modulus, nu = isotropic.poisson_ratio;
    material = {"", e, e, e / (2 * (1 + nu)), nu, nu, isotropic.density};
  } else {
    read_table(table, transversely_isotropic_keys(), {"model"}, material);
    check_stability(table, material);
  }
  material.name = table.table_name();
  return material;
}

template <class T>
NameTable names_of(const std::vector<T>& things) {
  NameTable names;
  for (const T& thing : things) names.add(thing.name);
  return names;
}

FiberType read_fiber_type(const SceneValue& table, const std::vector<Key<FiberTypeInput>>& keys,
                          const std::vector<Material>& materials) {
  FiberTypeInput input;
  read_table(table, keys, {}, input);
  FiberType& type = input.type;
  type.name = table.table_name();
  if (input.diameter.has_value() == input.linear_density.has_value())
    table.fail("must have either \"diameter\" or \"linear_density\"");
  if (input.diameter) {
    type.radius = *input.diameter / 2;
    return type;
  }
  const SceneValue value = *table.find("linear_density");
  type.radius = std::sqrt(*input.linear_density / known_density(value, materials[type.material]) / std::numbers::pi);
  if (2 * type.radius < length.smallest)
    value.fail(fmt::format("a diameter of {:g} m; must be at least {:g} m", 2 * type.radius, length.smallest));
  return type;
}

void read_types(const SceneValue& root, Scene& scene) {
  if (const auto materials = root.find("material"))
    for (const SceneValue& table : materials->children()) scene.materials.push_back(read_material(table));
  const auto keys = fiber_type_keys(names_of(scene.materials));
  if (const auto types = root.find("fiber_type"))
    for (const SceneValue& table : types->children())
      scene.fiber_types.push_back(read_fiber_type(table, keys, scene.materials));
}

void check_points(const SceneValue& table, const std::vector<Vec3>& points) {
  const SceneValue value = *table.find("points");
  constexpr std::size_t most = 1000;  // the spline through them solves with a full matrix
  if (points.size() < 2 || points.size() > most)
    value.fail(fmt::format("must be a list of at least two points, and at most {}", most));
  for (std::size_t i = 1; i < points.size(); ++i)
    if (points[i] == points[i - 1]) value.fail(fmt::format("points {} and {} must not coincide", i, i + 1));
}

void read_fibers(const SceneValue& root, Scene& scene, NameTable& known) {
  const auto fibers = root.find("fiber");
  if (!fibers) return;
  const auto keys = fiber_keys(names_of(scene.fiber_types));
  for (const SceneValue& table : fibers->tables()) {
    FiberSpec& fiber = scene.fibers.emplace_back();
    read_table(table, keys, {}, fiber);
    add_new_name(*table.find("name"), fiber.name, known);
    check_points(table, fiber.points);
    if (!fiber.section_axis) continue;
    if (fiber.section_axis->cross(fiber.points[1] - fiber.points[0]).norm() <=
        1e-6 * fiber.section_axis->norm() * (fiber.points[1] - fiber.points[0]).norm())
      table.find("section_axis")->fail("must not be zero or along the fiber");
  }
}

void read_bundles(const SceneValue& root, Scene& scene, NameTable& known) {
  const auto bundles = root.find("bundle");
  if (!bundles) return;
  const auto keys = bundle_keys(names_of(scene.fiber_types));
  for (const SceneValue& table : bundles->tables()) {
    BundleSpec& bundle = scene.bundles.emplace_back();
    read_table(table, keys, {}, bundle);
    add_new_name(*table.find("name"), bundle.name, known);
    check_points(table, bundle.points);
    if (bundle.n_layers > bundle.n_fibers) table.find("layers")->fail("must be at most the number of fibers");
  }
}

/// A key of a table that may be absent.
std::optional<SceneValue> find_in(const std::optional<SceneValue>& table, std::string_view name) {
  return table ? table->find(name) : std::nullopt;
}

/// Fails for those of `names` that the table has: they belong to what is off.
void refuse(const std::optional<SceneValue>& table, std::initializer_list<const char*> names,
            const std::string& because) {
  for (const char* name : names)
    if (const auto value = find_in(table, name)) value->fail("has no effect, because " + because);
}

/// The same for keys that ask for something; those that say "false" do not.
void refuse_asked(const std::optional<SceneValue>& table, std::initializer_list<const char*> names,
                  const std::string& because) {
  for (const char* name : names)
    if (const auto value = find_in(table, name); value && value->boolean()) refuse(table, {name}, because);
}

void read_effects(const SceneValue& root, Scene& scene) {
  ContactSettings& contact = scene.contact;
  const auto effects = root.find("effects"), settings = root.find("contact"), solver = root.find("solver");
  if (effects) read_table(*effects, effect_keys(), {}, scene);
  for (const SceneValue& key : effects ? effects->children() : std::vector<SceneValue>())
    scene.stated_effects.push_back(key.own_name());
  // Surfaces are touched all the same.
  const bool touches_nothing = contact.scope == ContactScope::none && !has_surfaces(scene);
  const std::string because = "effects.contact is \"none\"";
  if (contact.scope == ContactScope::none) refuse_asked(effects, {"self_contact"}, because);
  if (touches_nothing) {
    refuse_asked(effects, {"friction", "adapt_penalty"}, because);
    refuse(solver, {"max_geometry_updates", "geometry_tolerance"}, because);
    contact.self_contact = contact.friction = contact.adapt_penalty = false;
  }
  if (settings) read_table(*settings, contact_keys(), {}, contact);
  if (touches_nothing)
    for (const Key<ContactSettings>& key : contact_keys()) refuse(settings, {key.name.c_str()}, because);
  if (!contact.friction) refuse(settings, {"friction_coefficient", "reversible_slip"}, "effects.friction is false");
  if (!contact.adapt_penalty) refuse(settings, {"target_penetration"}, "effects.adapt_penalty is false");
}

/// Friction that every stage switches off was not called for.
void check_friction(const SceneValue& root, const Scene& scene) {
  const auto rubs = [](const Stage& stage) { return stage.friction; };
  if (!scene.contact.friction || scene.stages.empty() || std::any_of(scene.stages.begin(), scene.stages.end(), rubs))
    return;
  const std::string because = "every stage has friction = false";
  refuse_asked(root.find("effects"), {"friction"}, because);
  refuse(root.find("contact"), {"friction_coefficient", "reversible_slip"}, because);
}

/// Whether fibers of a type are enriched beams in any stage.
bool is_ever_enriched(const Scene& scene, Index type) {
  const FiberModel model = scene.fiber_types[type].model;
  const auto enriched = [&](const Stage& s) { return s.fiber_model.value_or(model) == FiberModel::enriched; };
  if (scene.stages.empty()) return model == FiberModel::enriched;
  return std::any_of(scene.stages.begin(), scene.stages.end(), enriched);
}

/// What only enriched beams have is an error without them.
void check_enriched_only(const SceneValue& root, const Scene& scene) {
  const std::vector<Index> types = fiber_types_in_use(scene);
  if (std::none_of(types.begin(), types.end(), [&](Index type) { return is_ever_enriched(scene, type); }))
    refuse_asked(root.find("effects"), {"twist_stretch"}, "no fiber is of the enriched model in any stage");
  if (scene.fibers.empty()) return;
  const std::vector<SceneValue> fibers = root.find("fiber")->tables();
  for (std::size_t i = 0; i < scene.fibers.size(); ++i)
    if (!is_ever_enriched(scene, scene.fibers[i].type))
      refuse(fibers[i], {"section_axis"}, "this fiber is of the enriched model in no stage");
}

/// Nodes are counted in 32 bits, and so are their dofs. Counted in floating point, which cannot overflow here.
void check_size(const SceneValue& root, const Scene& scene) {
  constexpr double most_nodes = 1e8;
  double n_nodes = 0, n_largest = 0;
  std::optional<SceneValue> largest;
  const auto add = [&](const SceneValue& table, double n_fibers, Index n_elements) {
    const double n = n_fibers * (2.0 * n_elements + 1);
    n_nodes += n;
    if (n <= n_largest) return;
    n_largest = n;
    const auto own = table.find(n_fibers > n_elements ? "fibers" : "elements");
    largest = own ? *own : table;  // a yarn system may leave both to the program
  };
  const auto tables_of = [&](const char* list) {
    const auto table = root.find(list);
    return table ? table->tables() : std::vector<SceneValue>();
  };
  const auto fibers = tables_of("fiber"), bundles = tables_of("bundle");
  for (std::size_t i = 0; i < fibers.size(); ++i) add(fibers[i], 1, scene.fibers[i].n_elements);
  for (std::size_t i = 0; i < bundles.size(); ++i)
    add(bundles[i], scene.bundles[i].n_fibers, scene.bundles[i].n_elements);
  if (scene.weave)
    for (const auto& [family, system] : {std::pair{"warp", &scene.weave->warp}, {"weft", &scene.weave->weft}})
      add(*root.find("weave")->find(family), static_cast<double>(system->n_fibers()), system->n_elements);
  if (!largest) root.fail("must have at least one [[fiber]], [[bundle]] or a [weave]");
  if (n_nodes > most_nodes)
    largest->fail(fmt::format("makes {:.3g} of {:.3g} nodes; the scene must have at most {:.0f}", n_largest, n_nodes,
                              most_nodes));
}

/// Fibers of one table: their type and length.
struct FiberKind {
  Index type = 0;
  double length = 0;
};

std::vector<FiberKind> fiber_kinds(const Scene& scene) {
  std::vector<FiberKind> kinds;
  const auto add = [&](Index type, const std::vector<Vec3>& points) {
    double length = 0;
    for (std::size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).stableNorm();
    kinds.push_back({type, length});
  };
  for (const FiberSpec& fiber : scene.fibers) add(fiber.type, fiber.points);
  for (const BundleSpec& bundle : scene.bundles) add(bundle.type, bundle.points);
  if (!scene.weave) return kinds;
  const auto add_yarns = [&](const YarnSystem& yarns, const YarnSystem& across) {
    for (const YarnKind& kind : yarns.kinds) kinds.push_back({kind.type, scene.weave->yarn_length(yarns, across)});
  };
  add_yarns(scene.weave->warp, scene.weave->weft);
  add_yarns(scene.weave->weft, scene.weave->warp);
  return kinds;
}

/// The modulus of a material that is largest, by its key.
SceneValue largest_modulus(const SceneValue& root, const Material& m) {
  const SceneValue table = *root.find("material")->find(m.name);
  if (const auto only = table.find("young_modulus")) return *only;
  const double most = std::max({m.young_modulus_axial, m.young_modulus_transverse, m.shear_modulus_axial});
  return *table.find(most == m.young_modulus_axial        ? "young_modulus_axial"
                     : most == m.young_modulus_transverse ? "young_modulus_transverse"
                                                          : "shear_modulus_axial");
}

/// What double precision can bear. Ties are 10³ times as stiff as their fibers, and know forces to 10⁻¹⁶ of that
/// stiffness times coordinates: about 10⁻¹³ E A of the stiffest fiber. Forces that bend the softest one, E I/L², must
/// not drown in that. Measured for two crossing fibers: contact forces are right to 3·10⁻⁵ at a ratio of 1.4·10¹⁰, to
/// 2·10⁻³ at 1.4·10¹¹, and to 7 % at 1.4·10¹².
void check_stiffness(const SceneValue& root, const Scene& scene) {
  constexpr double bearable = 11;  // decades
  struct Force {
    double force, modulus, radius;  // decades of N, Pa, m; they may be far beyond what a double holds
    Index type;
  };
  std::optional<Force> hard, soft;
  for (const auto& [t, length] : fiber_kinds(scene)) {
    const FiberType& type = scene.fiber_types[t];
    const Material& m = scene.materials[type.material];
    const double r = std::log10(type.radius), slenderness = std::max(0.0, std::log10(length) - r);
    const auto [least, most] = std::minmax({m.young_modulus_axial, m.young_modulus_transverse, m.shear_modulus_axial});
    // All but for π.
    const Force pulled{std::log10(most) + 2 * r, std::log10(most), r, t},
        bent{std::log10(m.young_modulus_axial / 4) + 2 * r - 2 * slenderness, std::log10(m.young_modulus_axial), r, t},
        squeezed{std::log10(least) + 2 * r, std::log10(least), r, t};
    if (!hard || pulled.force > hard->force) hard = pulled;
    for (const Force& force : {bent, squeezed})
      if (!soft || force.force < soft->force) soft = force;
  }
  const double ratio = hard->force - soft->force, excess = ratio - bearable;
  if (!(excess > 0)) return;
  const std::string
      times = ratio < 300 ? fmt::format("{:.1e}", std::pow(10, ratio)) : fmt::format("1e{:.0f}", ratio),
      complaint = fmt::format(
          "E A of fiber_type.{} would be {} times the least force of fiber_type.{} (E I/L^2, L: length; or the softest "
          "modulus times its section), and double precision bears 1e{:.0f}; must be ",
          scene.fiber_types[hard->type].name, times, scene.fiber_types[soft->type].name, bearable);
  // Whichever has the largest share.
  const double by_modulus = hard->modulus - soft->modulus, by_radius = 2 * (hard->radius - soft->radius);
  const auto diameter = [&](Index type) {
    const SceneValue table = *root.find("fiber_type")->find(scene.fiber_types[type].name);
    const auto own = table.find("diameter");
    return own ? *own : *table.find("linear_density");
  };
  if (by_modulus >= std::max(by_radius, ratio - by_modulus - by_radius))
    largest_modulus(root, scene.materials[scene.fiber_types[hard->type].material])
        .fail(fmt::format("{}at most {:.2g} Pa", complaint, std::pow(10, hard->modulus - excess)));
  if (by_radius >= ratio - by_modulus - by_radius)
    diameter(hard->type)
        .fail(fmt::format("{}at most {:.2g} m", complaint, 2 * std::pow(10, hard->radius - excess / 2)));
  diameter(soft->type)
      .fail(fmt::format("{}at least {:.2g} m at this length", complaint,
                        2 * std::pow(10, soft->radius + excess / (hard->type == soft->type ? 2 : 4))));
}

/// Lengths of a scene against the radius of its thinnest fiber, loads against its stiffest one: what double precision
/// can bear at once, beside `check_stiffness`.
class Proportions {
 public:
  Proportions(const SceneValue& root, const Scene& scene) : root_(root) {
    for (const Index type : fiber_types_in_use(scene)) {
      const FiberType& t = scene.fiber_types[type];
      const Material& m = scene.materials[t.material];
      smallest_radius_ = std::min(smallest_radius_, t.radius);
      largest_radius_ = std::max(largest_radius_, t.radius);
      for (const double e : {m.young_modulus_axial, m.young_modulus_transverse, m.shear_modulus_axial})
        largest_modulus_ = std::max(largest_modulus_, e);
      largest_density_ = std::max(largest_density_, m.density);
    }
  }

  void check() const {
    for (const char* list : {"fiber", "bundle"})
      if (const auto tables = root_.find(list))
        for (const SceneValue& table : tables->tables()) check_line(table);
    if (const auto weave = root_.find("weave"))
      for (const char* family : {"warp", "weft"})
        for (const char* key : {"yarn_spacing", "margin", "sett"})
          if (const auto value = weave->find(family)->find(key))
            check_length(*value, value->own_name() == "sett" ? 1 / value->quantity(per_length, any())
                                                             : value->quantity(length, any()));
    if (const auto bodies = root_.find("body"))
      for (const SceneValue& table : bodies->tables()) check_body(table);
    if (const auto stages = root_.find("stage"))
      for (const SceneValue& table : stages->tables()) {
        if (const auto drives = table.find("drive"))
          for (const SceneValue& drive : drives->tables()) check_drive(drive);
        if (const auto loads = table.find("load"))
          for (const SceneValue& load : loads->tables()) check_load(load);
      }
  }

 private:
  static constexpr double most_radii = 1e8, least_radii = 1e-5, most_loads = 1e6;

  static double largest(const Vec3& v) { return v.cwiseAbs().maxCoeff(); }

  void check_length(const SceneValue& value, double size) const {
    if (std::abs(size) > most_radii * smallest_radius_)
      value.fail(fmt::format("must be at most {:g} m, {:g} radii of the thinnest fiber", most_radii * smallest_radius_,
                             most_radii));
  }
  void check_line(const SceneValue& table) const {
    const SceneValue points = *table.find("points");
    double along = 0;
    std::optional<Vec3> last;
    for (const SceneValue& entry : points.items("")) {
      const Vec3 point = entry.vector(length);
      check_length(points, largest(point));
      if (last) along += (point - *last).norm();
      last = point;
    }
    const SceneValue elements = *table.find("elements");
    const double of_an_element = along / elements.integer(any());
    if (of_an_element < least_radii * smallest_radius_)
      elements.fail(fmt::format("elements of {:g} m; must be at least {:g} m, {:g} radii", of_an_element,
                                least_radii * smallest_radius_, least_radii));
  }
  void check_body(const SceneValue& body) const {
    if (const auto position = body.find("position")) check_length(*position, largest(position->vector(length)));
    const auto surfaces = body.find("surface");
    for (const SceneValue& surface : surfaces ? surfaces->tables() : std::vector<SceneValue>()) {
      for (const char* key : {"center", "size"})
        if (const auto value = surface.find(key)) check_length(*value, largest(value->vector(length)));
      for (const char* key : {"radius", "length", "unit"})
        if (const auto value = surface.find(key)) check_length(*value, value->quantity(length, any()));
    }
  }
  void check_drive(const SceneValue& drive) const {
    const auto is_text = [](const SceneValue& dof) { return dof.text().starts_with('r'); };
    const auto dof = drive.find("dof");
    const std::vector<SceneValue> dofs = !dof             ? std::vector<SceneValue>()
                                         : dof->is_list() ? dof->items("")
                                                          : std::vector<SceneValue>{*dof};
    const bool turns = drive.find("about") || std::any_of(dofs.begin(), dofs.end(), is_text);
    if (const auto displacement = drive.find("displacement"); displacement && !turns)
      check_length(*displacement, displacement->quantity(length, any()));
    const double most_force = most_loads * largest_modulus_ * largest_radius_ * largest_radius_;
    if (const auto pull = drive.find("force"); pull && !turns && std::abs(pull->quantity(force, any())) > most_force)
      pull->fail(fmt::format("must be at most {:g} N, {:g} E R² of the stiffest fiber", most_force, most_loads));
    const double most_per_width = most_loads * largest_modulus_ * largest_radius_;
    if (const auto pull = drive.find("force_per_width");
        pull && std::abs(pull->quantity(force_per_length, any())) > most_per_width)
      pull->fail(fmt::format("must be at most {:g} N/m, {:g} E R of the stiffest fiber", most_per_width, most_loads));
    const double most_moment = most_loads * largest_modulus_ * std::pow(largest_radius_, 3);
    if (const auto turn = drive.find("force"); turn && turns && std::abs(turn->quantity(moment, any())) > most_moment)
      turn->fail(fmt::format("must be at most {:g} N m, {:g} E R³ of the stiffest fiber", most_moment, most_loads));
    constexpr double most_strain = 1e3;
    if (const auto strain = drive.find("strain"); strain && std::abs(strain->quantity(ratio, any())) > most_strain)
      strain->fail(fmt::format("must be at most {:g}", most_strain));
  }
  void check_load(const SceneValue& load) const {
    const double most = most_loads * largest_modulus_ * largest_radius_;
    if (const auto given = load.find("force_per_length"); given && largest(given->vector(force_per_length)) > most)
      given->fail(fmt::format("must be at most {:g} N/m, {:g} E R of the stiffest fiber", most, most_loads));
    const double mass_per_length = std::numbers::pi * largest_density_ * largest_radius_ * largest_radius_;
    if (const auto given = load.find("gravity"); given && largest(given->vector(acceleration)) * mass_per_length > most)
      given->fail(fmt::format("must be at most {:g} m/s2: a weight per length of {:g} E R of the stiffest fiber",
                              most / mass_per_length, most_loads));
  }

  const SceneValue& root_;
  double smallest_radius_ = std::numeric_limits<double>::infinity(), largest_radius_ = 0, largest_modulus_ = 0,
         largest_density_ = 0;
};

Scene read_root(const SceneValue& root, const std::filesystem::path& folder) {
  Scene scene;
  read_table(root, scene_keys(), tables, scene);
  read_types(root, scene);
  const std::vector<YarnKind> yarn_kinds = read_yarn_kinds(root, scene);
  if (const auto weave = root.find("weave")) scene.weave = read_weave(*weave, scene, yarn_kinds, folder);
  NameTable known(scene.weave ? yarn_names(*scene.weave) : Names());
  read_fibers(root, scene, known);
  read_bundles(root, scene, known);
  if (scene.weave && scene.weave->is_periodic() && !(scene.fibers.empty() && scene.bundles.empty()))
    root.find("weave")
        ->find("periodic")
        ->fail("must not stand beside a [[fiber]] or [[bundle]], which has no next cell");
  check_size(root, scene);
  check_stiffness(root, scene);
  read_bodies(root, folder, scene);
  const std::optional<NamedTest> test = read_test(root, scene);
  if (test) add_test_bodies(root, *test, scene);
  read_effects(root, scene);
  read_stages(root, scene);
  if (test) add_test_stage(root, *test, scene);
  check_increments(root, scene);
  check_surfaces(root, scene);
  check_friction(root, scene);
  check_enriched_only(root, scene);
  if (const auto solver = root.find("solver")) read_table(*solver, solver_keys(), {}, scene.solver);
  if (scene.solver.preconditioner == Preconditioner::two_level && scene.weave && scene.weave->is_periodic())
    root.find("solver")->find("preconditioner")->fail("is for fibers with two ends, but the weave is periodic");
  Proportions(root, scene).check();
  return scene;
}

}  // namespace

std::vector<Index> fiber_types_in_use(const Scene& scene) {
  std::set<Index> types;
  if (scene.weave)
    for (const YarnSystem* yarns : {&scene.weave->warp, &scene.weave->weft})
      for (const YarnKind& kind : yarns->kinds) types.insert(kind.type);
  for (const FiberSpec& fiber : scene.fibers) types.insert(fiber.type);
  for (const BundleSpec& bundle : scene.bundles) types.insert(bundle.type);
  return {types.begin(), types.end()};
}

namespace {

/// A key of tens of thousands of parts would make tables within tables until the stack is full.
void check_key_depth(const std::string& toml, const std::string& origin) {
  constexpr int most_parts = 16;  // ours have 3
  constexpr std::string_view key_ends = "\n=,{}[]";
  int n_dots = 0;
  std::size_t line = 1;
  for (std::size_t i = 0; i < toml.size(); ++i) {
    const char c = toml[i];
    if (c == '#') {
      i = std::min(toml.find('\n', i), toml.size()) - 1;
    } else if (c == '"' || c == '\'') {
      const std::string quotes = toml.compare(i, 3, std::string(3, c)) == 0 ? std::string(3, c) : std::string(1, c);
      std::size_t end = i + quotes.size();
      while (end < toml.size() && toml.compare(end, quotes.size(), quotes) != 0 &&
             (quotes.size() == 3 || toml[end] != '\n'))
        end += c == '"' && toml[end] == '\\' ? 2 : 1;
      line += static_cast<std::size_t>(
          std::count(toml.begin() + static_cast<std::ptrdiff_t>(i),
                     toml.begin() + static_cast<std::ptrdiff_t>(std::min(end, toml.size())), '\n'));
      i = toml.compare(end < toml.size() ? end : toml.size(), quotes.size(), quotes) == 0 ? end + quotes.size() - 1
                                                                                          : end - 1;
    } else if (c == '.') {
      if (++n_dots >= most_parts)
        throw InputError(fmt::format("{}: line {}: a key of more than {} parts; those of a scene have at most 3",
                                     origin, line, most_parts));
    } else if (key_ends.find(c) != key_ends.npos) {
      n_dots = 0;
      line += c == '\n' ? 1 : 0;
    }
  }
}

/// TOML has no control characters but tabs and ends of lines; the library is not sure of itself where it meets them.
void check_control_characters(const std::string& toml, const std::string& origin) {
  const auto bad = std::find_if(toml.begin(), toml.end(), [](unsigned char c) {
    return (c < 0x20 && c != '\t' && c != '\n' && c != '\r') || c == 0x7f;
  });
  if (bad != toml.end())
    throw InputError(fmt::format("{}: line {}: a control character, \"{}\"", origin,
                                 1 + std::count(toml.begin(), bad, '\n'), printable(std::string(1, *bad))));
}

/// Offset of a place that the library gives by line and by character in it, both from 1.
std::size_t offset_of(const std::string& toml, const toml::source_position& place) {
  std::size_t at = 0;
  for (toml::source_index line = 1; line < place.line; ++line) at = std::min(toml.find('\n', at), toml.size() - 1) + 1;
  for (toml::source_index column = 1; column < place.column && at < toml.size(); ++column)
    for (++at; at < toml.size() && (toml[at] & 0xC0) == 0x80;) ++at;
  return at;
}

/// A key of a file and what stands for it in a text that needs no file.
struct Replacement {
  std::size_t from = 0, to = 0;
  std::string text;
};

void replace_pattern(const std::string& toml, const toml::table& root, const Scene& scene,
                     std::vector<Replacement>& all) {
  const toml::table* weave = root["weave"].as_table();
  if (!weave) return;
  const auto found = weave->find("pattern_file");
  if (found == weave->end()) return;
  const Index first_weft = (*weave)["first_weft"].value_or(Index{1}),
              first_warp = (*weave)["first_warp"].value_or(Index{1});
  all.push_back({offset_of(toml, found->first.source().begin), offset_of(toml, found->second.source().end),
                 picture_instead(*found->second.value<std::string>(), *scene.weave, first_weft, first_warp)});
}

std::string triangles_instead(const TriangleMesh& mesh) {
  const Triangles& read = mesh.triangles();
  std::vector<std::string> points, triangles;
  for (const Vec3& p : read.points) points.push_back(fmt::format("[{}, {}, {}]", p.x(), p.y(), p.z()));
  for (const auto& [a, b, c] : read.corners)
    triangles.push_back(fmt::format("[{}, {}, {}]", points[a], points[b], points[c]));
  return fmt::format("triangles = [{}]", fmt::join(triangles, ", "));
}

void replace_meshes(const std::string& toml, const toml::table& root, const Scene& scene,
                    std::vector<Replacement>& all) {
  const toml::array* bodies = root["body"].as_array();
  for (std::size_t b = 0; bodies && b < bodies->size(); ++b) {
    const toml::array* surfaces = (*bodies->get_as<toml::table>(b))["surface"].as_array();
    for (std::size_t s = 0; surfaces && s < surfaces->size(); ++s) {
      const toml::table* surface = surfaces->get_as<toml::table>(s);
      if (const auto found = surface->find("file"); found != surface->end())
        all.push_back({offset_of(toml, found->first.source().begin), offset_of(toml, found->second.source().end),
                       triangles_instead(*scene.bodies[b].surfaces[s].surface.mesh)});
    }
  }
}

/// The text of a scene with pattern and meshes in place of the names of the files that have them.
std::string with_files_inside(std::string toml, const toml::table& root, const Scene& scene) {
  std::vector<Replacement> all;
  replace_pattern(toml, root, scene, all);
  replace_meshes(toml, root, scene, all);
  std::ranges::sort(all, std::greater<>(), &Replacement::from);
  for (const Replacement& r : all) toml.replace(r.from, r.to - r.from, r.text);
  return toml;
}

}  // namespace

Scene parse_scene(const std::string& toml, const std::string& origin, const std::filesystem::path& folder) {
  if (toml.size() > max_scene_bytes)
    throw InputError(fmt::format("{}: {} bytes; a scene has at most {}", origin, toml.size(), max_scene_bytes));
  check_control_characters(toml, origin);
  check_key_depth(toml, origin);
  toml::table table;
  try {
    table = toml::parse(toml, origin);
  } catch (const toml::parse_error& error) {
    throw InputError(fmt::format("{}: line {}: {}", origin, error.source().begin.line, printable(error.description())));
  }
  const SceneValue root(table, origin);
  Scene scene;
  try {
    scene = read_root(root, folder);
  } catch (const InputError& error) {
    root.fail_for_noted(error.what());
  }
  root.fail_for_noted();
  scene.name = made_name(std::filesystem::path(origin).stem().string());
  scene.text = with_files_inside(toml, table, scene);
  return scene;
}

Scene read_scene(const std::filesystem::path& file) {
  if (std::filesystem::is_directory(file))
    throw InputError(fmt::format("{}: is a folder; must be a scene in TOML", file.string()));
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(fmt::format("{}: cannot be read; must be a scene in TOML", file.string()));
  std::string text(max_scene_bytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  const std::filesystem::path folder = file.parent_path();
  return parse_scene(text, file.filename().string(), folder.empty() ? "." : folder);
}

}  // namespace trame::micro
