// Quantities, wildcards, weave patterns, and scenes that are right.

#include "micro/scene/scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <set>

#include "micro/core/error.h"
#include "micro/core/name_table.h"
#include "micro/core/quantity.h"
#include "micro/scene/pattern.h"

namespace trame::micro {
namespace {

TEST(Quantity, ConvertsToTheSiUnit) {
  EXPECT_EQ(parse_quantity("19 um", "m"), 19e-6);
  EXPECT_EQ(parse_quantity("19 µm", "m"), 19e-6);
  EXPECT_EQ(parse_quantity(" 19um ", "m"), 19e-6);
  EXPECT_EQ(parse_quantity("0 mm", "m"), 0);
  EXPECT_EQ(parse_quantity("3 GPa", "Pa"), 3e9);
  EXPECT_EQ(parse_quantity("-2.5e-1 N/mm2", "Pa"), -0.25e6);
  EXPECT_EQ(parse_quantity("2 mN", "N"), 2e-3);
  EXPECT_EQ(parse_quantity("4 kg m s-2", "N"), 4);
  EXPECT_DOUBLE_EQ(parse_quantity("0.1 N mm", "N m"), 1e-4);
  EXPECT_EQ(parse_quantity("2 J", "N m"), 2);
  EXPECT_DOUBLE_EQ(parse_quantity("45 deg", "rad"), std::numbers::pi / 4);
  EXPECT_DOUBLE_EQ(parse_quantity("45 °", "rad"), std::numbers::pi / 4);
  EXPECT_EQ(parse_quantity("0.5 rad", "rad"), 0.5);
  EXPECT_EQ(parse_quantity("2 %", "1"), 0.02);
  EXPECT_EQ(parse_quantity("+5 mN", "N"), 5e-3);
  EXPECT_EQ(parse_quantity("19\u00a0um", "m"), 19e-6);
  EXPECT_EQ(parse_quantity("\u202f19\u2009um\u00a0", "m"), 19e-6);
  EXPECT_EQ(parse_quantity("\u22125 mN", "N"), -5e-3);
}

std::string quantity_error(std::string_view text, std::string_view unit) {
  try {
    return "no error, but " + std::to_string(parse_quantity(text, unit));
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(Quantity, KnowsWhatTextilesAreMeasuredIn) {
  EXPECT_DOUBLE_EQ(parse_quantity("78 dtex", "kg m-1"), 7.8e-6);
  EXPECT_DOUBLE_EQ(parse_quantity("200 tex", "kg m-1"), 2e-4);
  EXPECT_NEAR(parse_quantity("70 denier", "kg m-1"), 70e-3 / 9000, 1e-11);
  for (const char* sett : {"37 cm-1", "37 per cm", "37 /cm", "37/cm"})
    EXPECT_DOUBLE_EQ(parse_quantity(sett, "m-1"), 3700);
  EXPECT_DOUBLE_EQ(parse_quantity("94 per inch", "m-1"), 94 / 0.0254);
  EXPECT_DOUBLE_EQ(parse_quantity("400 per metre", "m-1"), 400);
}

TEST(Quantity, RefusesWhatIsNoNumberWithAUnit) {
  EXPECT_EQ(quantity_error("19", "m"), "the unit is missing");
  EXPECT_EQ(quantity_error("um", "m"), "does not start with a number");
  EXPECT_EQ(quantity_error("+-5 um", "m"), "does not start with a number");
  EXPECT_EQ(quantity_error("1e-400 m", "m"), "the number is nearer to 0 than a number can be; write 0");
  EXPECT_EQ(quantity_error("1e400 m", "m"), "the number is not finite");
  EXPECT_EQ(quantity_error("1,5 mm", "m"), "a number has a point, not a comma");
  EXPECT_EQ(quantity_error("", "m"), "does not start with a number");
  EXPECT_EQ(quantity_error("5 furlongish", "m"), "\"furlongish\" is not a unit");
  for (const char* number : {"nan m", "inf m", "-inf m", "1e400 m", "1e308 km"})
    EXPECT_EQ(quantity_error(number, "m"), "the number is not finite") << number;
}

TEST(Quantity, RefusesUnitsOfAnotherKind) {
  EXPECT_EQ(quantity_error("19 N", "m"), "\"N\" does not convert to m");
  EXPECT_EQ(quantity_error("3 %", "rad"), "\"%\" does not convert to rad");
  EXPECT_EQ(quantity_error("3 deg", "1"), "\"deg\" does not convert to 1");
  EXPECT_EQ(quantity_error("3 N m/rad", "N m"), "\"N m/rad\" does not convert to N m");
  EXPECT_EQ(quantity_error("5 m-1", "m"), "\"m-1\" does not convert to m");  // UDUNITS would take the reciprocal
}

TEST(Quantity, RefusesHiddenFactorsAndOffsets) {
  EXPECT_EQ(quantity_error("5 3 m", "m"), "\"3 m\" is not a unit");
  EXPECT_EQ(quantity_error("5 m 3", "m"), "\"m 3\" is not a unit");
  EXPECT_EQ(quantity_error("5 m*3", "m"), "\"m*3\" is not a unit");
  EXPECT_EQ(quantity_error("5 per 3 m", "m-1"), "\"per 3 m\" is not a unit");
  EXPECT_EQ(quantity_error("5 /", "m-1"), "\"/\" is not a unit");
  EXPECT_EQ(quantity_error("5 -m", "m"), "\"-m\" is not a unit");
  EXPECT_EQ(quantity_error("5 m from 10", "m"), "\"m from 10\" is not a unit");
}

TEST(Wildcard, StarIsAnyTextAndQuestionMarkOneCharacter) {
  EXPECT_TRUE(matches("warp/1", "warp/1"));
  EXPECT_FALSE(matches("warp/1", "warp/12"));
  EXPECT_FALSE(matches("warp/12", "warp/1"));
  EXPECT_TRUE(matches("warp/?", "warp/1"));
  EXPECT_FALSE(matches("warp/?", "warp/12"));
  EXPECT_FALSE(matches("warp/?", "warp/"));
  EXPECT_TRUE(matches("warp/*/start", "warp/12/start"));
  EXPECT_FALSE(matches("warp/*/start", "warp/12/end"));
  EXPECT_FALSE(matches("warp/*", "side/warp/start"));
  EXPECT_TRUE(matches("*", ""));
  EXPECT_TRUE(matches("a**b*", "ab"));
  EXPECT_TRUE(matches("*ab*ab", "aabxabxab"));  // needs to go back to an earlier star
  EXPECT_FALSE(matches("*ab*ac", "aabxabxab"));
  EXPECT_FALSE(matches("", "a"));
}

TEST(NameTable, FindsNamesAndThoseThatFit) {
  NameTable table({"warp/1", "weft/1", "warp/2"});
  EXPECT_EQ(table.find("warp/2"), std::optional<Index>(2));
  EXPECT_EQ(table.find("warp/*"), std::nullopt) << "no name";
  EXPECT_EQ(table.fitting("warp/*"), (std::vector<Index>{0, 2}));
  EXPECT_EQ(table.fitting("weft/1"), (std::vector<Index>{1}));
  EXPECT_TRUE(table.fitting("warp/3").empty());
  EXPECT_TRUE(table.add("warp/3"));
  EXPECT_FALSE(table.add("warp/1")) << "is there already";
  EXPECT_EQ(table.find("warp/1"), std::optional<Index>(0));
}

TEST(WeavePattern, PlainIsACheckerboard) {
  const WeavePattern plain = continued(twill_pattern({1, 1}), 5, 4);
  ASSERT_EQ(plain.size(), 5u);
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(plain[i].size(), 4u);
    for (int j = 0; j < 4; ++j) EXPECT_EQ(plain[i][j], (i + j) % 2 == 0) << i << " " << j;
  }
}

TEST(WeavePattern, TwillGoesUpOneWeftYarnFromWarpToWarp) {
  const WeavePattern expected = {{1, 0, 0, 1}, {1, 1, 0, 0}, {0, 1, 1, 0}, {0, 0, 1, 1}};
  EXPECT_EQ(twill_pattern({2, 2}), expected);
  const WeavePattern twill = continued(twill_pattern({2, 2}), 6, 6);
  for (int i = 1; i < 6; ++i)
    for (int j = 1; j < 6; ++j) EXPECT_EQ(twill[i][j], twill[i - 1][j - 1]);
}

TEST(WeavePattern, TwillFloatsStandAlongTheWarp) {
  const WeavePattern twill = twill_pattern({3, 1, 1, 1});
  const std::vector<bool> along_first_warp = {true, true, true, false, true, false};
  for (int i = 0; i < 6; ++i) EXPECT_EQ(twill[i][0], along_first_warp[i]);
}

TEST(WeavePattern, SatinHasOneInterlacingInEachRowAndColumn) {
  for (const auto& [harnesses, step] : {std::pair{5, 2}, {5, 3}, {7, 3}, {8, 5}}) {
    ASSERT_TRUE(is_satin(harnesses, step));
    const WeavePattern satin = satin_pattern(harnesses, step);
    std::set<int> columns;
    for (int i = 0; i < harnesses; ++i) {
      EXPECT_EQ(std::count(satin[i].begin(), satin[i].end(), false), 1);
      columns.insert(static_cast<int>(std::find(satin[i].begin(), satin[i].end(), false) - satin[i].begin()));
    }
    EXPECT_EQ(static_cast<int>(columns.size()), harnesses);
  }
  const WeavePattern satin = satin_pattern(5, 2);
  EXPECT_FALSE(satin[0][0]);
  EXPECT_FALSE(satin[1][2]);
  EXPECT_FALSE(satin[2][4]);
  EXPECT_FALSE(satin[3][1]);
}

TEST(WeavePattern, SatinNeedsASuitableStep) {
  EXPECT_FALSE(is_satin(6, 2));
  EXPECT_FALSE(is_satin(6, 3));
  EXPECT_FALSE(is_satin(5, 1));  // twills
  EXPECT_FALSE(is_satin(5, 4));
}

const std::string weave_scene = R"(
title = "everything"
[material.pa66]
model = "isotropic"
young_modulus = "3 GPa"
poisson_ratio = 0.25
[material.carbon]
model = "transversely_isotropic"
young_modulus_axial = "230 GPa"
young_modulus_transverse = "15 GPa"
shear_modulus_axial = "24 GPa"
poisson_ratio_axial = 0.28
poisson_ratio_transverse = 0.3
[fiber_type.fine]
material = "carbon"
diameter = "7 um"
model = "rod"
[fiber_type.filament]
material = "pa66"
diameter = "20 um"
[[fiber]]
name = "wire"
fiber_type = "filament"
points = [["0 mm", "0 mm", "1 mm"], ["1 mm", "0 mm", "1 mm"], ["2 mm", "0.1 mm", "1 mm"]]
elements = 9
section_axis = [0, 0, 2]
[[bundle]]
name = "strand"
fiber_type = "filament"
points = [["0 mm", "0 mm", "2 mm"], ["1 mm", "0 mm", "2 mm"]]
elements = 5
fibers = 7
layers = 3
lattice_spacing = 1.1
twist = -0.5
[weave]
matrix = [[1, 0, 0], [0, 1, 0]]
[weave.warp]
fiber_type = "filament"
yarns = 4
fibers = 7
layers = 2
elements = 11
yarn_spacing = "130 um"
margin = "100 um"
lattice_spacing = 1.2
[weave.weft]
fiber_type = "fine"
yarns = 3
fibers = 8
elements = 12
yarn_spacing = "140 um"
margin = "90 um"
[[body]]
name = "grip"
position = ["1 mm", "2 mm", "-3 mm"]
[[body.tie]]
fibers = "w?re"
end = "end"
kind = "average"
[[body.tie]]
fibers = "strand"
end = "start"
[effects]
contact = "between_yarns"
self_contact = true
friction = true
twist_stretch = true
adapt_penalty = false
[contact]
friction_coefficient = 0.3
reversible_slip = 0.04
spacing = 0.6
search_margin = 0.7
penalty = 2
[solver]
force_tolerance = 1e-5
max_newton_iterations = 21
max_geometry_updates = 4
step_cap = 0.4
min_increment = 1e-3
factor_precision = "single"
preconditioner = "two_level"
[[stage]]
name = "separate"
separate_yarns = true
friction = false
increments = 12
proximal_start = 1e-3
proximal_end = 1e-4
fiber_model = "rod"
save_every = 3
[[stage.drive]]
bodies = ["warp/*/start", "weft/1/end"]
dof = ["x", "y"]
force = "-1 mN"
[[stage.drive]]
bodies = "grip"
dof = "rz"
displacement = "90 deg"
[[stage.drive]]
bodies = "grip"
dof = "rx"
force = "2 N mm"
[[stage]]
name = "load"
[[stage.drive]]
bodies = "side/warp/*"
dof = "x"
strain = "2 %"
[[stage.drive]]
bodies = "warp/?/end"
dof = "x"
follow = "side/warp/end"
[[stage.drive]]
bodies = "grip"
dof = "z"
displacement = "-5 um"
)";

TEST(Scene, ReadsTextsAndMaterials) {
  const Scene scene = parse_scene(weave_scene, "some/where/everything.toml");
  EXPECT_EQ(scene.name, "everything");
  EXPECT_EQ(scene.title, "everything");
  EXPECT_EQ(scene.text, weave_scene);
  ASSERT_EQ(scene.materials.size(), 2u);
  const Material& pa66 = scene.materials[scene.fiber_types[scene.weave->warp.kinds[0].type].material];
  EXPECT_EQ(pa66.name, "pa66");
  EXPECT_EQ(pa66.young_modulus_axial, 3e9);
  EXPECT_EQ(pa66.young_modulus_transverse, 3e9);
  EXPECT_EQ(pa66.shear_modulus_axial, 1.2e9);  // E / 2 (1 + ν) = 3 / 2.5
  EXPECT_EQ(pa66.poisson_ratio_axial, 0.25);
  EXPECT_EQ(pa66.poisson_ratio_transverse, 0.25);
  const Material& carbon = scene.materials[scene.fiber_types[scene.weave->weft.kinds[0].type].material];
  EXPECT_EQ(carbon.name, "carbon");
  EXPECT_EQ(carbon.young_modulus_axial, 230e9);
  EXPECT_EQ(carbon.young_modulus_transverse, 15e9);
  EXPECT_EQ(carbon.shear_modulus_axial, 24e9);
  EXPECT_EQ(carbon.poisson_ratio_axial, 0.28);
  EXPECT_EQ(carbon.poisson_ratio_transverse, 0.3);
}

TEST(Scene, ReadsFiberTypes) {
  const Scene scene = parse_scene(weave_scene, "everything.toml");
  ASSERT_EQ(scene.fiber_types.size(), 2u);
  const FiberType& filament = scene.fiber_types[scene.weave->warp.kinds[0].type];
  EXPECT_EQ(filament.name, "filament");
  EXPECT_EQ(filament.radius, 10e-6);
  EXPECT_EQ(filament.model, FiberModel::enriched);
  const FiberType& fine = scene.fiber_types[scene.weave->weft.kinds[0].type];
  EXPECT_EQ(fine.name, "fine");
  EXPECT_EQ(fine.radius, 3.5e-6);
  EXPECT_EQ(fine.model, FiberModel::rod);
}

TEST(Scene, ReadsFibersAndBundles) {
  const Scene scene = parse_scene(weave_scene, "everything.toml");
  ASSERT_EQ(scene.fibers.size(), 1u);
  const FiberSpec& wire = scene.fibers[0];
  EXPECT_EQ(wire.name, "wire");
  EXPECT_EQ(scene.fiber_types[wire.type].name, "filament");
  ASSERT_EQ(wire.points.size(), 3u);
  EXPECT_EQ(wire.points[2], Vec3(2e-3, 1e-4, 1e-3));
  EXPECT_EQ(wire.n_elements, 9);
  EXPECT_EQ(wire.section_axis.value(), Vec3(0, 0, 2));
  ASSERT_EQ(scene.bundles.size(), 1u);
  const BundleSpec& strand = scene.bundles[0];
  EXPECT_EQ(strand.name, "strand");
  EXPECT_EQ(scene.fiber_types[strand.type].name, "filament");
  EXPECT_EQ(strand.points.at(1), Vec3(1e-3, 0, 2e-3));
  EXPECT_EQ(strand.n_elements, 5);
  EXPECT_EQ(strand.n_fibers, 7);
  EXPECT_EQ(strand.n_layers, 3);
  EXPECT_EQ(strand.lattice_spacing, 1.1);
  EXPECT_EQ(strand.twist, -0.5);
}

TEST(Scene, ReadsTheWeave) {
  const Scene scene = parse_scene(weave_scene, "everything.toml");
  ASSERT_TRUE(scene.weave);
  const WeavePattern expected = {
      {1, 0, 0, 1}, {0, 1, 0, 0}, {1, 0, 0, 1}};  // 2 x 3 continued over 3 weft, 4 warp yarns
  EXPECT_EQ(scene.weave->warp_above, expected);
  const YarnSystem& warp = scene.weave->warp;
  EXPECT_EQ(warp.n_yarns, 4);
  EXPECT_EQ(warp.kinds[0].n_fibers, 7);
  EXPECT_EQ(warp.kinds[0].n_layers, 2);
  EXPECT_EQ(warp.n_elements, 11);
  EXPECT_EQ(warp.yarn_spacing, 130e-6);
  EXPECT_EQ(warp.margin, 100e-6);
  EXPECT_EQ(warp.kinds[0].lattice_spacing, 1.2);
  const YarnSystem& weft = scene.weave->weft;
  EXPECT_EQ(weft.n_yarns, 3);
  EXPECT_EQ(weft.kinds[0].n_fibers, 8);
  EXPECT_EQ(weft.kinds[0].n_layers, 0);
  EXPECT_EQ(weft.n_elements, 12);
  EXPECT_EQ(weft.yarn_spacing, 140e-6);
  EXPECT_EQ(weft.margin, 90e-6);
  EXPECT_EQ(weft.kinds[0].lattice_spacing, YarnKind{}.lattice_spacing);
}

TEST(Scene, ReadsBodies) {
  const Scene scene = parse_scene(weave_scene, "everything.toml");
  ASSERT_EQ(scene.bodies.size(), 1u);
  const BodySpec& grip = scene.bodies[0];
  EXPECT_EQ(grip.name, "grip");
  EXPECT_EQ(grip.position, Vec3(1e-3, 2e-3, -3e-3));
  ASSERT_EQ(grip.ties.size(), 2u);
  EXPECT_EQ(grip.ties[0].fibers, "w?re");
  EXPECT_EQ(grip.ties[0].end, FiberEnd::end);
  EXPECT_EQ(grip.ties[0].kind, TieKind::average);
  EXPECT_EQ(grip.ties[1].fibers, "strand");
  EXPECT_EQ(grip.ties[1].end, FiberEnd::start);
  EXPECT_EQ(grip.ties[1].kind, TieKind::clamped);
}

TEST(Scene, ReadsEffectsAndSettings) {
  const Scene scene = parse_scene(weave_scene, "everything.toml");
  EXPECT_TRUE(scene.twist_stretch);
  EXPECT_EQ(scene.contact.scope, ContactScope::between_yarns);
  EXPECT_TRUE(scene.contact.self_contact);
  EXPECT_TRUE(scene.contact.friction);
  EXPECT_FALSE(scene.contact.adapt_penalty);
  EXPECT_EQ(scene.contact.friction_coefficient, 0.3);
  EXPECT_EQ(scene.contact.reversible_slip, 0.04);
  EXPECT_EQ(scene.contact.spacing, 0.6);
  EXPECT_EQ(scene.contact.search_margin, 0.7);
  EXPECT_EQ(scene.contact.penalty, 2);
  EXPECT_EQ(scene.solver.force_tolerance, 1e-5);
  EXPECT_EQ(scene.solver.max_newton_iterations, 21);
  EXPECT_EQ(scene.solver.max_geometry_updates, 4);
  EXPECT_EQ(scene.solver.step_cap, 0.4);
  EXPECT_EQ(scene.solver.min_increment, 1e-3);
  EXPECT_EQ(scene.solver.factor_precision, FactorPrecision::single_precision);
  EXPECT_EQ(scene.solver.preconditioner, Preconditioner::two_level);
  EXPECT_EQ(scene.stated_effects,
            (std::vector<std::string>{"adapt_penalty", "contact", "friction", "self_contact", "twist_stretch"}));
}

TEST(Scene, ReadsStages) {
  const Scene scene = parse_scene(weave_scene, "everything.toml");
  ASSERT_EQ(scene.stages.size(), 2u);
  const Stage& separate = scene.stages[0];
  EXPECT_EQ(separate.name, "separate");
  EXPECT_EQ(separate.n_increments, 12);
  EXPECT_TRUE(separate.separate_yarns);
  EXPECT_FALSE(separate.friction);
  EXPECT_EQ(separate.proximal_start, 1e-3);
  EXPECT_EQ(separate.proximal_end, 1e-4);
  EXPECT_EQ(separate.fiber_model, FiberModel::rod);
  EXPECT_EQ(separate.save_every, 3);
  const Stage& load = scene.stages[1];
  EXPECT_EQ(load.n_increments, Stage{}.n_increments);
  EXPECT_FALSE(load.separate_yarns);
  EXPECT_TRUE(load.friction);
  EXPECT_EQ(load.proximal_start, 0);
  EXPECT_FALSE(load.fiber_model.has_value());
  EXPECT_EQ(load.save_every, 1);
}

void expect_drive(const Drive& drive, const std::string& bodies, BodyDof dof, DriveMode mode, double value,
                  const std::string& leader = "") {
  EXPECT_EQ(drive.bodies, bodies);
  EXPECT_EQ(drive.dof, dof);
  EXPECT_EQ(drive.mode, mode);
  EXPECT_DOUBLE_EQ(drive.value, value);
  EXPECT_EQ(drive.leader, leader);
}

TEST(Scene, ReadsDrivesAndSpreadsTheirLists) {
  const Scene scene = parse_scene(weave_scene, "everything.toml");
  const std::vector<Drive>& first = scene.stages[0].drives;
  ASSERT_EQ(first.size(), 6u);
  expect_drive(first[0], "warp/*/start", BodyDof::x, DriveMode::force, -1e-3);
  expect_drive(first[1], "warp/*/start", BodyDof::y, DriveMode::force, -1e-3);
  expect_drive(first[2], "weft/1/end", BodyDof::x, DriveMode::force, -1e-3);
  expect_drive(first[3], "weft/1/end", BodyDof::y, DriveMode::force, -1e-3);
  expect_drive(first[4], "grip", BodyDof::rz, DriveMode::displacement, std::numbers::pi / 2);
  expect_drive(first[5], "grip", BodyDof::rx, DriveMode::force, 2e-3);
  const std::vector<Drive>& second = scene.stages[1].drives;
  ASSERT_EQ(second.size(), 3u);
  expect_drive(second[0], "side/warp/*", BodyDof::x, DriveMode::strain, 0.02);
  expect_drive(second[1], "warp/?/end", BodyDof::x, DriveMode::follow, 0, "side/warp/end");
  expect_drive(second[2], "grip", BodyDof::z, DriveMode::displacement, -5e-6);
}

const std::string small_scene = R"(
[material.m]
model = "isotropic"
young_modulus = "1 GPa"
poisson_ratio = 0
[fiber_type.t]
material = "m"
diameter = "10 um"
[[fiber]]
name = "f"
fiber_type = "t"
points = [["0 m", "0 m", "0 m"], ["1 mm", "0 m", "0 m"]]
elements = 1
)";

TEST(Scene, DefaultsAreThoseOfTheStructs) {
  const Scene scene = parse_scene(small_scene, "small.toml");
  EXPECT_TRUE(scene.stages.empty());
  EXPECT_FALSE(scene.weave);
  EXPECT_EQ(scene.title, "");
  EXPECT_EQ(scene.contact.scope, ContactSettings{}.scope);
  EXPECT_EQ(scene.contact.friction, ContactSettings{}.friction);
  EXPECT_EQ(scene.contact.spacing, ContactSettings{}.spacing);
  EXPECT_EQ(scene.solver.step_cap, SolverSettings{}.step_cap);
  EXPECT_FALSE(scene.fibers[0].section_axis);
}

TEST(Scene, FrictionGoesWithContactAndStagesFollow) {
  const Scene scene =
      parse_scene(small_scene + "[effects]\ncontact = \"none\"\n[[stage]]\nname = \"s\"\n", "small.toml");
  EXPECT_FALSE(scene.contact.friction);
  EXPECT_FALSE(scene.contact.adapt_penalty);
  EXPECT_FALSE(scene.stages.at(0).friction);
}

TEST(Scene, TargetGoesWithAdaptation) {
  const Scene scene = parse_scene(small_scene + "[contact]\ntarget_penetration = 0.02\n", "small.toml");
  EXPECT_TRUE(scene.contact.adapt_penalty);
  EXPECT_EQ(scene.contact.target_penetration, 0.02);
  EXPECT_TRUE(scene.stated_effects.empty());
}

TEST(Scene, KnowsTheFiberTypesThatFibersAreOf) {
  const std::string unused = "[fiber_type.a]\nmaterial = \"m\"\ndiameter = \"9 um\"\n";
  const Scene scene = parse_scene(small_scene + unused, "small.toml");
  ASSERT_EQ(scene.fiber_types.size(), 2u);
  ASSERT_EQ(fiber_types_in_use(scene).size(), 1u);
  EXPECT_EQ(scene.fiber_types[fiber_types_in_use(scene)[0]].name, "t");
  // The weave's two, the single fiber's and the bundle's.
  const Scene all = parse_scene(weave_scene, "everything.toml");
  for (const Index type :
       {all.weave->warp.kinds[0].type, all.weave->weft.kinds[0].type, all.fibers[0].type, all.bundles[0].type}) {
    const std::vector<Index> used = fiber_types_in_use(all);
    EXPECT_EQ(std::count(used.begin(), used.end(), type), 1);
  }
}

Weave weave_of(const std::string& pattern_keys) {
  std::string text = weave_scene;
  const std::string matrix = "matrix = [[1, 0, 0], [0, 1, 0]]";
  return parse_scene(text.replace(text.find(matrix), matrix.size(), pattern_keys), "weave.toml").weave.value();
}

TEST(Scene, NamedPatternsAreContinuedOverTheYarns) {
  EXPECT_EQ(weave_of("pattern = \"plain\"").warp_above, continued(twill_pattern({1, 1}), 3, 4));
  EXPECT_EQ(weave_of("pattern = \"twill\"").warp_above, continued(twill_pattern({2, 2}), 3, 4));
  EXPECT_EQ(weave_of("pattern = \"twill\"\nrepeat = \"3/1\"").warp_above, continued(twill_pattern({3, 1}), 3, 4));
  EXPECT_EQ(weave_of("pattern = \"satin\"").warp_above, continued(satin_pattern(5, 2), 3, 4));
  EXPECT_EQ(weave_of("pattern = \"satin\"\nharnesses = 8\nstep = 3").warp_above, continued(satin_pattern(8, 3), 3, 4));
}

TEST(Scene, AllShippedScenesAreRight) {
  int n_scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(TRAME_DATA_DIR "/scenes")) {
    if (entry.path().extension() != ".toml") continue;
    ++n_scenes;
    try {
      const Scene scene = read_scene(entry.path());
      EXPECT_EQ(scene.name, entry.path().stem());
      EXPECT_FALSE(scene.title.empty()) << entry.path();
      EXPECT_FALSE(scene.stages.empty()) << entry.path();
    } catch (const InputError& error) {
      ADD_FAILURE() << error.what();
    }
  }
  EXPECT_GE(n_scenes, 8);
}

