/// \file
/// Hard cases of stability: buckling under compression, far into the post-buckling range, snap-through by displacement
/// and by load.

#include <numbers>

#include "tests/support/hard_case.h"

namespace trame::micro {
namespace {

using namespace test;

constexpr double pi = std::numbers::pi, bending = pi / 4;

/// Complete elliptic integrals K(k), E(k) by the arithmetic–geometric mean.
std::pair<double, double> elliptic(double k) {
  double a = 1, b = std::sqrt(1 - k * k), c = k, sum = 0.5 * c * c, weight = 0.5;
  for (int i = 0; i < 40 && std::abs(c) > 1e-17; ++i) {
    const double mean = 0.5 * (a + b);
    c = 0.5 * (a - b);
    b = std::sqrt(a * b);
    a = mean;
    weight *= 2;
    sum += weight * c * c;
  }
  const double big_k = pi / (2 * a);
  return {big_k, big_k * (1 - sum)};
}

/// Load over Euler's load of an inextensible column that has been shortened by a share `shortening` of its length:
/// P/P_E = (2K/π)², shortening = 2 (1 − E/K).
double elastica_load(double shortening) {
  double low = 0, high = 0.95;
  for (int i = 0; i < 60; ++i) {
    const double k = 0.5 * (low + high);
    const auto [big_k, big_e] = elliptic(k);
    (2 * (1 - big_e / big_k) < shortening ? low : high) = k;
  }
  const double big_k = elliptic(low).first;
  return std::pow(2 * big_k / pi, 2);
}

/// A column clamped at both ends with a slight bow, shortened by a share of its length.
Scene column(FiberModel model, double length, double bow, double shortening, Index n_increments) {
  Scene scene = cantilever(model, 0.3, length, 20);
  if (bow != 0) scene.fibers[0].points = {{0, 0, 0}, {0.5 * length, 0, bow}, {length, 0, 0}};
  scene.solver.force_tolerance = scene.solver.geometry_tolerance = 1e-5;
  scene.stages = {stage_with("shorten", n_increments, {displacement("tip", BodyDof::x, -shortening * length)})};
  return scene;
}

TEST(Buckling, FarIntoTheElastica) {
  // Clamped at both ends: Euler's load 4π² EI/L², and four quarter waves of the pinned column. L/R = 200: stretch is
  // 10⁻³.
  constexpr double length = 200;
  const double euler = 4 * pi * pi * bending / (length * length);
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod})
    for (const double shortening : {0.05, 0.2, 0.4}) {
      const RunResult result = run_scene(column(model, length, 0.5, shortening, 20));
      expect_done(result);
      const double load = -result.last().bodies.force[1].x() / euler, expected = elastica_load(shortening);
      measured(fmt::format("{}, shortened by {:.2f}: P/P_E {:.4f}, elastica {:.4f}, {} Newton iterations, {} cuts",
                           model == FiberModel::rod ? "rod" : "enriched", shortening, load, expected,
                           result.summary.n_newton_iterations, result.summary.n_cut_increments));
      EXPECT_NEAR(load / expected, 1, 0.02);
    }
}

TEST(Buckling, PerfectColumnHasAClearOutcome) {
  // Without a bow the straight state stays an equilibrium beyond Euler's load, an unstable one: nothing in a static
  // solver leaves it, but it must not blow up either, and must say so. Twice Euler's load.
  constexpr double length = 100;
  const double euler_strain = 4 * pi * pi * 0.25 / (length * length);
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    const RunResult result = run_scene(column(model, length, 0, 2 * euler_strain, 10));
    expect_clear_status(result);
    const double load = -result.last().bodies.force[1].x() / (pi * euler_strain);
    double deflection = 0;
    for (const Vec3& r : result.last().fibers.r) deflection = std::max(deflection, std::hypot(r.y(), r.z()));
    measured(fmt::format("{}: {}, P/P_E {:.3f}, deflection {:.1e} R, {} of {} increments known to be unstable",
                         model == FiberModel::rod ? "rod" : "enriched", result.done() ? "done" : "gave up", load,
                         deflection, result.summary.n_unstable_increments, result.summary.n_increments));
    EXPECT_EQ(result.last().solver.unstable, 1);
    EXPECT_GE(result.summary.n_unstable_increments, 1);
    EXPECT_LE(result.summary.n_unstable_increments, 6);  // those above Euler's load, and the one that stands at it
    ASSERT_EQ(result.summary.warnings.size(), 1u);
    EXPECT_NE(result.summary.warnings[0].find("unstable, the first one in stage shorten"), std::string::npos);
  }
}

