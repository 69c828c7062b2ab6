/// \file
/// Fibers wound around each other ten times, and an overhand knot pulled tight.

#include <numbers>

#include "micro/solve/system.h"
#include "tests/support/hard_case.h"

namespace trame::micro {
namespace {

using namespace test;

constexpr double pi = std::numbers::pi, bending = pi / 4;

/// A bundle along x of the given length, whose right end is turned while a force pulls at it.
Scene twisted_bundle(FiberModel model, Index n_fibers, double length, Index n_elements, double turns, double pull) {
  Scene scene;
  scene.name = "twisted bundle";
  scene.materials = {isotropic(1, 0.3)};
  scene.fiber_types = {{"f", 0, 1.0, model}};
  scene.bundles = {{"strand", 0, {{0, 0, 0}, {length, 0, 0}}, n_elements, n_fibers, 0, 1.02, 0}};
  scene.bodies = {{"left", {0, 0, 0}, {{"strand", FiberEnd::start, {}}}},
                  {"right", {length, 0, 0}, {{"strand", FiberEnd::end, {}}}}};
  scene.contact.friction = false;
  const Drive tension = force("right", BodyDof::x, pull);
  scene.stages = {stage_with("pull", 2, {tension}),
                  stage_with("twist", static_cast<Index>(20 * turns),
                             {tension, displacement("right", BodyDof::rx, 2 * pi * turns)})};
  return scene;
}

/// Turns that the chord between two fibers makes about x from one end to the other.
double winding(const RunResult& result, Index a, Index b) {
  const auto& first = result.header.mesh.first_node;
  const auto& r = result.last().fibers.r;
  double turns = 0, before = 0;
  for (Index i = 0; i < result.header.mesh.n_nodes(a); ++i) {
    const Vec3 chord = r[first[b] + i] - r[first[a] + i];
    const double angle = std::atan2(chord.z(), chord.y());
    if (i > 0) turns += std::remainder(angle - before, 2 * pi) / (2 * pi);
    before = angle;
  }
  return turns;
}

TEST(TwistStudy, TwoFibersByTenTurns) {
  // Both become helices about the common axis, of a radius ρ of half their distance, and stretched by T/2EA: of a
  // length L, √(L² (1 + T/2EA)² − (2π·10 ρ)²) is left along the axis, but for the clamps.
  constexpr double length = 300, pull = 0.02;
  const RunResult result = run_scene(twisted_bundle(FiberModel::enriched, 2, length, 60, 10, pull));
  expect_done(result);
  const double turns = std::abs(winding(result, 0, 1)), left = result.last().bodies.position[1].x();
  const Vec3 chord = node_at(result, 1, 0.5) - node_at(result, 0, 0.5);
  const double rho = 0.5 * std::hypot(chord.y(), chord.z());
  const double expected = std::sqrt(std::pow(length * (1 + pull / (2 * pi)), 2) - std::pow(2 * pi * 10 * rho, 2));
  measured(
      fmt::format("{:.3f} turns, axes {:.3f} R apart in the middle, length {:.2f} of {:.2f} R, penetration {:.3f} R, "
                  "imbalance {:.4f}, "
                  "{} Newton iterations, {} cuts",
                  turns, std::hypot(chord.y(), chord.z()), left, expected, penetration(result.last()),
                  relative_imbalance(result), result.summary.n_newton_iterations, result.summary.n_cut_increments));
  EXPECT_NEAR(turns, 10, 0.01);
  EXPECT_NEAR(std::hypot(chord.y(), chord.z()), 2, 0.1);
  EXPECT_NEAR(left / expected, 1, 0.005);
  EXPECT_LT(penetration(result.last()), 0.2);
}

TEST(TwistStudy, SevenFibersByTenTurns) {
  constexpr double length = 500;
  const RunResult result = run_scene(twisted_bundle(FiberModel::enriched, 7, length, 60, 10, 0.1), 2);
  expect_clear_status(result);
  double deepest = 0;
  for (const Increment& i : result.increments) deepest = std::max(deepest, penetration(i));
  double least = 1e9, most = 0;  // winding of the outer fibers about the first, the core
  for (Index f = 1; f < 7; ++f) {
    least = std::min(least, std::abs(winding(result, 0, f)));
    most = std::max(most, std::abs(winding(result, 0, f)));
  }
  measured(
      fmt::format("{} at {:.2f}: outer fibers wind {:.3f} to {:.3f} turns, deepest penetration {:.3f} R, {} Newton "
                  "iterations, {} cuts",
                  result.done() ? "done" : "gave up", result.last().stage_time, least, most, deepest,
                  result.summary.n_newton_iterations, result.summary.n_cut_increments));
  EXPECT_TRUE(result.done()) << result.summary.message;
  EXPECT_LT(deepest, 0.5);
}

/// An open overhand knot: a trefoil on a torus, cut at one of its outer lobes, with tails along ±y. `size`: radius of
/// the torus over 2.
std::vector<Vec3> overhand(double size, double tail) {
  const auto trefoil = [&](double t) -> Vec3 {
    const double rho = 2 + std::cos(3 * t);
    return size * Vec3(rho * std::cos(2 * t), rho * std::sin(2 * t), std::sin(3 * t));
  };
  std::vector<Vec3> points;
  constexpr double cut = 0.22;
  constexpr int n = 48;
  const Vec3 first = trefoil(cut), last = trefoil(2 * pi - cut);
  // The tails bend outward and pass each other beside the cut.
  const Vec3 start = first + Vec3(0.6 * size, -1.6 * size, 0), end = last + Vec3(0.6 * size, 1.6 * size, 0);
  points.push_back(start + Vec3(0.5 * size, -tail, 0));
  points.push_back(start + Vec3(0.25 * size, -0.5 * tail, 0));
  points.push_back(start);
  for (int i = 0; i <= n; ++i) points.push_back(trefoil(cut + (2 * pi - 2 * cut) * i / n));
  points.push_back(end);
  points.push_back(end + Vec3(0.25 * size, 0.5 * tail, 0));
  points.push_back(end + Vec3(0.5 * size, tail, 0));
  return points;
}

Scene knot_scene(double size, double tail, Index n_elements, double pull_by, Index n_increments, double friction) {
  Scene scene;
  scene.name = "knot";
  scene.materials = {isotropic(1, 0.3)};
  scene.fiber_types = {{"f", 0, 1.0, FiberModel::rod}};
  scene.fibers = {{"rope", 0, overhand(size, tail), n_elements, {}}};
  scene.bodies = {{"down", scene.fibers[0].points.front(), {{"rope", FiberEnd::start, {}}}},
                  {"up", scene.fibers[0].points.back(), {{"rope", FiberEnd::end, {}}}}};
  scene.contact.self_contact = true;
  scene.contact.friction = friction > 0;
  scene.contact.friction_coefficient = friction;
  // The rod is straight at rest: it first finds its shape, free of friction, its ends held.
  Stage relax = stage_with("relax", 6, {});
  relax.friction = false;
  relax.proximal_start = 1e-2;
  relax.proximal_end = 0;
  Stage pull =
      stage_with("pull", n_increments,
                 {displacement("down", BodyDof::y, -0.5 * pull_by), displacement("up", BodyDof::y, 0.5 * pull_by)});
  scene.stages = {relax, pull};
  return scene;
}

TEST(KnotStudy, OverhandPulledTight) {
  constexpr double size = 5, tail = 40;
  const RunResult result = run_scene(knot_scene(size, tail, 70, 70, 70, 0.1));
  expect_clear_status(result);
  double deepest = 0;
  for (const Increment& i : result.increments) deepest = std::max(deepest, penetration(i));
  const double length = result.header.mesh.length(0);
  const auto slack = [&](const Increment& i) { return length - (i.bodies.position[1] - i.bodies.position[0]).norm(); };
  measured(
      fmt::format("{} at {:.2f}: {:.1f} -> {:.1f} R of fiber in the knot, pull {:.2e} E R^2, deepest penetration "
                  "{:.3f} R, {} self-contacts, "
                  "{} Newton iterations, {} cuts",
                  result.done() ? "done" : "gave up", result.last().stage_time, slack(result.increments[0]),
                  slack(result.last()), result.last().bodies.force[1].y(), deepest, result.last().contacts.gap.size(),
                  result.summary.n_newton_iterations, result.summary.n_cut_increments));
  EXPECT_TRUE(result.done()) << result.summary.message;
  EXPECT_GT(slack(result.last()), 10);  // it is still a knot: a straight fiber has none
  EXPECT_LT(deepest, 0.5);
}

TEST(KnotStudy, LooseOverhandAgainstTheory) {
  // A loose knot of a thin, smooth rod is a circle of radius ρ with straight tails: minimum of EI π/ρ + T 2πρ, T =
  // EI/2ρ² = 2π² EI/e² with the end shortening e = 2πρ, to leading order in √(R/ρ) (Audoly, Clauvelin & Neukirch 2007).
  constexpr double size = 40, tail = 400;
  const RunResult result = run_scene(knot_scene(size, tail, 240, 500, 100, 0), 2);
  expect_clear_status(result);
  const double length = result.header.mesh.length(0);
  for (const Increment& i : result.increments) {
    const double e = length - (i.bodies.position[1] - i.bodies.position[0]).norm(), pull = i.bodies.force[1].y();
    if (i.stage == "pull" && std::lround(i.stage_time * 100) % 20 == 0)
      measured(fmt::format("shortening {:.1f} R: pull over that of theory {:.3f}", e,
                           pull * e * e / (2 * pi * pi * bending)));
  }
  EXPECT_TRUE(result.done()) << result.summary.message;
}

}  // namespace
}  // namespace trame::micro