TEST(Scene, ThePatchesHaveTheSizeOfThePaper) {
  for (const char* name : {"plain", "twill"}) {
    const Scene scene = read_scene(std::string(TRAME_DATA_DIR "/scenes/") + name + ".toml");
    ASSERT_TRUE(scene.weave);
    const YarnSystem &warp = scene.weave->warp, &weft = scene.weave->weft;
    EXPECT_EQ(warp.n_fibers() + weft.n_fibers(), 408);
    const int n_nodes = warp.n_fibers() * (2 * warp.n_elements + 1) + weft.n_fibers() * (2 * weft.n_elements + 1);
    EXPECT_NEAR(n_nodes, 35000, 1000);
    // 3.25 dtex at 1140 kg/m³: area 3.25e-7 kg/m / 1140 kg/m³.
    const double diameter = 2 * std::sqrt(3.25e-7 / 1140 / std::numbers::pi);
    EXPECT_NEAR(2 * scene.fiber_types[warp.kinds[0].type].radius, diameter, 0.1e-6);
  }
}

TEST(SceneSchema, ListsTheKeysWithUnitDefaultRangeAndMeaning) {
  const std::string schema = scene_schema();
  for (const char* table :
       {"[material.NAME]", "[fiber_type.NAME]", "[[fiber]]", "[[bundle]]", "[weave]", "[weave.warp]", "[[body]]",
        "[[body.tie]]", "[[stage]]", "[[stage.drive]]", "[[stage.load]]", "[effects]", "[contact]", "[solver]"})
    EXPECT_NE(schema.find(table), std::string::npos) << table;
  EXPECT_NE(schema.find("friction_coefficient      µ; needs friction\n"
                        "                            a number of at least 0 (default: 0.2)"),
            std::string::npos);
  EXPECT_NE(schema.find("a length greater than 0 with its unit, such as \"19 um\" (this or sett)"), std::string::npos);
}

}  // namespace
}  // namespace trame::micro
