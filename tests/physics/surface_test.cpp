/// \file
/// Fibers on rigid surfaces: beams that are pushed, a rope on a drum, plates that press and rub.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/meshes.h"
#include "tests/support/run_scene.h"

namespace trame::micro {
namespace {

using std::numbers::pi;

Surface cylinder_along_y(double radius) { return {SurfaceShape::cylinder, Vec3::Zero(), Vec3::UnitY(), radius}; }
Surface level_plane(double normal) { return {SurfaceShape::plane, Vec3::Zero(), normal * Vec3::UnitZ()}; }

Stage stage(const std::string& name, Index n_increments) {
  Stage stage;
  stage.name = name;
  stage.n_increments = n_increments;
  return stage;
}

/// A beam of radius 1 along x, clamped at both ends, that nothing touches but surfaces.
Scene clamped_beam(FiberModel model, double length, Index n_elements) {
  Scene scene = test::cantilever(model, 0.3, length, n_elements);
  scene.contact.friction = false;
  scene.solver = {};
  return scene;
}

double largest_imbalance(const BodyRecord& bodies) {
  Vec3 sum = Vec3::Zero();
  double largest = 0;
  for (const Vec3& f : bodies.force) {
    sum += f;
    largest = std::max(largest, f.norm());
  }
  return sum.norm() / largest;
}

// F = 192 E I w/L³ (1 + 0.06 A w²/I), the second term for the tension that comes up as the beam stretches.
TEST(Surfaces, BeamThatACylinderPushes) {
  const double length = 200, w = 0.4;
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    Scene scene = clamped_beam(model, length, 20);
    scene.bodies.push_back({"drum", {length / 2, 0, -11}, {}, {{cylinder_along_y(10), {}, {}}}});
    Stage push = stage("push", 2);
    push.drives = {{"drum", BodyDof::z, DriveMode::displacement, w, ""}};
    scene.stages = {push};
    const auto result = test::run_scene(scene);
    ASSERT_TRUE(result.done()) << result.summary.message;
    const double expected = 192 * pi / 4 * w / std::pow(length, 3) * (1 + 0.24 * w * w);
    EXPECT_NEAR(result.last().bodies.force[2].z() / expected, 1, 0.01);
    EXPECT_LT(largest_imbalance(result.last().bodies), 1e-5);
    EXPECT_LT(result.last().solver.max_penetration_over_radius, 0.01);
  }
}

/// A rope that lies on a quarter or more of a drum and is hauled, or is held and rubbed by the drum that turns.
struct Drum {
  double friction = 0.3, wrap = pi, radius = 80;
  FiberModel rope = FiberModel::enriched;
  double tension = 2e-3;  ///< in E R²
  double distance = 0.5;  ///< far enough for all of it to slide
  bool turns = false;
};

Scene drum_scene(const Drum& d) {
  const double axis = d.radius + 1, tail = 0.5 * d.radius, rise = 4;  // of a turn, so that it lies beside itself
  const double first = 0.5 * (pi - d.wrap), last = first + d.wrap;
  const auto place = [&](double angle) {
    return Vec3(axis * std::cos(angle), rise * (angle - first) / (2 * pi), axis * std::sin(angle));
  };
  const auto tangent = [](double angle) { return Vec3(-std::sin(angle), 0, std::cos(angle)); };
  std::vector<Vec3> points;
  constexpr int n_tail = 4, n_arc = 48;
  for (int i = 0; i < n_tail; ++i) points.push_back(place(first) - tail * (1 - i / double(n_tail)) * tangent(first));
  for (int i = 0; i <= n_arc; ++i) points.push_back(place(first + d.wrap * i / n_arc));
  for (int i = 1; i <= n_tail; ++i) points.push_back(place(last) + tail * (i / double(n_tail)) * tangent(last));
  Scene scene;
  scene.name = "drum";
  scene.materials = {test::isotropic(1, 0.3)};
  scene.fiber_types = {{"rope", 0, 1.0, d.rope}};
  scene.fibers = {{"rope", 0, points, static_cast<Index>(std::lround(16 + 24 * d.wrap / pi)), {}}};
  scene.bodies = {{"drum", Vec3::Zero(), {}, {{cylinder_along_y(d.radius), d.friction, {}}}},
                  {"brake", points.front(), {{"rope", FiberEnd::start, {}}}},
                  {"haul", points.back(), {{"rope", FiberEnd::end, {}}}}};
  const auto pull = [&](const std::string& body, const Vec3& direction) {
    std::vector<Drive> drives;
    for (const int c : {0, 2})
      drives.push_back({body, static_cast<BodyDof>(c), DriveMode::force, d.tension * direction[c], ""});
    return drives;
  };
  Stage tighten = stage("tighten", 5);
  tighten.friction = false;
  tighten.proximal_start = 1e-4;
  tighten.drives = pull("brake", -tangent(first));
  for (const Drive& drive : pull("haul", tangent(last))) tighten.drives.push_back(drive);
  Stage rub = stage("rub", 10);
  rub.drives = pull("brake", -tangent(first));
  if (d.turns)
    rub.drives.push_back({"drum", BodyDof::ry, DriveMode::displacement, d.distance / d.radius, ""});
  else
    for (const int c : {0, 2})
      rub.drives.push_back(
          {"haul", static_cast<BodyDof>(c), DriveMode::displacement, d.distance * tangent(last)[c], ""});
  scene.stages = {tighten, rub};
  return scene;
}

// Friction acts at the rope's surface, the tension at its axis: T₂/T₁ = exp(µφ ρ/(ρ + R)).
void expect_capstan(const Drum& d) {
  const auto result = test::run_scene(drum_scene(d));
  ASSERT_TRUE(result.done()) << result.summary.message;
  const BodyRecord& bodies = result.last().bodies;
  const double ratio = std::max(bodies.force[2].norm() / bodies.force[1].norm(),
                                bodies.force[1].norm() / bodies.force[2].norm()),
               expected = std::exp(d.friction * d.wrap * d.radius / (d.radius + 1));
  fmt::print("mu {} wrap {:.0f} deg{}: {:.4f}, expected {:.4f}\n", d.friction, d.wrap * 180 / pi,
             d.turns ? ", turned" : "", ratio, expected);
  EXPECT_NEAR(ratio / expected, 1, 0.01);
  EXPECT_LT(largest_imbalance(bodies), 1e-5);
  Vec3 moment = Vec3::Zero();
  for (std::size_t b = 0; b < 3; ++b) moment += bodies.moment[b] + bodies.position[b].cross(bodies.force[b]);
  EXPECT_LT(moment.norm() / bodies.moment[0].norm(), 1e-4);
  EXPECT_GT(result.last().solver.energy.friction, 0);
}

TEST(Surfaces, RopeHauledOverADrum) {
  expect_capstan({.friction = 0.1, .wrap = pi / 2});
  expect_capstan({.friction = 0.3, .wrap = pi});
  expect_capstan({.friction = 0.5, .wrap = pi, .distance = 1});
  expect_capstan({.friction = 0.3, .wrap = 2 * pi, .distance = 3});
}

TEST(Surfaces, RopeThatADrumRubsAsItTurns) { expect_capstan({.friction = 0.3, .wrap = pi, .turns = true}); }

/// A clamped beam between two plates: the lower one lies, the upper one presses by a force and is then pushed along.
TEST(Surfaces, PlatesPressAndRub) {
  const double length = 200, press = 1e-3, friction = 0.25;
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    Scene scene = clamped_beam(model, length, 20);
    scene.contact.friction = true;
    scene.bodies.push_back({"lower", {length / 2, 0, -1}, {}, {{level_plane(1), 0.0, {}}}});
    scene.bodies.push_back({"upper", {length / 2, 0, 1}, {}, {{level_plane(-1), friction, {}}}});
    Stage pressing = stage("press", 2);
    pressing.drives = {{"upper", BodyDof::z, DriveMode::force, -press, ""}};
    Stage along = stage("rub", 5);
    along.drives = {{"upper", BodyDof::z, DriveMode::force, -press, ""},
                    {"upper", BodyDof::x, DriveMode::displacement, 1, ""}};
    scene.stages = {pressing, along};
    const auto result = test::run_scene(scene);
    ASSERT_TRUE(result.done()) << result.summary.message;
    const BodyRecord& bodies = result.last().bodies;
    EXPECT_NEAR(bodies.force[3].z() / -press, 1, 1e-5);
    EXPECT_GT(bodies.force[2].z() / press, 0.8);  // the beam's clamped ends bear the rest
    EXPECT_NEAR(bodies.force[3].x() / (friction * press), 1, 1e-4);
    EXPECT_NEAR(bodies.force[2].x() / press, 0, 1e-9);
    EXPECT_LT(largest_imbalance(bodies), 1e-5);
    // It has slid by a radius less what the slip takes up, which is little, under the same force.
    EXPECT_NEAR(result.last().solver.energy.friction / (friction * press), 0.95, 0.05);
  }
}

