/// \file
/// Large bending of a cantilever against published and closed solutions, through the whole program.

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "tests/support/reference_table.h"
#include "tests/support/run_scene.h"
#include "tests/support/shooting.h"

namespace trame::micro {
namespace {

using test::cantilever;
using test::run_scene;

constexpr double length = 400;                    // of a fiber of radius 1: EA L²/EI = 640,000
constexpr double bending = std::numbers::pi / 4;  // E I

struct Fiber {
  const char* name;
  FiberModel model;
  double poisson_ratio;
};
constexpr Fiber fibers[] = {{"enriched, nu 0", FiberModel::enriched, 0},
                            {"enriched, nu 0.39", FiberModel::enriched, 0.39},
                            {"rod", FiberModel::rod, 0.39}};

/// Bending in the plane x z: what a rod, which has no torsion, can do as well.
Scene planar_cantilever(const Fiber& fiber, Index n_elements, Index n_increments, double force, double moment) {
  Scene scene = cantilever(fiber.model, fiber.poisson_ratio, length, n_elements);
  Stage stage;
  stage.name = "bend";
  stage.n_increments = n_increments;
  stage.drives = {{"tip", BodyDof::x, DriveMode::force, 0, ""},
                  {"tip", BodyDof::z, DriveMode::force, force, ""},
                  {"tip", BodyDof::ry, DriveMode::force, moment, ""}};
  scene.stages = {stage};
  return scene;
}

TEST(Elastica, ShootingMeetsThePublishedTable) {
  // No stretch, no shear: the reference solution of the other tests stands on its own feet to all 5 decimals.
  for (const auto& row : trame::test::reference_table("elastica_end_force")) {
    test::RodProblem rod;
    constexpr double infinite = std::numeric_limits<double>::infinity();
    rod.section = {infinite, infinite, 1, 1, 0, false};
    rod.length = 1;
    rod.end_force = Vec3(0, 0, row[0]);
    const Vec3 tip = test::shoot_rod(rod).r;
    EXPECT_NEAR(tip.z(), row[1], 0.6e-5);
    EXPECT_NEAR(1 - tip.x(), row[2], 0.6e-5);
  }
}

TEST(Elastica, EndForce) {
  // Of order P/EA = 1.6e-5 and P/GA = 4e-5 is what stretch and shear add, 5e-6 the rounding of the table; the
  // discretisation error of 40 elements is below both (see convergence_test.cpp).
  constexpr double tolerance = 5e-5;
  for (const Fiber& fiber : fibers)
    for (const auto& row : trame::test::reference_table("elastica_end_force")) {
      const double force = row[0] * bending / (length * length);
      const auto result = run_scene(planar_cantilever(fiber, 40, 10, force, 0));
      ASSERT_TRUE(result.done()) << fiber.name << ": " << result.summary.message;
      EXPECT_NEAR(result.tip().z() / length, row[1], tolerance) << fiber.name << ", P = " << row[0];
      EXPECT_NEAR(1 - result.tip().x() / length, row[2], tolerance) << fiber.name << ", P = " << row[0];
    }
}

TEST(Elastica, ReactionsAtTheClamp) {
  const double force = 2 * bending / (length * length);
  const auto result = run_scene(planar_cantilever(fibers[1], 40, 10, force, 0));
  ASSERT_TRUE(result.done());
  const BodyRecord& bodies = result.last().bodies;  // wall, tip
  // Equilibrium, to the tolerance of the solver relative to the force that it measures with (the stiff axial one).
  EXPECT_NEAR(bodies.force[0].z(), -force, 1e-4 * force);
  EXPECT_NEAR(bodies.force[1].z(), force, 1e-4 * force);
  EXPECT_NEAR(bodies.moment[0].y(), force * result.tip().x(), 1e-4 * force * length);
}

TEST(Elastica, RollsUpToACircle) {
  // κ = M/EI closes the fiber. The quadratic measures shorten it and squeeze its sections by R²κ²/4 = 6e-5 each, so it
  // turns by 4 · 6e-5 · 2π = 1.5e-3 rad too far; half-way around it is the diameter L/π away.
  for (const Fiber& fiber : fibers) {
    const double moment = -2 * std::numbers::pi * bending / length;  // about y: turns x towards z
    const auto result = run_scene(planar_cantilever(fiber, 20, 16, 0, moment));
    ASSERT_TRUE(result.done()) << fiber.name << ": " << result.summary.message;
    EXPECT_LT(result.tip().norm(), 2e-3 * length) << fiber.name;
    const Vec3 half_way = result.last().fibers.r[result.last_node(0) / 2];
    EXPECT_NEAR(half_way.z(), length / std::numbers::pi, 1e-3 * length) << fiber.name;
    EXPECT_NEAR(half_way.x(), 0, 1e-3 * length) << fiber.name;
    EXPECT_LT((result.last().bodies.rotation[1] - Mat3::Identity()).norm(), 5e-3) << fiber.name;  // of the tip
    // With stresses that follow strains of their own each turn of 22° takes no more than a small one.
    EXPECT_LE(result.summary.n_newton_iterations, 7 * 16) << fiber.name;
  }
}

}  // namespace
}  // namespace trame::micro
