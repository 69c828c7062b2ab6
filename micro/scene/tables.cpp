#include "micro/scene/tables.h"

#include "micro/core/error.h"
#include "micro/scene/weave.h"

namespace trame::micro {

namespace {

// Far beyond what any machine runs, and far below what would fill its memory while a scene is only looked at.
constexpr double most_elements = 1e6, most_fibers = 1e6, most_increments = 1e5, most_iterations = 1e4;
constexpr double most_yarns = 1000;  // the pattern is spelled out for each pair of yarns

Kind<FiberModel> fiber_model() {
  return choice<FiberModel>({{"enriched", FiberModel::enriched}, {"rod", FiberModel::rod}});
}

Kind<std::vector<Vec3>> points() { return list(vector(length)); }

template <class T>
Key<T> density_key() {
  return key<T>("density", &T::density, quantity(mass_density, above(0)),
                "mass per volume: what linear densities need, and the weight of a fabric")
      .otherwise("default: not known");
}

}  // namespace

std::vector<Key<Scene>> scene_keys() {
  return {key<Scene>("title", &Scene::title, free_text(), "what the scene shows").otherwise("default: none")};
}

std::vector<Key<MaterialInput>> material_keys() {
  const auto model = choice<MaterialModel>(
      {{"isotropic", MaterialModel::isotropic}, {"transversely_isotropic", MaterialModel::transversely_isotropic}});
  return {key<MaterialInput>("model", &MaterialInput::model, model, "elastic symmetry; decides on the other keys")
              .needed()};
}

std::vector<Key<IsotropicInput>> isotropic_keys() {
  using T = IsotropicInput;
  return {key<T>("young_modulus", &T::young_modulus, quantity(pressure, above(0)), "E").needed(),
          key<T>("poisson_ratio", &T::poisson_ratio, number(inside(-1, 0.5)), "ν").needed(), density_key<T>()};
}

std::vector<Key<Material>> transversely_isotropic_keys() {
  using T = Material;
  const auto modulus = quantity(pressure, above(0));
  return {key<T>("young_modulus_axial", &T::young_modulus_axial, modulus, "E_L, along the fiber").needed(),
          key<T>("young_modulus_transverse", &T::young_modulus_transverse, modulus, "E_T, across the fiber").needed(),
          key<T>("shear_modulus_axial", &T::shear_modulus_axial, modulus, "G_LT").needed(),
          key<T>("poisson_ratio_axial", &T::poisson_ratio_axial, number(inside(-1, 0.5)),
                 "ν_LT, transverse contraction under axial tension")
              .needed(),
          key<T>("poisson_ratio_transverse", &T::poisson_ratio_transverse, number(inside(-1, 1)),
                 "ν_TT, within the section; ν_TT + 2 ν_LT² E_T/E_L must be less than 1")
              .needed(),
          density_key<T>()};
}

std::vector<Key<FiberTypeInput>> fiber_type_keys(const NameTable& materials) {
  using T = FiberTypeInput;
  return {key<T>(
              "material", [](auto& t) -> auto& { return t.type.material; }, reference("a material", materials),
              "[material.NAME]")
              .needed(),
          key<T>("diameter", &T::diameter, quantity(length, above(0)), "of the circular section")
              .otherwise("this or linear_density"),
          key<T>("linear_density", &T::linear_density, quantity(linear_density, above(0)),
                 "of a fiber; with the density of its material it makes the diameter")
              .otherwise("this or diameter"),
          key<T>(
              "model", [](auto& t) -> auto& { return t.type.model; }, fiber_model(),
              "9-dof beam with deformable section, or rod that stretches and bends")};
}

std::vector<Key<FiberSpec>> fiber_keys(const NameTable& fiber_types) {
  using T = FiberSpec;
  return {key<T>("name", &T::name, new_name(), "name of the fiber").needed(),
          key<T>("fiber_type", &T::type, reference("a fiber type", fiber_types), "[fiber_type.NAME]").needed(),
          key<T>("points", &T::points, points(), "at least two; cubic spline through them, free of stress").needed(),
          key<T>("elements", &T::n_elements, integer(between(1, most_elements)), "3-node elements along the fiber")
              .needed(),
          key<T>("section_axis", &T::section_axis, vector(plain_number),
                 "direction of the first section vector at the start")
              .otherwise("default: z, or any where the fiber runs along z")};
}

std::vector<Key<BundleSpec>> bundle_keys(const NameTable& fiber_types) {
  using T = BundleSpec;
  return {
      key<T>("name", &T::name, new_name(), "name of the bundle").needed(),
      key<T>("fiber_type", &T::type, reference("a fiber type", fiber_types), "[fiber_type.NAME]").needed(),
      key<T>("points", &T::points, points(), "at least two; cubic spline of the bundle's axis").needed(),
      key<T>("elements", &T::n_elements, integer(between(1, most_elements)), "3-node elements along each fiber")
          .needed(),
      key<T>("fibers", &T::n_fibers, integer(between(1, most_fibers)), "fibers in the bundle").needed(),
      key<T>("layers", &T::n_layers, integer(between(1, most_fibers)), "fibers stacked through the height, at most all")
          .otherwise("default: as round as it gets"),
      key<T>("lattice_spacing", &T::lattice_spacing, number(between(1, 1000)), "distance of fiber axes, in diameters"),
      key<T>("twist", &T::twist, number(any()), "turns over the length, free of stress")};
}

namespace {

/// Which yarn systems come back to where they start.
Kind<std::array<bool, 2>> periodic_systems() {
  using Systems = std::array<bool, 2>;
  const auto words = choice<Systems>({{"warp", {true, false}}, {"weft", {false, true}}});
  const std::string allowed = "true, false, \"warp\" or \"weft\"";
  const auto read = [words, allowed](const SceneValue& value) {
    if (value.is_boolean()) return Systems{value.boolean(), value.boolean()};
    try {
      return words.read(value);
    } catch (const InputError&) {
      value.fail("must be " + allowed);
    }
  };
  return {allowed, read, [](const Systems&) { return std::string("false"); }};
}

}  // namespace

std::vector<Key<WeaveInput>> weave_keys() {
  using T = WeaveInput;
  const auto pattern = choice<std::string>({{"plain", "plain"}, {"twill", "twill"}, {"satin", "satin"}});
  return {
      key<T>("pattern", &T::pattern, pattern, "named pattern, repeated over the yarns").otherwise("one of the five"),
      key<T>("matrix", &T::matrix, pattern_matrix(),
             "own pattern, repeated over the yarns: a row for each weft yarn, 1 where the warp yarn passes above")
          .otherwise("one of the five"),
      key<T>("picture", &T::picture, pattern_picture(),
             "the same as a picture seen from above, warp yarns running down: X where the warp yarn passes above")
          .otherwise("one of the five"),
      key<T>("pattern_file", &T::pattern_file, free_text(),
             "a weaving draft, WIF 1.1, in the scene's folder or by its path from there; warp yarn 1 of the draft is "
             "warp/1")
          .otherwise("one of the five"),
      key<T>("levels", &T::levels, warp_levels(),
             "of several layers of weft: for each warp yarn of a repeat how many layers it passes above, column by "
             "column of weft; 0: below all, a constant: a stuffer")
          .otherwise("one of the five"),
      key<T>("weft_layers", &T::weft_layers, integer(between(1, 100)),
             "weft yarns above each other, which share a column: weft/1 is the lowest of the first one, weft/2 lies "
             "above it; the weft's sett and spacing are of columns"),
      key<T>("first_warp", &T::first_warp, integer(between(1, 1e6)),
             "warp yarn of the pattern that warp/1 is; the pattern goes on from there and repeats"),
      key<T>("first_weft", &T::first_weft, integer(between(1, 1e6)), "the same for the weft, or its columns"),
      key<T>("repeat", &T::repeat, twill_floats(), "of a twill: floats above and below by turns along a warp yarn"),
      key<T>("harnesses", &T::harnesses, integer(between(5, 1000)), "of a satin: yarns in a repeat"),
      key<T>("step", &T::step, integer(between(2, 1000)),
             "of a satin: from one interlacing to the next; at most harnesses - 2, without a common divisor"),
      key<T>("periodic", &T::periodic, periodic_systems(),
             "yarns leave the cell on one side and come in on the other as themselves: all, or those of one system; "
             "a whole number of repeats, without edges. Bodies cell/warp and cell/weft are the periods"),
      key<T>("angle", &T::angle, crossing_angle(),
             "from the warp, which runs along x, to the weft, counterclockwise: of a braid twice the braid angle. The "
             "bodies of the weave have their x and y along warp and weft; spacings and setts are across the yarns")};
}

namespace {

/// Keys of a kind of yarn, also where a yarn system spells its only kind out.
template <class T>
std::vector<Key<T>> kind_keys(const NameTable& fiber_types) {
  const auto lay = choice<Lay>({{"hexagonal", Lay::hexagonal}, {"random", Lay::random}});
  const auto direction = choice<TwistDirection>({{"S", TwistDirection::s}, {"Z", TwistDirection::z}});
  return {key<T>("fiber_type", &T::type, reference("a fiber type", fiber_types), "[fiber_type.NAME]")
              .otherwise("required, but for a system with an order"),
          key<T>("fibers", &T::n_fibers, integer(between(1, most_fibers)), "fibers in a yarn")
              .otherwise("this or linear_density"),
          key<T>("linear_density", &T::linear_density, quantity(linear_density, above(0)),
                 "of a yarn; with that of its fibers it makes their number")
              .otherwise("this or fibers"),
          key<T>("layers", &T::n_layers, integer(between(1, most_fibers)),
                 "fibers stacked through the flat yarn's height, at most all")
              .otherwise("default: as round as it gets"),
          key<T>("lay", &T::lay, lay, "where fibers stand in the section"),
          key<T>("lattice_spacing", &T::lattice_spacing, number(between(1, 1000)),
                 "distance of fiber axes, in diameters; hexagonal lay"),
          key<T>("volume_fraction", &T::volume_fraction, number(between(0.05, 0.8)),
                 "share of the yarn's outline that fibers fill; random lay")
              .otherwise("required for random lay"),
          key<T>("seed", &T::seed, integer(at_least(0)), "of random lay; each yarn has a lay of its own"),
          key<T>("twist", &T::twist, quantity(per_length, at_least(0)), "turns per length, free of stress"),
          key<T>("twist_direction", &T::twist_direction, direction, "as the diagonal of the letter runs on the yarn")
              .otherwise("required with twist")};
}

}  // namespace

std::vector<Key<YarnKindInput>> yarn_kind_keys(const NameTable& fiber_types) {
  return kind_keys<YarnKindInput>(fiber_types);
}

std::vector<Key<YarnSystemInput>> yarn_system_keys(const NameTable& fiber_types) {
  using T = YarnSystemInput;
  std::vector<Key<T>> keys = {
      key<T>("yarns", &T::n_yarns, integer(between(1, most_yarns)), "number of yarns").needed(),
      key<T>("order", &T::order, free_text(),
             "names of [yarn.NAME] with blanks between them, yarn by yarn and repeated, such as \"A A B\"")
          .otherwise("this, or the keys of one kind of yarn"),
      key<T>("sett", &T::sett, quantity(per_length, above(0)), "yarns per length").otherwise("this or yarn_spacing"),
      key<T>("yarn_spacing", &T::yarn_spacing, quantity(length, above(0)),
             "distance of neighbouring yarn axes (1/sett); neighbours must not overlap")
          .otherwise("this or sett"),
      key<T>("margin", &T::margin, quantity(length, above(0)), "yarn length beyond the outermost crossing yarn's axis")
          .otherwise("default: the spacing of the crossing yarns"),
      key<T>("elements", &T::n_elements, integer(between(1, most_elements)), "3-node elements along each fiber")
          .otherwise("default: 2.5 diameters long, at least 4 between crossing yarns and 10 a turn of twist")};
  for (Key<T>& key : kind_keys<T>(fiber_types)) keys.push_back(std::move(key));
  return keys;
}

std::vector<Key<BodySpec>> body_keys() {
  using T = BodySpec;
  return {key<T>("name", &T::name, new_name(), "name of the body").needed(),
          key<T>("position", &T::position, vector(length), "point about which it turns and where its force acts")};
}

std::vector<Key<Tie>> tie_keys(const NameTable& fibers_and_yarns) {
  using T = Tie;
  const auto end = choice<FiberEnd>({{"start", FiberEnd::start}, {"end", FiberEnd::end}});
  const auto kind =
      choice<TieKind>({{"clamped", TieKind::clamped}, {"average", TieKind::average}, {"sliding", TieKind::sliding}});
  return {key<T>("fibers", &T::fibers, wildcard("a fiber, bundle or yarn", fibers_and_yarns), "whose ends are tied")
              .needed(),
          key<T>("end", &T::end, end, "which ends").needed(),
          key<T>("kind", &T::kind, kind,
                 "each fiber's position and section, or means that let fibers rearrange, or slide")};
}

std::vector<Key<SurfaceInput>> surface_keys() {
  using T = SurfaceInput;
  const auto shape = choice<SurfaceShape>({{"plane", SurfaceShape::plane},
                                           {"cylinder", SurfaceShape::cylinder},
                                           {"sphere", SurfaceShape::sphere},
                                           {"box", SurfaceShape::box},
                                           {"mesh", SurfaceShape::mesh}});
  return {key<T>(
              "shape", [](T& t) -> SurfaceShape& { return t.surface.surface.shape; }, shape, "what it is")
              .needed(),
          key<T>("center", &T::center, vector(length), "its middle, a point of a plane, the origin of a mesh")
              .otherwise("default: the position of the body"),
          key<T>("normal", &T::normal, vector(plain_number), "plane: towards the side on which fibers are")
              .otherwise("needed there"),
          key<T>("axis", &T::axis, vector(plain_number), "cylinder: its direction").otherwise("needed there"),
          key<T>("radius", &T::radius, quantity(length, above(0)), "cylinder, sphere").otherwise("needed there"),
          key<T>("length", &T::length, quantity(length, above(0)), "cylinder: between the centres of its rounded ends")
              .otherwise("default: without end"),
          key<T>("size", &T::size, vector(length), "box: its edges along x, y and z").otherwise("needed there"),
          key<T>(
              "inside", [](T& t) -> bool& { return t.surface.surface.inside; }, boolean(),
              "cylinder, sphere, mesh: fibers are inside of it"),
          key<T>("file", &T::file, free_text(), "mesh: STL, OBJ, OFF or PLY with a closed surface of triangles")
              .otherwise("or its triangles"),
          key<T>("triangles", &T::triangles, list(list(vector(plain_number))), "mesh: three corners each")
              .otherwise("or a file"),
          key<T>("unit", &T::unit, quantity(length, above(0)), "mesh: what 1 in its coordinates stands for")
              .otherwise("needed there"),
          key<T>(
              "friction_coefficient", [](T& t) -> std::optional<double>& { return t.surface.friction_coefficient; },
              number(between(0, 10)), "between it and fibers")
              .otherwise("default: that of [contact]"),
          key<T>(
              "from_stage", [](T& t) -> std::string& { return t.surface.from_stage; }, free_text(),
              "name of the first stage in which it is there")
              .otherwise("default: the first one"),
          key<T>(
              "touch", [](T& t) -> bool& { return t.surface.touches; }, boolean(),
              "plane: as that stage begins, its body is moved along the normal until it touches a fiber")};
}

std::vector<Key<Stage>> stage_keys() {
  using T = Stage;
  return {
      key<T>("name", &T::name, stage_name(), "name of the stage").needed(),
      key<T>("increments", &T::n_increments, integer(between(1, most_increments)),
             "wanted; they are cut where they fail"),
      key<T>("separate_yarns", &T::separate_yarns, boolean(), "impose the crossing order of the weave"),
      key<T>("friction", &T::friction, boolean(), "friction in this stage").otherwise("default: as in [effects]"),
      key<T>("proximal_start", &T::proximal_start, number(at_least(0)), "damping at the start, in E A / L per node"),
      key<T>("proximal_end", &T::proximal_end, number(at_least(0)), "damping at the end"),
      key<T>("fiber_model", &T::fiber_model, fiber_model(), "model of every fiber in this stage")
          .otherwise("default: as in [fiber_type.NAME]"),
      key<T>("save_every", &T::save_every, integer(between(1, most_increments)),
             "increments from one saved state to the next")};
}

std::vector<Key<DriveInput>> drive_keys(const NameTable& bodies) {
  using T = DriveInput;
  NamedValues<BodyDof> dofs;
  for (std::size_t d = 0; d < dof_names.size(); ++d) dofs.emplace_back(dof_names[d], static_cast<BodyDof>(d));
  const auto either = [](const Measure& translation, const Measure& rotation) {
    return allowed_quantity(translation, any()) + "; for rotations " + allowed_quantity(rotation, any());
  };
  return {
      key<T>("bodies", &T::bodies, list(wildcard("a body", bodies), true), "what is driven").needed(),
      key<T>("dof", &T::dofs, list(choice(dofs), true), "along or about which axis").otherwise("this, along or about"),
      key<T>("along", &T::along, vector(plain_number),
             "direction of a displacement or force, of any length: drives x, y and z together")
          .otherwise("this, dof or about"),
      key<T>("about", &T::about, vector(plain_number), "axis of a rotation or moment: drives rx, ry and rz together")
          .otherwise("this, dof or along"),
      key<T>("displacement", &T::displacement, unread(either(length, angle)),
             "reached at the end, from the stage's start")
          .otherwise("one of the five"),
      key<T>("force", &T::force, unread(either(force, moment)), "reached at the end, from the reaction at the start")
          .otherwise("one of the five"),
      key<T>("strain", &T::strain, quantity(ratio, any()),
             "displacement over the body's coordinate at the stage's start; translations only; of a period, over its "
             "length")
          .otherwise("one of the five"),
      key<T>("force_per_width", &T::force_per_width, quantity(force_per_length, any()),
             "of a period: force over the width of the laid out cell, as force")
          .otherwise("one of the five"),
      key<T>("follow", &T::follow, existing_name("a body", bodies), "moves rigidly with it; translations only")
          .otherwise("one of the five"),
      key<T>("amplitude", &T::amplitude, unread("a list of [stage time, share of the value]"),
             "straight from point to point, from [0, 0] to stage time 1; increments end at its points; not for follow")
          .otherwise("default: [[1, 1]], a ramp")};
}

std::vector<Key<LoadInput>> load_keys(const NameTable& fibers_and_yarns) {
  using T = LoadInput;
  return {
      key<T>("name", &T::name, new_name(), "it stays on until a later stage has a load of the same name")
          .otherwise("default: \"force_per_length\" or \"gravity\""),
      key<T>("fibers", &T::fibers, list(wildcard("a fiber, bundle or yarn", fibers_and_yarns), true), "what is loaded")
          .otherwise("default: all"),
      key<T>("force_per_length", &T::force_per_length, vector(force_per_length),
             "of the start configuration; reached at the end, from what it was at the start; it does not turn with a "
             "fiber")
          .otherwise("this or gravity"),
      key<T>("gravity", &T::gravity, vector(acceleration),
             "the same for weight: force per length over the density and section of each fiber")
          .otherwise("this or force_per_length"),
      key<T>("amplitude", &T::amplitude, unread("a list of [stage time, share of the way to the value]"),
             "straight from point to point, from [0, 0] to stage time 1; increments end at its points")
          .otherwise("default: [[1, 1]], a ramp")};
}

std::vector<Key<Scene>> effect_keys() {
  const auto scope = choice<ContactScope>(
      {{"all", ContactScope::all}, {"between_yarns", ContactScope::between_yarns}, {"none", ContactScope::none}});
  return {
      key<Scene>(
          "contact", [](auto& s) -> auto& { return s.contact.scope; }, scope, "between which fibers"),
      key<Scene>(
          "self_contact", [](auto& s) -> auto& { return s.contact.self_contact; }, boolean(),
          "of a fiber with itself; needs contact"),
      key<Scene>(
          "friction", [](auto& s) -> auto& { return s.contact.friction; }, boolean(), "Coulomb friction; needs contact")
          .otherwise("default: true with contact"),
      key<Scene>(
          "adapt_penalty", [](auto& s) -> auto& { return s.contact.adapt_penalty; }, boolean(),
          "contact stiffness follows the target penetration; needs contact")
          .otherwise("default: true with contact"),
      key<Scene>("twist_stretch", &Scene::twist_stretch, boolean(),
                 "a twisted fiber shortens; needs fibers of the enriched model")};
}

std::vector<Key<ContactSettings>> contact_keys() {
  using T = ContactSettings;
  return {key<T>("friction_coefficient", &T::friction_coefficient, number(at_least(0)), "µ; needs friction"),
          key<T>("reversible_slip", &T::reversible_slip, number(above(0)), "before sliding, in radii; needs friction"),
          key<T>("spacing", &T::spacing, number(between(0.01, 1000)),
                 "of contact elements along fibers, in element lengths"),
          key<T>("search_margin", &T::search_margin, number(above_up_to(0, 1000)),
                 "gap up to which contact is looked for, in radii"),
          key<T>("target_penetration", &T::target_penetration, number(inside(0, 1)), "in radii; needs adapt_penalty"),
          key<T>("regularisation", &T::regularisation, number(inside(0, 1)),
                 "penetration at which the quadratic penalty turns linear, in radii"),
          key<T>("penalty", &T::penalty, number(above(0)),
                 "starting stiffness per length, in transverse moduli of the softer fiber")};
}

std::vector<Key<SolverSettings>> solver_keys() {
  using T = SolverSettings;
  const auto precision = choice<FactorPrecision>({{"auto", FactorPrecision::automatic},
                                                  {"single", FactorPrecision::single_precision},
                                                  {"double", FactorPrecision::double_precision}});
  const auto preconditioner = choice<Preconditioner>({{"auto", Preconditioner::automatic},
                                                      {"factor", Preconditioner::factor},
                                                      {"two_level", Preconditioner::two_level}});
  return {
      key<T>("force_tolerance", &T::force_tolerance, number(inside(0, 1)),
             "residual over the forces that fibers get from outside: contact, friction, bodies, loads"),
      key<T>("max_newton_iterations", &T::max_newton_iterations, integer(between(1, most_iterations)),
             "between contact detections"),
      key<T>("max_geometry_updates", &T::max_geometry_updates, integer(between(1, most_iterations)),
             "times that contacts found anew may undo an equilibrium, in an increment; needs contact"),
      key<T>("geometry_tolerance", &T::geometry_tolerance, number(above_up_to(0, 1)),
             "of scenes for earlier versions, which had two tolerances: the smaller one counts; needs contact"),
      key<T>("step_cap", &T::step_cap, number(above(0)),
             "largest motion in an iteration, in radii of the thinnest fiber"),
      key<T>("min_increment", &T::min_increment, number(above_up_to(0, 1)),
             "smallest part of a stage before the solver gives up"),
      key<T>(
          "factor_precision", &T::factor_precision, precision,
          "of the matrix factor; single takes half the memory and half of the time; auto takes it for large factors, "
          "and double where it fails"),
      key<T>("preconditioner", &T::preconditioner, preconditioner,
             "of conjugate gradients: the matrix factor, or two levels for enriched beams, which take less memory and, "
             "of many fibers, less time; auto takes what costs less")};
}

double known_density(const SceneValue& value, const Material& material) {
  if (material.density == 0) value.fail(fmt::format("needs the density of material.{}", material.name));
  return material.density;
}

}  // namespace trame::micro
