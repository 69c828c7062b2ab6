/// Tests by name: the stages that they stand for, and what they measure where that is known.

#include "micro/scene/named_test.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tests/support/messages.h"
#include "tests/support/run_scene.h"
#include "tests/support/text_file.h"

namespace trame::micro {
namespace {

using trame::test::expect_mentions;
using trame::test::input_error;

/// plain_small without its last stage.
std::string woven() {
  const std::string text = trame::test::read_text(std::filesystem::path(TRAME_DATA_DIR) / "scenes/plain_small.toml");
  return text.substr(0, text.find("# Biaxial tension"));
}
Stage stage_of(const std::string& test) { return parse_scene(woven() + "[test]\n" + test, "s.toml").stages.back(); }
std::string error_of(const std::string& test) {
  return input_error([&] { (void)parse_scene(woven() + "[test]\n" + test, "s.toml"); });
}

TEST(NamedTest, BiaxialIsTheLoadOfTheShippedScene) {
  Stage written = read_scene(std::filesystem::path(TRAME_DATA_DIR) / "scenes/plain_small.toml").stages.back();
  written.name = "biaxial";
  EXPECT_TRUE(stage_of("kind = \"biaxial\"\nwarp_strain = \"2 %\"") == written);
}

TEST(NamedTest, CyclesGoThereAndBack) {
  const Stage stage = stage_of("kind = \"biaxial\"\nweft_strain = 0.01\nincrements = 5\ncycles = 2");
  EXPECT_EQ(stage.n_increments, 20);
  for (const Drive& drive : stage.drives)
    EXPECT_EQ(drive.amplitude,
              drive.mode == DriveMode::follow ? Amplitude() : (Amplitude{{{0.25, 1}, {0.5, 0}, {0.75, 1}, {1, 0}}}));
}

TEST(NamedTest, UniaxialLeavesTheEndsOfTheOtherFamilyFree) {
  const Stage stage = stage_of("kind = \"uniaxial\"\nstrain = 0.02\ndirection = \"weft\"");
  int n_free = 0;
  for (const Drive& drive : stage.drives) {
    if (drive.mode == DriveMode::strain) {
      EXPECT_EQ(drive.bodies, "side/weft/*");
    }
    if (drive.mode == DriveMode::follow) {
      EXPECT_TRUE(drive.leader.starts_with("side/weft/"));
    }
    if (drive.mode == DriveMode::force) {
      EXPECT_EQ(drive.bodies, "warp/*");
      EXPECT_EQ(drive.value, 0);
      ++n_free;
    }
  }
  EXPECT_EQ(n_free, 6);
  EXPECT_EQ(stage.proximal_start, 0);
}

TEST(NamedTest, UniaxialLetsEndsGoWithDampingBefore) {
  const Scene scene = parse_scene(woven() + "[test]\nkind = \"uniaxial\"\nstrain = 0.02\ncycles = 2", "s.toml");
  ASSERT_GE(scene.stages.size(), 2U);
  const Stage& release = scene.stages[scene.stages.size() - 2];
  EXPECT_EQ(release.name, "release");
  EXPECT_GT(release.proximal_start, 0);
  EXPECT_EQ(release.proximal_end, 0);
  ASSERT_EQ(release.drives.size(), 6U);
  for (const Drive& drive : release.drives)
    EXPECT_EQ(drive, (Drive{"weft/*", drive.dof, DriveMode::force, 0, "", {}})) << "no amplitude of the test";
}

/// Nothing resists a turn of a single rod about its axis, which is held: rx of warps, where the weft is pulled.
TEST(NamedTest, UniaxialHoldsTheTurnOfSingleRods) {
  const auto turned = [](const std::string& kinds) {
    const Scene scene = parse_scene(
        R"([material.m]
model = "isotropic"
young_modulus = "1 GPa"
poisson_ratio = 0.3
[fiber_type.rod]
material = "m"
diameter = "20 um"
model = "rod"
[fiber_type.beam]
material = "m"
diameter = "20 um"
[yarn.one]
fiber_type = "rod"
fibers = 1
[yarn.two]
fiber_type = "rod"
fibers = 2
[yarn.beam]
fiber_type = "beam"
fibers = 1
[weave]
pattern = "plain"
[weave.warp]
order = ")" +
            kinds + R"("
yarns = 3
sett = "50 per cm"
[weave.weft]
order = "one"
yarns = 2
sett = "50 per cm"
[test]
kind = "uniaxial"
strain = 0.01
direction = "weft"
)",
        "s.toml");
    std::vector<std::string> bodies;
    for (const Drive& drive : scene.stages.back().drives)
      if (drive.mode == DriveMode::force && drive.dof == BodyDof::rx) bodies.push_back(drive.bodies);
    return bodies;
  };
  EXPECT_EQ(turned("two beam"), (std::vector<std::string>{"warp/*"}));
  EXPECT_EQ(turned("one"), (std::vector<std::string>{}));
  EXPECT_EQ(turned("two one"), (std::vector<std::string>{"warp/1/*", "warp/3/*"}));
}

TEST(NamedTest, PullOutDrawsOneEndOutwardAndFreesTheOther) {
  const std::vector<Drive> drives =
      stage_of("kind = \"pull_out\"\nyarn = \"weft/2\"\nend = \"start\"\ndistance = \"10 um\"").drives;
  ASSERT_EQ(drives.size(), 2U);
  EXPECT_EQ(drives[0], (Drive{"weft/2/start", BodyDof::y, DriveMode::displacement, -10e-6, ""}));
  EXPECT_EQ(drives[1], (Drive{"weft/2/end", BodyDof::y, DriveMode::force, 0, ""}));
}

TEST(NamedTest, WhatDoesNotGoTogetherIsRefusedWithItsKey) {
  expect_mentions(error_of("kind = \"knit\""), {"s.toml", "test.kind", "knit", "biaxial", "yarn_tension"});
  expect_mentions(error_of("kind = \"biaxial\""), {"warp_strain or a weft_strain other than 0"});
  expect_mentions(error_of("kind = \"biaxial\"\nwarp_strain = 0.1\nstrain = 0.1"),
                  {"test.strain", "none of test \"biaxial\"", "weft_strain"});
  expect_mentions(error_of("kind = \"uniaxial\""), {"strain", "test \"uniaxial\" needs"});
  expect_mentions(error_of("kind = \"uniaxial\"\nstrain = 20"), {"test.strain", "20", "10"});
  expect_mentions(error_of("kind = \"pull_out\"\nyarn = \"warp/7\"\ndistance = \"1 um\""),
                  {"test.yarn", "warp/7", "warp/1"});
  expect_mentions(error_of("kind = \"pull_out\"\nyarn = \"warp/1\"\ndistance = \"-1 um\""),
                  {"test.distance", "greater than 0"});
  expect_mentions(error_of("kind = \"pull_out\"\nyarn = \"warp/1\"\ndistance = \"1 mm\""),
                  {"test.distance", "0.000326 m, the length of the yarn"});
  expect_mentions(error_of("kind = \"shear\"\nstrain = 0.1"), {"angle", "test \"shear\" of a patch needs"});
  expect_mentions(error_of("kind = \"shear\"\nangle = \"85 deg\""), {"test.angle", "85 deg", "1.39626"});
  expect_mentions(error_of("kind = \"indentation\"\nradius = \"60 um\"\ndepth = \"1 um\""),
                  {"test.radius", "6.5e-05 m", "falls through"});
  expect_mentions(error_of("kind = \"bending\"\ncurvature = \"0 m-1\""), {"test.curvature", "other than 0"});
  expect_mentions(error_of("kind = \"bending\"\ncurvature = \"30 mm-1\""), {"test.curvature", "to 19273.6 per m"});
  expect_mentions(error_of("kind = \"bending\"\ncurvature = \"1 mm-1\"\nclamps = \"glue\""),
                  {"test.clamps", "sliding", "clamped"});
  expect_mentions(error_of("kind = \"yarn_bending\"\nyarn = \"warp/1\"\ncurvature = \"1 mm-1\""),
                  {"test.yarn", "must be a [[bundle]]"});
  expect_mentions(error_of("kind = \"pull_out\"\nyarn = \"warp/1\"\ndistance = \"1 um\"\ncycle = 2"),
                  {"cycle", "cycles"});
  expect_mentions(input_error([] {
                    (void)parse_scene(
                        woven() + "[[stage]]\nname = \"biaxial\"\n[test]\nkind = \"biaxial\"\nwarp_strain = 0.1",
                        "s.toml");
                  }),
                  {"biaxial", "is taken"});
}

/// Seven fibers of 1 mm, E A = 0.3 N each.
std::string bundle(const std::string& more) {
  return R"([material.m]
model = "isotropic"
young_modulus = "1 GPa"
poisson_ratio = 0
[fiber_type.f]
material = "m"
diameter = "19.544 um"
model = "rod"
[[bundle]]
name = "tow"
fiber_type = "f"
points = [["0 mm", "0 mm", "1 mm"], ["0 mm", "0.6 mm", "1.8 mm"]]
elements = 4
fibers = 7
[effects]
contact = "none"
)" + more;
}

