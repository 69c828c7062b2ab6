/// Surfaces of bodies: how scenes name them, where they begin, what a compaction makes of them.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "micro/cost_estimate.h"
#include "tests/support/meshes.h"
#include "tests/support/messages.h"
#include "tests/support/rod_scene.h"
#include "tests/support/run_scene.h"

namespace trame::micro {
namespace {

using trame::test::expect_mentions;
using trame::test::input_error;

/// A straight fiber of radius 0.1 mm on the x axis, or a bundle, and what is added.
std::string scene_of(const std::string& rest, const std::string& fibers = "") {
  return fibers.empty() ? trame::test::rod_scene(rest) : trame::test::rod_type() + fibers + rest;
}
std::string surface(const std::string& keys) {
  return scene_of("[[body]]\nname = \"tool\"\nposition = [\"1 mm\", \"2 mm\", \"3 mm\"]\n[[body.surface]]\n" + keys +
                  "\n[[stage]]\nname = \"first\"\n[[stage]]\nname = \"second\"\n");
}
SurfaceSpec read(const std::string& keys) { return parse_scene(surface(keys), "s.toml").bodies.at(0).surfaces.at(0); }
std::string error_of(const std::string& keys) {
  return input_error([&] { (void)parse_scene(surface(keys), "s.toml"); });
}

TEST(SurfaceScenes, AreReadInTheFrameOfTheirBody) {
  const SurfaceSpec plane = read("shape = \"plane\"\nnormal = [0, 0, -2]\ntouch = true\nfrom_stage = \"second\"");
  EXPECT_EQ(plane.surface.shape, SurfaceShape::plane);
  EXPECT_EQ(plane.surface.direction, -Vec3::UnitZ());
  EXPECT_EQ(plane.surface.center, Vec3::Zero());
  EXPECT_TRUE(plane.touches);
  EXPECT_EQ(plane.from_stage, "second");
  EXPECT_FALSE(plane.friction_coefficient);
  const SurfaceSpec roller = read(
      "shape = \"cylinder\"\naxis = [0, 3, 0]\nradius = \"0.5 mm\"\nlength = \"2 mm\"\ninside = true\n"
      "center = [\"1 mm\", \"2 mm\", \"4 mm\"]\nfriction_coefficient = 0.4");
  EXPECT_LT((roller.surface.center - Vec3(0, 0, 1e-3)).norm(), 1e-15);
  EXPECT_EQ(roller.surface.direction, Vec3::UnitY());
  EXPECT_DOUBLE_EQ(roller.surface.radius, 5e-4);
  EXPECT_DOUBLE_EQ(roller.surface.half_length, 1e-3);
  EXPECT_TRUE(roller.surface.inside);
  EXPECT_EQ(roller.friction_coefficient, 0.4);
  const SurfaceSpec box = read("shape = \"box\"\nsize = [\"1 mm\", \"2 mm\", \"4 mm\"]");
  EXPECT_LT((box.surface.half_size - Vec3(0.5e-3, 1e-3, 2e-3)).norm(), 1e-15);
}

// In millimetres, as people write it: the run has other units.
TEST(SurfaceScenes, AMeshPushesAsTheBoxThatItIs) {
  const auto reaction = [](const std::string& keys) {
    std::string clamps;
    for (const auto& [name, end, x] : {std::tuple{"left", "start", 0}, {"right", "end", 4}})
      clamps += fmt::format(
          "[[body]]\nname = \"{}\"\nposition = [\"{} mm\", \"0 mm\", \"0 mm\"]\n[[body.tie]]\n"
          "fibers = \"beam\"\nend = \"{}\"\n",
          name, x, end);
    const Scene scene =
        parse_scene(scene_of(clamps +
                             "[[body]]\nname = \"punch\"\nposition = [\"2 mm\", \"0 mm\", \"0.6 mm\"]\n"
                             "[[body.surface]]\n" +
                             keys +
                             "\n[[stage]]\nname = \"push\"\nincrements = 4\n"
                             "[[stage.drive]]\nbodies = \"punch\"\ndof = \"z\"\ndisplacement = \"-0.1 mm\"\n"),
                    "s.toml");
    const auto result = test::run_scene(scene);
    EXPECT_TRUE(result.done()) << result.summary.message;
    return result.last().bodies.force.back();
  };
  std::string triangles;
  for (const auto& t : test::box_corners({-0.4, -0.5, -0.5}, {0.4, 0.5, 0.5})) {
    triangles += triangles.empty() ? "[" : ", [";
    for (const Vec3& p : t) triangles += fmt::format("{}[{}, {}, {}]", &p == t.data() ? "" : ", ", p.x(), p.y(), p.z());
    triangles += "]";
  }
  const Vec3 by_box = reaction("shape = \"box\"\nsize = [\"0.8 mm\", \"1 mm\", \"1 mm\"]"),
             by_mesh = reaction("shape = \"mesh\"\nunit = \"1 mm\"\ntriangles = [" + triangles + "]");
  EXPECT_LT(by_box.z(), -1e-3);
  EXPECT_LT((by_mesh - by_box).norm(), 1e-6 * by_box.norm());
}

TEST(SurfaceScenes, WhatIsWrongIsToldWithItsKey) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> cases = {
      {"shape = \"cone\"",
       {"body[1].surface[1].shape = \"cone\"", "\"plane\", \"cylinder\", \"sphere\", \"box\" or \"mesh\""}},
      {"shape = \"plane\"", {"body[1].surface[1].normal: missing", "what a plane needs"}},
      {"shape = \"plane\"\nnormal = [0, 0, 0]", {"surface[1].normal", "must have a direction"}},
      {"shape = \"sphere\"", {"surface[1].radius: missing"}},
      {"shape = \"sphere\"\nradius = \"-1 mm\"", {"surface[1].radius", "greater than 0"}},
      {"shape = \"sphere\"\nradius = \"1 mm\"\naxis = [1, 0, 0]",
       {"surface[1].axis", "is none of a sphere", "\"radius\" or \"inside\""}},
      {"shape = \"box\"\nsize = [\"1 mm\", \"0 mm\", \"1 mm\"]", {"surface[1].size", "three lengths greater than 0"}},
      {"shape = \"box\"\nsize = [\"1 mm\", \"1e9 mm\", \"1 mm\"]", {"surface[1].size", "at most"}},
      {"shape = \"sphere\"\nradius = \"1 mm\"\nfriction_coefficient = -1",
       {"surface[1].friction_coefficient", "at least 0 and at most 10"}},
      {"shape = \"sphere\"\nradius = \"1 mm\"\nfrom_stage = \"secnd\"",
       {"surface[1].from_stage = \"secnd\"", "did you mean \"second\"?"}},
      {"shape = \"sphere\"\nradius = \"1 mm\"\ntouch = true", {"surface[1].touch", "is none of a sphere"}}};
  for (const auto& [keys, mentions] : cases) expect_mentions(error_of(keys), mentions);
  expect_mentions(
      error_of("shape = \"plane\"\nnormal = [0, 0, 1]\ntouch = true\n[[body.tie]]\nfibers = \"beam\"\nend = \"end\""),
      {"surface[1].touch", "ties fiber ends"});
}

TEST(SurfaceScenes, OfACellAreLevelPlanes) {
  const std::string weave =
      "[weave]\npattern = \"plain\"\nperiodic = true\n[weave.warp]\nfiber_type = \"f\"\nfibers = 1\nyarns = 2\n"
      "elements = 8\nyarn_spacing = \"1 mm\"\n[weave.weft]\nfiber_type = \"f\"\nfibers = 1\nyarns = 2\nelements = 8\n"
      "yarn_spacing = \"1 mm\"\n";
  const auto with = [&](const std::string& keys) {
    return scene_of("[[body]]\nname = \"tool\"\n[[body.surface]]\n" + keys, weave);
  };
  EXPECT_EQ(input_error([&] { (void)parse_scene(with("shape = \"plane\"\nnormal = [0, 0, 1]\n"), "s.toml"); }),
            input_error([] {}));
  expect_mentions(input_error([&] { (void)parse_scene(with("shape = \"sphere\"\nradius = \"1 mm\"\n"), "s.toml"); }),
                  {"surface[1].shape", "must be a plane with a normal along z"});
}

// Without contact between fibers, [contact] is about surfaces.
TEST(SurfaceScenes, AreTouchedWhereFibersDoNotTouchEachOther) {
  const std::string text = surface("shape = \"sphere\"\nradius = \"1 mm\"") +
                           "[effects]\ncontact = \"none\"\n[contact]\nfriction_coefficient = 0.7\n";
  const Scene scene = parse_scene(text, "s.toml");
  EXPECT_TRUE(scene.contact.friction);
  EXPECT_EQ(scene.contact.friction_coefficient, 0.7);
}

/// The fiber, clamped at its start, and a plane above that is pressed down in the second of two stages.
Scene pressed(const std::string& surface_keys) {
  return parse_scene(scene_of("[[body]]\nname = \"wall\"\n[[body.tie]]\nfibers = \"beam\"\nend = \"start\"\n"
                              "[[body]]\nname = \"plane\"\nposition = [\"2 mm\", \"0 mm\", \"7 mm\"]\n"
                              "[[body.surface]]\nshape = \"plane\"\nnormal = [0, 0, -1]\n" +
                              surface_keys +
                              "[effects]\nfriction = false\n"
                              "[[stage]]\nname = \"wait\"\nincrements = 1\n[[stage.drive]]\nbodies = \"plane\"\n"
                              "dof = \"z\"\ndisplacement = \"-20 mm\"\n"
                              "[[stage]]\nname = \"press\"\nincrements = 2\n[[stage.drive]]\nbodies = \"plane\"\n"
                              "dof = \"ry\"\ndisplacement = \"2 deg\"\n"),
                     "s.toml");
}

TEST(SurfaceScenes, ComeInWithTheirStageWhereTheyTouch) {
  const auto result = test::run_scene(pressed("from_stage = \"press\"\ntouch = true\n"));
  ASSERT_TRUE(result.done()) << result.summary.message;
  ASSERT_EQ(result.increments.size(), 4u);
  const auto plane_at = [&](std::size_t i) { return result.increments[i].bodies.position[1].z(); };
  EXPECT_DOUBLE_EQ(plane_at(1), 7e-3 - 20e-3) << "not there yet, it passes through";
  EXPECT_EQ(result.increments[1].bodies.force[1], Vec3::Zero());
  // It comes down on the upper side of the fiber and then turns against its end, about the fiber's middle.
  EXPECT_NEAR(plane_at(3), 1e-4, 1e-9);
  EXPECT_LT(result.last().bodies.force[1].z(), 0);
  EXPECT_NEAR(result.tip().z(), -2e-3 * std::tan(2 * std::numbers::pi / 180), 2e-6);
}

TEST(SurfaceScenes, AreAnEffectWithAPrice) {
  const auto prices = [](const std::vector<EffectCost>& effects) {
    return std::count_if(effects.begin(), effects.end(), [](const EffectCost& cost) {
      return cost.effect == PricedEffect::surfaces && cost.seconds > 0;
    });
  };
  Scene scene = pressed("");
  scene.bodies[1].position.z() = 1e-4;
  EXPECT_EQ(prices(estimate_cost(scene).effects), 1);
  scene.bodies[1].surfaces.clear();
  EXPECT_EQ(prices(estimate_cost(scene).effects), 0);
}

TEST(SurfaceScenes, FiberBehindOneIsRefused) {
  Scene scene = pressed("");
  scene.stages.pop_back();
  scene.bodies[1].position.z() = -7e-3;  // below the fiber, which lies on its back
  scene.stages[0].drives.clear();
  const auto result = test::run_scene(scene);
  EXPECT_FALSE(result.done());
  expect_mentions(result.summary.message, {"behind the surface of body \"plane\"", "beam"});
}

TEST(SurfaceScenes, CompactionOfABundle) {
  const std::string bundle =
      "[[bundle]]\nname = \"tow\"\nfiber_type = \"f\"\npoints = [[\"0 mm\", \"0 mm\", \"0 mm\"], "
      "[\"4 mm\", \"0 mm\", \"0 mm\"]]\nelements = 4\nfibers = 7\n";
  const Scene scene = parse_scene(scene_of("[[body]]\nname = \"a\"\n[[body.tie]]\nfibers = \"tow\"\nend = \"start\"\n"
                                           "[test]\nkind = \"compaction\"\nstrain = \"20 %\"\nincrements = 4\n",
                                           bundle),
                                  "s.toml");
  EXPECT_EQ(scene.stages.back().name, "compaction");
  EXPECT_EQ(scene.contact.target_penetration, 0.001);
  const auto result = test::run_scene(scene);
  ASSERT_TRUE(result.done()) << result.summary.message;
  const BodyRecord& bodies = result.last().bodies;
  EXPECT_LT(bodies.force[1].z(), 0);
  EXPECT_NEAR(bodies.force[1].z() / bodies.force[2].z(), -1, 1e-3);
  // As far as it was high: three fibers of a hexagon, two distances of the lattice.
  const double height = 0.2e-3 * (1 + 1.05 * std::sqrt(3.0));
  EXPECT_NEAR((bodies.position[1].z() - bodies.position[2].z()) / (0.8 * height), 1, 0.01);
  expect_mentions(input_error([&] {
                    (void)parse_scene(scene_of("[test]\nkind = \"compaction\"\nstrain = 1.5\n", bundle), "s.toml");
                  }),
                  {"test.strain", "less than 1"});
}

}  // namespace
}  // namespace trame::micro