// A ball, and the corner of a box, of which only the shape of the part that is touched counts.
TEST(Surfaces, BeamThatABallPushesOff) {
  const double length = 200, w = 0.4;
  Scene scene = clamped_beam(FiberModel::enriched, length, 20);
  Surface ball{.shape = SurfaceShape::sphere, .radius = 30};
  scene.bodies.push_back({"ball", {length / 2, 0, -31}, {}, {{ball, {}, {}}}});
  Stage push = stage("push", 2);
  push.drives = {{"ball", BodyDof::z, DriveMode::displacement, w, ""}};
  scene.stages = {push};
  const auto by_ball = test::run_scene(scene);
  scene.bodies.back().position.z() = -5;
  scene.bodies.back().surfaces = {{{.shape = SurfaceShape::box, .half_size = {2, 4, 4}}, {}, {}}};
  const auto by_box = test::run_scene(scene);
  ASSERT_TRUE(by_ball.done() && by_box.done()) << by_ball.summary.message << by_box.summary.message;
  const double expected = 192 * pi / 4 * w / std::pow(length, 3) * (1 + 0.24 * w * w);
  EXPECT_NEAR(by_ball.last().bodies.force[2].z() / expected, 1, 0.01);
  // The box is four radii wide; the beam lifts off between its edges, where two forces push that are a fiftieth of the
  // length apart: with a = (1 - 4/L)/2 stiffer by 1/(16 a³ (2 - 3 a)).
  const double a = 0.5 * (1 - 4 / length);
  EXPECT_NEAR(by_box.last().bodies.force[2].z() / expected, 1 / (16 * a * a * a * (2 - 3 * a)), 0.01);
}