TEST(NamedTest, YarnTensionOfABundleBringsItsBodiesAndHasTheStiffnessOfItsFibers) {
  const Scene scene = parse_scene(
      bundle("[test]\nkind = \"yarn_tension\"\nyarn = \"tow\"\nstrain = \"1 %\"\nincrements = 4\ncycles = 1"),
      "s.toml");
  ASSERT_EQ(scene.bodies.size(), 2U);
  EXPECT_EQ(scene.bodies[1].name, "tow/end");
  const auto result = test::run_scene(scene);
  ASSERT_TRUE(result.done()) << result.summary.message;
  ASSERT_EQ(result.summary.curve.size(), 8U);
  const auto pull = [&](std::size_t i) {
    const std::vector<double>& r = result.summary.curve[i].reaction;
    return 0.6 * r[7] + 0.8 * r[8];  // of the end, along the bundle
  };
  const double expected = 7 * 0.3 * 0.5 * (1.01 * 1.01 - 1) * 1.01;
  EXPECT_NEAR(pull(3), expected, 2e-3 * expected);
  EXPECT_NEAR(pull(7), 0, 1e-6 * expected) << "an elastic bundle comes back";
  EXPECT_NEAR(result.summary.curve[3].motion[7], 6e-6, 1e-12);
  EXPECT_NEAR(result.summary.energy.external_work, 0, 1e-6 * expected * 1e-5) << "and gives back what it took";
}