TEST(Buckling, StableColumnsAreNotCalledUnstable) {
  // Straight at 0.95 times Euler's load, and bent far beyond it.
  constexpr double length = 100;
  const double euler_strain = 4 * pi * pi * 0.25 / (length * length);
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    EXPECT_EQ(run_scene(column(model, length, 0, 0.95 * euler_strain, 10)).summary.n_unstable_increments, 0);
    const RunResult bent = run_scene(column(model, length, 0.5, 0.2, 20));
    EXPECT_TRUE(bent.done());
    EXPECT_EQ(bent.summary.n_unstable_increments, 0);
  }
}

TEST(Buckling, DeadLoadAboveEulers) {
  // A slightly bowed column under a dead load that grows to 1.5 times Euler's: it gives way by two thirds of its
  // length, on a stable path.
  constexpr double length = 200;
  const double euler = 4 * pi * pi * bending / (length * length);
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    Scene scene = column(model, length, 1, 0, 1);
    scene.stages = {stage_with("load", 30, {force("tip", BodyDof::x, -1.5 * euler)})};
    const RunResult result = run_scene(scene);
    expect_clear_status(result);
    const double shortening = 1 - result.tip().x() / length;
    measured(fmt::format("{}: {}, shortening {:.4f} L, P/P_E of the elastica there {:.4f}, {} cuts",
                         model == FiberModel::rod ? "rod" : "enriched", result.done() ? "done" : "gave up", shortening,
                         elastica_load(shortening), result.summary.n_cut_increments));
    EXPECT_TRUE(result.done()) << result.summary.message;
    EXPECT_NEAR(elastica_load(shortening), 1.5, 0.03);
  }
}

TEST(Buckling, FibersInABundleBuckleAgainstEachOther) {
  Scene scene;
  scene.name = "bundle";
  scene.materials = {isotropic(1, 0.3)};
  scene.fiber_types = {{"f", 0, 1.0, FiberModel::enriched}};
  scene.bundles = {{"strand", 0, {{0, 0, 0}, {50, 0, 0.3}, {100, 0, 0}}, 12, 7, 0, 1.02, 0.1}};
  scene.bodies = {{"left", {0, 0, 0}, {{"strand", FiberEnd::start, {}}}},
                  {"right", {100, 0, 0}, {{"strand", FiberEnd::end, {}}}}};
  scene.contact.friction = true;
  scene.stages = {stage_with("shorten", 20, {displacement("right", BodyDof::x, -5)})};
  const RunResult result = run_scene(scene);
  expect_clear_status(result);
  double peak = 0;
  for (const Increment& i : result.increments) peak = std::max(peak, -i.bodies.force[1].x());
  const double euler = 7 * 4 * pi * pi * bending / 1e4;  // of seven fibers on their own
  measured(fmt::format(
      "{} at {:.2f}: peak over seven columns' Euler load {:.2f}, penetration {:.3f} R, {} Newton iterations, {} cuts",
      result.done() ? "done" : "gave up", result.last().stage_time, peak / euler, penetration(result.last()),
      result.summary.n_newton_iterations, result.summary.n_cut_increments));
  EXPECT_TRUE(result.done()) << result.summary.message;
  EXPECT_GT(peak / euler, 0.8);
  EXPECT_LT(peak / euler, 49);  // seven fibers as one rod of seven times the section have 49 times the stiffness of one
  EXPECT_LT(penetration(result.last()), 0.2);
}

/// A circular arch of radius ρ in the plane x z, apex on top, cut at the apex, where a body joins its halves.
Scene arch(double rho, double half_angle, Index n_elements, bool right_is_hinged) {
  const auto half = [&](double from, double to) {
    std::vector<Vec3> points;
    for (int i = 0; i <= 24; ++i) {
      const double a = from + (to - from) * i / 24;
      points.emplace_back(rho * std::sin(a), 0, rho * std::cos(a));
    }
    return points;
  };
  Scene scene = cantilever(FiberModel::enriched, 0, 1, n_elements);
  scene.fibers = {{"left", 0, half(-half_angle, 0), n_elements, {}}, {"right", 0, half(0, half_angle), n_elements, {}}};
  scene.bodies = {{"clamp", scene.fibers[0].points.front(), {{"left", FiberEnd::start, {}}}},
                  {"apex", {0, 0, rho}, {{"left", FiberEnd::end, {}}, {"right", FiberEnd::start, {}}}},
                  {"support", scene.fibers[1].points.back(), {{"right", FiberEnd::end, {}}}}};
  scene.solver.force_tolerance = scene.solver.geometry_tolerance = 1e-5;
  if (right_is_hinged) scene.stages = {stage_with("push", 1, {force("support", BodyDof::ry, 0)})};
  return scene;
}