// The same box in triangles, and the ball in 2,048 of them, which is a little smaller.
TEST(Surfaces, MeshesPushAsWhatTheyAreOf) {
  const double length = 200, w = 0.4;
  const auto push_by = [&](const Surface& surface, double depth) {
    Scene scene = clamped_beam(FiberModel::enriched, length, 20);
    scene.bodies.push_back({"tool", {length / 2, 0, -depth - 1}, {}, {{surface, {}, {}}}});
    Stage push = stage("push", 2);
    push.drives = {{"tool", BodyDof::z, DriveMode::displacement, w, ""}};
    scene.stages = {push};
    const auto result = test::run_scene(scene);
    EXPECT_TRUE(result.done()) << result.summary.message;
    return result.last().bodies.force[2];
  };
  const Vec3 half(2, 4, 4);
  const Vec3 by_box = push_by({.shape = SurfaceShape::box, .half_size = half}, 4),
             by_mesh = push_by({.shape = SurfaceShape::mesh, .mesh = test::mesh_of(test::box_corners(-half, half))}, 4);
  EXPECT_NEAR((by_mesh - by_box).norm() / by_box.norm(), 0, 1e-9);
  const Vec3 by_ball = push_by({.shape = SurfaceShape::sphere, .radius = 30}, 30),
             by_triangles =
                 push_by({.shape = SurfaceShape::mesh, .mesh = test::mesh_of(test::sphere_corners(30, 4))}, 30);
  EXPECT_NEAR(by_triangles.z() / by_ball.z(), 1, 0.02);
}

// Whatever the increments, a beam does not get through.
TEST(Surfaces, NothingPassesThrough) {
  for (const double way : {3.0, 30.0, 60.0}) {
    Scene scene = test::cantilever(FiberModel::rod, 0.3, 100, 10);
    scene.contact.friction = false;
    scene.solver = {};
    scene.bodies.push_back({"rod", {60, 0, 0.5 * way + 2}, {}, {{cylinder_along_y(1.5), {}, {}}}});
    Stage push = stage("push", 1);
    push.drives = {
        {"rod", BodyDof::z, DriveMode::displacement, -way, ""}, {"tip", BodyDof::x, DriveMode::force, 0, ""},
        {"tip", BodyDof::y, DriveMode::force, 0, ""},           {"tip", BodyDof::z, DriveMode::force, 0, ""},
        {"tip", BodyDof::rx, DriveMode::force, 0, ""},          {"tip", BodyDof::ry, DriveMode::force, 0, ""},
        {"tip", BodyDof::rz, DriveMode::force, 0, ""}};
    scene.stages = {push};
    const auto result = test::run_scene(scene);
    ASSERT_TRUE(result.done()) << result.summary.message;
    const Increment& last = result.last();
    for (const Vec3& r : last.fibers.r) {
      const Vec3 from = r - last.bodies.position[2];
      EXPECT_GT(std::hypot(from.x(), from.z()), 2.4) << "way " << way;
    }
    EXPECT_LT(result.tip().z(), -0.3 * way) << "way " << way;
  }
}

}  // namespace
}  // namespace trame::micro