/// The test curve of a run: motion and reaction at a point of its stage, counted from the stage's start.
std::array<double, 2> measured(const Scene& scene, const test::RunResult& result, std::size_t increment) {
  const TestCurve& test = *scene.test_curve;
  std::vector<const CurvePoint*> points;
  for (const auto* list : {&result.summary.stage_starts, &result.summary.curve})
    for (const CurvePoint& point : *list)
      if (point.stage == test.stage) points.push_back(&point);
  std::array<double, 2> sums{};
  double length = test.length;
  for (const TestCurve::Term& term : test.terms) {
    const std::size_t i = n_body_dofs * test::body_named(result, term.body) + static_cast<std::size_t>(term.dof);
    sums[0] += term.motion * points.at(increment)->motion.at(i);
    sums[1] += term.reaction * points.at(increment)->reaction.at(i);
    length += term.length * points.front()->motion.at(i);
  }
  if (test.length > 0) sums[0] /= length;
  return sums;
}

/// E I of a fiber of the bundle, N m².
constexpr double bending_stiffness = 1e9 * std::numbers::pi / 4 * 9.772e-6 * 9.772e-6 * 9.772e-6 * 9.772e-6;

// Fibers that slide through the clamps bend each for itself; those that are held stretch as in a solid section. The
// bundle's hexagon has four fibers half of √3 spacings above and below.
TEST(NamedTest, YarnBendingLiesBetweenFreeAndBondedFibers) {
  const double spacing = 1.05 * 19.544e-6, height = 0.5 * std::sqrt(3.0) * spacing,
               area = std::numbers::pi * 9.772e-6 * 9.772e-6;
  const double sliding = 7 * bending_stiffness, clamped = sliding + 4 * 1e9 * area * height * height;
  for (const auto& [clamps, stiffness] : {std::pair{"sliding", sliding}, {"clamped", clamped}})
    for (const double curvature : {4.0, -4.0}) {  // from 10 on clamped fibers bow out, at 50 they buckle
      const Scene scene =
          parse_scene(bundle(fmt::format("[test]\nkind = \"yarn_bending\"\nyarn = \"tow\"\ncurvature = \"{} m-1\"\n"
                                         "clamps = \"{}\"\nincrements = 2\ncycles = 1",
                                         curvature, clamps)),
                      "s.toml");
      const auto result = test::run_scene(scene);
      ASSERT_TRUE(result.done()) << result.summary.message;
      const auto [turned, moment] = measured(scene, result, 2);
      EXPECT_NEAR(turned, curvature, 1e-9);
      EXPECT_NEAR(moment, stiffness * curvature, 0.01 * stiffness * std::abs(curvature)) << clamps;
      EXPECT_NEAR(measured(scene, result, 4)[1], 0, 1e-4 * std::abs(moment)) << "an elastic bundle comes back";
    }
}

