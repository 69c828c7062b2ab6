/// \file
/// The 45° bend of Bathe & Bolourchi (1979): bending, torsion and an initially curved fiber in space.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/reference_table.h"
#include "tests/support/run_scene.h"
#include "tests/support/shooting.h"

namespace trame::micro {
namespace {

constexpr double bend_radius = 100, young_modulus = 1e7;
const double section_radius = std::pow(1 / (3 * std::numbers::pi), 0.25);  // EI of the unit square

Vec3 point_of_bend(double angle) { return bend_radius * Vec3(std::sin(angle), 1 - std::cos(angle), 0); }

Scene bend(Index n_elements, double force) {
  Scene scene = test::cantilever(FiberModel::enriched, 0, 1, n_elements);
  scene.materials = {test::isotropic(young_modulus, 0)};
  scene.fiber_types[0].radius = section_radius;
  scene.fibers[0].points.clear();
  constexpr int n_chords = 64;  // the spline through so many points is the circle to 1e-9
  for (int i = 0; i <= n_chords; ++i)
    scene.fibers[0].points.push_back(point_of_bend(0.25 * std::numbers::pi * i / n_chords));
  scene.bodies[1].position = point_of_bend(0.25 * std::numbers::pi);
  Stage stage;
  stage.name = "push";
  stage.n_increments = 10;
  stage.drives = test::free_body("tip", Vec3(0, 0, force));
  scene.stages = {stage};
  return scene;
}

Vec3 tip_by_shooting(double force) {
  test::RodProblem rod;
  rod.section = test::circular_section(young_modulus, 0, section_radius);
  rod.length = 0.25 * std::numbers::pi * bend_radius;
  rod.curvature = Vec3(0, 0, 1 / bend_radius);
  rod.end_force = Vec3(0, 0, force);
  return test::shoot_rod(rod).r;
}

TEST(Bend45Degrees, ShootingIsCloseToThePublishedTip) {
  // Published with one decimal, from 8 straight elements with a square section: later solutions scatter by 1 %.
  for (const auto& row : trame::test::reference_table("bend_45_degrees"))
    EXPECT_LT((tip_by_shooting(row[0]) - Vec3(row[1], row[2], row[3])).norm(), 0.01 * bend_radius);
}

TEST(Bend45Degrees, FiberMeetsShooting) {
  for (const double force : {300.0, 600.0}) {
    const auto result = test::run_scene(bend(16, force));
    ASSERT_TRUE(result.done()) << result.summary.message;
    const Vec3 expected = tip_by_shooting(force);
    // 16 elements of an angle of 0.05 at rest: (0.05)⁴ = 6e-6, and as much again from the bending under load.
    EXPECT_LT((result.tip() - expected).norm(), 2e-5 * bend_radius)
        << "tip " << result.tip().transpose() << ", expected " << expected.transpose();
  }
}

}  // namespace
}  // namespace trame::micro