TEST(SnapThrough, ShallowArchByDisplacement) {
  // Clamped at both ends, pushed down by more than twice its rise: the force has a peak, falls, and rises again on the
  // other side.
  Scene scene = arch(400, 0.2, 10, false);  // rise 8 R
  scene.stages = {stage_with("push", 40, {displacement("apex", BodyDof::z, -20)})};
  const RunResult result = run_scene(scene);
  expect_done(result);
  std::vector<double> f;
  for (const Increment& i : result.increments) f.push_back(-i.bodies.force[1].z());
  const auto peak = std::adjacent_find(f.begin(), f.end(), [](double a, double b) { return b < a; });
  ASSERT_NE(peak, f.end()) << "the force never falls";
  const double valley = *std::min_element(peak, f.end());
  measured(fmt::format(
      "peak {:.2e}, valley {:.2e}, at the end {:.2e} E R^2, imbalance {:.4f}, {} Newton iterations, {} cuts", *peak,
      valley, f.back(), relative_imbalance(result), result.summary.n_newton_iterations,
      result.summary.n_cut_increments));
  EXPECT_LT(valley, 0.5 * *peak);
  EXPECT_GT(f.back(), *peak);
  EXPECT_LT(relative_imbalance(result), 0.01);
}

TEST(SnapThrough, ShallowArchByDeadLoad) {
  // Beyond the limit load the next equilibrium is on the other side: Newton's method gets there, or the run ends at the
  // limit.
  Scene scene = arch(400, 0.2, 10, false);  // rise 8 R: snaps
  scene.solver.min_increment = 1e-3;
  scene.solver.step_cap = 1;
  scene.stages = {stage_with("push", 10, {displacement("apex", BodyDof::z, -20)})};
  const RunResult path = run_scene(scene);
  expect_done(path);
  double limit = 0, before = 0;
  for (const Increment& i : path.increments) {
    const double f = -i.bodies.force[1].z();
    if (f < before) break;
    limit = before = f;
  }
  scene.stages = {stage_with("load", 10, {force("apex", BodyDof::z, -1.3 * limit)})};
  const RunResult result = run_scene(scene);
  expect_clear_status(result);
  double apex = result.last().bodies.position[1].z() - 400;
  measured(fmt::format(
      "limit {:.3e} E R^2 by displacement; dead load: {} at {:.3f} of 1.3 times that, apex moved {:.2f} R, {} cuts",
      limit, result.done() ? "done" : "gave up", result.last().stage_time, apex, result.summary.n_cut_increments));
  EXPECT_GE(result.last().stage_time * 1.3, 0.8);
  if (result.done()) {
    EXPECT_LT(apex, -10);
  }
}

TEST(SnapThrough, ClampedHingedDeepArch) {
  // 215° of a circle, one end clamped, the other hinged, a dead load at the apex: snaps at P = 8.97 EI/ρ² (DaDeppo and
  // Schmidt 1975; 897 for EI = 10⁶, ρ = 100). Followed here by the apex's way down.
  constexpr double rho = 100;
  Scene scene = arch(rho, 0.5 * 215 * pi / 180, 20, true);
  scene.stages = {stage_with("push", 40,
                             {displacement("apex", BodyDof::z, -1.2 * rho), force("apex", BodyDof::x, 0),
                              force("apex", BodyDof::ry, 0), force("support", BodyDof::ry, 0)})};
  const RunResult result = run_scene(scene);
  expect_clear_status(result);
  double peak = 0, at = 0;
  for (const Increment& i : result.increments)
    if (const double f = -i.bodies.force[1].z() * rho * rho / bending; f > peak) {
      peak = f;
      at = (rho - i.bodies.position[1].z()) / rho;
    }
  measured(
      fmt::format("{} at {:.2f}: largest load {:.3f} EI/rho^2 (published 8.97) at an apex {:.3f} rho down, {} Newton "
                  "iterations, {} cuts",
                  result.done() ? "done" : "gave up", result.last().stage_time, peak, at,
                  result.summary.n_newton_iterations, result.summary.n_cut_increments));
  EXPECT_NEAR(peak / 8.97, 1, 0.01);
}

}  // namespace
}  // namespace trame::micro