TEST(NamedTest, YarnTensionNeedsFreeEnds) {
  const std::string error = input_error([] {
    (void)parse_scene(bundle("[[body]]\nname = \"jaw\"\n[[body.tie]]\nfibers = \"t*\"\nend = \"end\"\n"
                             "[test]\nkind = \"yarn_tension\"\nyarn = \"tow\"\nstrain = 0.01"),
                      "s.toml");
  });
  expect_mentions(error, {"test.yarn", "the end of \"tow\" is tied to body \"jaw\""});
  expect_mentions(
      input_error([] { (void)parse_scene(bundle("[test]\nkind = \"uniaxial\"\nstrain = 0.01"), "s.toml"); }),
      {"test.kind", "needs a [weave]"});
}

/// A patch of straight yarns of one fiber each that do not touch.
std::string patch(const std::string& test) {
  std::string yarns;
  for (const char* family : {"warp", "weft"})
    yarns += fmt::format(
        "[weave.{}]\nfiber_type = \"f\"\nyarns = 2\nfibers = 1\nelements = 10\nyarn_spacing = \"0.5 mm\"\n"
        "margin = \"0.25 mm\"\n",
        family);
  const std::string types = bundle("");
  return types.substr(0, types.find("[[bundle]]")) + "[weave]\npattern = \"plain\"\n" + yarns +
         "[effects]\ncontact = \"none\"\n[test]\n" + test;
}

TEST(NamedTest, BiaxialOfYarnsThatDoNotTouchIsTwiceUniaxial) {
  const auto result = test::run_scene(parse_scene(
      patch("kind = \"biaxial\"\nwarp_strain = 0.02\nweft_strain = 0.01\nincrements = 2\ncycles = 1"), "s.toml"));
  ASSERT_TRUE(result.done()) << result.summary.message;
  const CurvePoint& top = result.summary.curve[1];
  for (const int side : {0, 1}) {
    const double strain = side == 0 ? 0.02 : 0.01,
                 force = 2 * 0.3 * 0.5 * ((1 + strain) * (1 + strain) - 1) * (1 + strain);
    EXPECT_NEAR(top.side_strain[side], strain, 1e-8);
    EXPECT_NEAR(top.side_force[side], force, 2e-3 * force);
    EXPECT_NEAR(result.summary.curve.back().side_force[side], 0, 1e-6 * force);
  }
}

// Each of the two single fibers bends for itself, on 1 mm of width; nothing else is strained.
TEST(NamedTest, BendingOfYarnsThatDoNotTouchIsThatOfTheirFibers) {
  for (const std::string direction : {"warp", "weft"})
    for (const double curvature : {400.0, -400.0}) {
      const Scene scene = parse_scene(
          patch(fmt::format("kind = \"bending\"\ndirection = \"{}\"\ncurvature = \"{} m-1\"\nincrements = 4", direction,
                            curvature)),
          "s.toml");
      const auto result = test::run_scene(scene);
      ASSERT_TRUE(result.done()) << result.summary.message;
      const auto [turned, moment] = measured(scene, result, 4);
      const double expected = 2 * bending_stiffness / 1e-3 * curvature;
      EXPECT_NEAR(turned, curvature, 1e-6 * std::abs(curvature));
      EXPECT_NEAR(moment, expected, 5e-3 * std::abs(expected)) << direction;
      // The ends come nearer to each other along a circle, and turn up for a positive curvature.
      const double angle = 0.4 * curvature / 400, chord = 2 / curvature * std::sin(angle / 2);
      const Vec3& end = result.last().bodies.position[test::body_named(result, direction + "/1/end")];
      const Vec3& start = result.last().bodies.position[test::body_named(result, direction + "/1/start")];
      EXPECT_NEAR((end - start).norm(), chord, 2e-3 * chord);
      const Vec3 tip = result.tip(direction == "warp" ? 0 : 2),
                 middle = result.last().fibers.r[result.last_node(direction == "warp" ? 0 : 2) - 10];
      EXPECT_GT((tip.z() - middle.z()) * curvature, 0);
    }
}

