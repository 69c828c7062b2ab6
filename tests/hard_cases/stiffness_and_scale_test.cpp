/// \file
/// Hard cases of stiffness and slenderness: moduli 10⁶ apart, Poisson's ratio up to 0.499, squeezed sections, extreme
/// anisotropy.

#include <numbers>

#include "tests/support/hard_case.h"

namespace trame::micro {
namespace {

using namespace test;

constexpr double pi = std::numbers::pi;

/// Crossed fibers, the upper one softer (or stiffer) by `ratio`, pressed by a force that suits the softer one.
RunResult unequal_pair(double under_modulus, double over_modulus, double load) {
  Pair pair;
  pair.angle = pi / 2;
  pair.height = 1.99;
  pair.length = 20;
  pair.n_elements = 6;
  Scene scene = pair_scene(pair);
  scene.materials = {isotropic(under_modulus, 0.3), isotropic(over_modulus, 0.3)};
  scene.materials[1].name = "n";
  scene.fiber_types = {{"under", 0, 1.0, FiberModel::enriched}, {"over", 1, 1.0, FiberModel::enriched}};
  scene.fibers[1].type = 1;
  scene.solver.geometry_tolerance = 1e-4;
  scene.stages = {stage_with("press", 6, {force("grip", BodyDof::z, -load)})};
  return run_scene(scene);
}

/// The contact of a pair carries the load that presses it, and it is not deep.
void expect_carried(const RunResult& result, double load) {
  const double error = std::abs(normal_resultant(result.last()).z() / load - 1);
  measured(fmt::format("load error {:.1e}, penetration {:.3f} R, {} Newton iterations, {} cuts", error,
                       penetration(result.last()), result.summary.n_newton_iterations,
                       result.summary.n_cut_increments));
  EXPECT_LT(error, 1e-2);
  EXPECT_LT(penetration(result.last()), 0.1);
}

TEST(Stiffness, RatioOfAMillion) {
  for (const auto& [under, over] : {std::pair{1.0, 1e-6}, std::pair{1e-6, 1.0}}) {
    const double load = 2e-3 * 1e-6;
    const RunResult result = unequal_pair(under, over, load);
    expect_done(result);
    const double error = std::abs(normal_resultant(result.last()).z() / load - 1);
    measured(fmt::format(
        "moduli {} under, {} over: load error {:.1e}, penetration {:.3f} R, {} Newton iterations, {} cuts", under, over,
        error, penetration(result.last()), result.summary.n_newton_iterations, result.summary.n_cut_increments));
    EXPECT_LT(error, 1e-2);
    EXPECT_LT(penetration(result.last()), 0.2);
  }
}

TEST(Stiffness, WhatNoFiberHasChangesNothing) {
  Pair pair;
  pair.angle = pi / 2;
  pair.height = 1.99;
  pair.length = 20;
  pair.n_elements = 6;
  Scene scene = pair_scene(pair);
  scene.stages = {stage_with("press", 3, {displacement("grip", BodyDof::z, -0.5)})};
  const RunResult alone = run_scene(scene);
  scene.materials.push_back(isotropic(1e30, 0));
  scene.materials.back().name = "unobtainium";
  scene.fiber_types.push_back({"unused", 1, 1e9, FiberModel::rod});
  const RunResult result = run_scene(scene);
  expect_done(alone);
  expect_done(result);
  ASSERT_GT(normal_resultant(alone.last()).norm(), 0);
  EXPECT_EQ(normal_resultant(result.last()), normal_resultant(alone.last()));
  EXPECT_EQ(result.last().fibers.r, alone.last().fibers.r);
  EXPECT_EQ(result.summary.n_newton_iterations, alone.summary.n_newton_iterations);
}

TEST(Stiffness, SoftFiberBesideAStiffOneUnderTension) {
  // The stiff fiber is pulled by 1 % while the soft one is pressed on it by a force 10⁷ times smaller. The residual is
  // judged by the sum of all forces: what is left may be more than all that the soft fiber feels.
  const double load = 2e-3 * 1e-6;
  Pair pair;
  pair.angle = pi / 2;
  pair.height = 1.99;
  pair.length = 20;
  pair.n_elements = 6;
  for (const double tolerance : {1e-4, 1e-10}) {
    Scene scene = pair_scene(pair);
    scene.materials = {isotropic(1, 0.3), isotropic(1e-6, 0.3)};
    scene.materials[1].name = "n";
    scene.fiber_types = {{"under", 0, 1.0, FiberModel::enriched}, {"over", 1, 1.0, FiberModel::enriched}};
    scene.fibers[1].type = 1;
    scene.bodies[0].ties = {{"under", FiberEnd::start, TieKind::clamped}};
    scene.bodies.push_back({"puller", {10, 0, 0}, {{"under", FiberEnd::end, TieKind::clamped}}});
    scene.solver.force_tolerance = tolerance;
    scene.solver.geometry_tolerance = 100 * tolerance;
    scene.stages = {
        stage_with("press", 6, {force("grip", BodyDof::z, -load), displacement("puller", BodyDof::x, 0.2)})};
    const RunResult result = run_scene(scene);
    expect_clear_status(result);
    const double error = std::abs(normal_resultant(result.last()).z() / load - 1);
    measured(fmt::format("tolerance {:.0e}: {}, load error {:.1e}, penetration {:.3f} R", tolerance,
                         result.done() ? "done" : "gave up", error, penetration(result.last())));
    if (tolerance < 1e-6) {
      EXPECT_TRUE(result.done());
      EXPECT_LT(error, 1e-2);
    }
  }
}

TEST(Stiffness, PoissonsRatioUpToAHalf) {
  // Bending by a tip force, slender enough for Euler–Bernoulli with shear, 3 EI/(GA L²); tension, with its lateral
  // contraction.
  constexpr double length = 40, deflection = 0.2, strain = 1e-3;
  for (const double nu : {-0.9, 0.0, 0.3, 0.45, 0.49, 0.499}) {
    Scene scene = cantilever(FiberModel::enriched, nu, length, 8);
    scene.solver.force_tolerance = scene.solver.geometry_tolerance = 1e-5;
    Scene pulled = scene;
    const double load = deflection * 3 * (pi / 4) / (length * length * length);
    scene.stages = {stage_with(
        "bend", 2, {force("tip", BodyDof::z, load), force("tip", BodyDof::ry, 0), force("tip", BodyDof::x, 0)})};
    const RunResult bent = run_scene(scene);
    expect_done(bent);
    const double shear = 3 * (pi / 4) * 2 * (1 + nu) / (pi * length * length);
    const double bending_error = bent.tip().z() / (deflection * (1 + shear)) - 1;

    pulled.stages = {stage_with("pull", 2, {displacement("tip", BodyDof::x, strain * length)})};
    const RunResult stretched = run_scene(pulled);
    expect_done(stretched);
    // Green–Lagrange strains follow Hooke's law: |g|² − 1 = −nu (λ² − 1). Mean over an element: nodal values of
    // sections swing about it, because two Gauss points leave (2, −1, 2)/3 without energy.
    const std::vector<Vec3>& g = stretched.last().fibers.g1;
    const Index middle = stretched.last_node(0) / 2;
    const double width = ((g[middle] + g[middle + 2]) / 6 + 2 * g[middle + 1] / 3).squaredNorm() - 1;
    // The strain there: end elements, held at their clamps, stretch less.
    const std::vector<Vec3>& r = stretched.last().fibers.r;
    const double stretch = (r[middle + 2] - r[middle]).norm() / (length / 8);
    const double contraction = -width / (stretch * stretch - 1);
    measured(
        fmt::format("nu {}: bending error {:.1e}, contraction over strain {:.5f}", nu, bending_error, contraction));
    EXPECT_LT(std::abs(bending_error), 2e-3);
    EXPECT_NEAR(contraction, nu, 3e-3);
  }
}

TEST(Stiffness, NearlyIncompressibleFibersPressed) {
  Pair pair;
  pair.angle = pi / 2;
  pair.height = 1.99;
  pair.length = 20;
  pair.n_elements = 6;
  Scene scene = pair_scene(pair);
  scene.materials = {isotropic(1, 0.499)};
  scene.solver.geometry_tolerance = 1e-4;
  scene.stages = {stage_with("press", 6, {force("grip", BodyDof::z, -0.02)})};
  const RunResult result = run_scene(scene);
  expect_done(result);
  expect_carried(result, 0.02);
}

TEST(Stiffness, SectionSqueezedToSixTenthsOfItsHeight) {
  // A fiber between two stiff rods that run along its middle half: they close until 0.62 of its height is left. The law
  // is linear between Green–Lagrange strain and second Piola stress, whose nominal stress falls again below a stretch
  // of 1/√3: beyond that, sections between two samples of contact no longer go with them.
  Scene scene;
  scene.name = "squeezed";
  scene.materials = {isotropic(1, 0.3)};
  scene.fiber_types = {{"f", 0, 1.0, FiberModel::enriched}, {"rod", 0, 1.0, FiberModel::rod}};
  scene.fibers = {{"f", 0, {{-20, 0, 0}, {20, 0, 0}}, 16, {}},
                  {"low", 1, {{-10, 0, -2}, {10, 0, -2}}, 8, {}},
                  {"high", 1, {{-10, 0, 2}, {10, 0, 2}}, 8, {}}};
  scene.bodies = {{"ends", {0, 0, 0}, {{"f", FiberEnd::start, {}}, {"f", FiberEnd::end, {}}}},
                  {"floor", {0, 0, -2}, {{"low", FiberEnd::start, {}}, {"low", FiberEnd::end, {}}}},
                  {"press", {0, 0, 2}, {{"high", FiberEnd::start, {}}, {"high", FiberEnd::end, {}}}}};
  // Stiffer rods, so that they do not bend away.
  scene.materials.push_back(isotropic(1e4, 0.3));
  scene.materials[1].name = "stiff";
  scene.fiber_types[1].material = 1;
  scene.contact.friction = false;
  scene.stages = {
      stage_with("squeeze", 20, {displacement("floor", BodyDof::z, 0.38), displacement("press", BodyDof::z, -0.38)})};
  const RunResult result = run_scene(scene);
  expect_clear_status(result);
  const Index middle = result.last_node(0) / 2;
  const Increment& last = result.last();
  const double height = std::hypot(last.fibers.g1[middle].z(), last.fibers.g2[middle].z());
  measured(fmt::format(
      "{}: height {:.3f} of the first, penetration {:.3f} R, force {:.3f} E R^2, {} Newton iterations, {} cuts",
      result.done() ? "done" : "gave up at " + std::to_string(last.stage_time), height, penetration(last),
      last.bodies.force[1].z(), result.summary.n_newton_iterations, result.summary.n_cut_increments));
  EXPECT_TRUE(result.done()) << result.summary.message;
  EXPECT_LT(height, 0.7);
  EXPECT_GT(height, 0.6);
}

TEST(Stiffness, FibersAThousandTimesStifferAlongThanAcross) {
  Pair pair;
  pair.angle = pi / 2;
  pair.height = 1.99;
  pair.length = 20;
  pair.n_elements = 6;
  Scene scene = pair_scene(pair);
  scene.materials = {{"aligned", 1, 1e-3, 1e-3, 0.3, 0.3}};
  scene.solver.geometry_tolerance = 1e-4;
  const double load = 2e-5;
  scene.stages = {stage_with("press", 6, {force("grip", BodyDof::z, -load)})};
  const RunResult result = run_scene(scene);
  expect_done(result);
  expect_carried(result, load);
}

TEST(Stiffness, SlenderAsAHair) {
  // L/R = 10⁴: EA L²/EI = 4·10⁸. Elastica with P L²/EI = 1: tip deflection 0.30172 L (Mattiasson 1981).
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    const double length = 1e4;
    Scene scene = cantilever(model, 0.3, length, 20);
    const double load = (pi / 4) / (length * length);
    scene.solver.force_tolerance = scene.solver.geometry_tolerance = 1e-5;
    scene.solver.min_increment = 2e-3;
    scene.stages = {stage_with(
        "bend", 50, {force("tip", BodyDof::z, load), force("tip", BodyDof::x, 0), force("tip", BodyDof::ry, 0)})};
    const RunResult result = run_scene(scene);
    expect_clear_status(result);
    const double error = result.tip().z() / length / 0.30172 - 1;
    measured(fmt::format("{}: {}, deflection error {:.1e}, {} Newton iterations, {} cuts",
                         model == FiberModel::rod ? "rod" : "enriched", result.done() ? "done" : "gave up", error,
                         result.summary.n_newton_iterations, result.summary.n_cut_increments));
    // Stretch and shear are 10⁸ times stiffer than bending here: each step that bends the fiber stretches it by its
    // square.
    EXPECT_TRUE(result.done()) << result.summary.message;
    EXPECT_LT(std::abs(error), 1e-3);
  }
}

}  // namespace
}  // namespace trame::micro