// A frame whose sides keep their lengths while its corners close by the angle; straight yarns turn in it freely.
TEST(NamedTest, ClampsAndFramesNeedYarnsThatStandOnThem) {
  for (const char* test : {"kind = \"shear\"\nangle = \"30 deg\"", "kind = \"bending\"\ncurvature = \"1 /m\""}) {
    std::string scene = patch(test);
    const std::string weave = "[weave]\n";
    scene.insert(scene.find(weave) + weave.size(), "angle = \"60 deg\"\n");
    expect_mentions(input_error([&] { (void)parse_scene(scene, "s.toml"); }),
                    {"test.kind", "needs a [weave] at right angles"});
  }
}

TEST(NamedTest, PictureFrameTurnsYarnsAndKeepsTheirLengths) {
  const double angle = 30 * std::numbers::pi / 180;
  const Scene scene = parse_scene(patch("kind = \"shear\"\nangle = \"30 deg\"\nincrements = 3"), "s.toml");
  const auto result = test::run_scene(scene);
  ASSERT_TRUE(result.done()) << result.summary.message;
  const auto [turned, force] = measured(scene, result, 3);
  EXPECT_NEAR(turned, angle, 1e-9);
  EXPECT_NEAR(force, 0, 1e-6) << "N/m, of fibers that take 600 N/m at a strain of one";
  const auto affine = [&](double x, double y) -> Vec3 {
    const double c = std::cos(angle / 2), s = std::sin(angle / 2);
    return {c * x + s * y, s * x + c * y, 0};
  };
  for (const double side : {-1.0, 1.0}) {
    const std::string end = side < 0 ? "start" : "end";
    const auto place = [&](const std::string& yarn) {
      return result.last().bodies.position[test::body_named(result, yarn + end)];
    };
    EXPECT_LT((place("warp/1/") - affine(side * 0.5e-3, -0.25e-3)).norm(), 1e-8);
    EXPECT_LT((place("weft/2/") - affine(0.25e-3, side * 0.5e-3)).norm(), 1e-8);
  }
}

// Two fibers of 1 mm that cross a gap of 0.5 mm: the sphere rests on both pairs of yarns, from where it touches them.
TEST(NamedTest, IndenterBeginsWhereItTouches) {
  std::string text = patch("kind = \"indentation\"\nradius = \"1 mm\"\ndepth = \"2 um\"\nincrements = 1");
  const Scene scene = parse_scene(text, "s.toml");
  const auto result = test::run_scene(scene);
  ASSERT_TRUE(result.done()) << result.summary.message;
  const double reach = 1e-3 + 9.772e-6, aside = 0.25e-3;
  EXPECT_NEAR(result.last().bodies.position[test::body_named(result, "indenter")].z(),
              std::sqrt(reach * reach - aside * aside) - 2e-6, 1e-8);
  EXPECT_NEAR(measured(scene, result, 1)[0], 2e-6, 1e-12);
}

TEST(NamedTest, PullOutOfAYarnThatNothingHoldsTakesNoForce) {
  const auto result = test::run_scene(
      parse_scene(patch("kind = \"pull_out\"\nyarn = \"warp/1\"\ndistance = \"100 um\"\nincrements = 2"), "s.toml"));
  ASSERT_TRUE(result.done()) << result.summary.message;
  const CurvePoint& end = result.summary.curve.back();
  // Bodies: warp/1/start, warp/1/end, …
  EXPECT_NEAR(end.motion[6], 100e-6, 1e-12);
  EXPECT_NEAR(end.motion[0], 100e-6, 1e-9) << "the free end follows";
  EXPECT_NEAR(end.reaction[6], 0, 1e-9);
}

}  // namespace
}  // namespace trame::micro
