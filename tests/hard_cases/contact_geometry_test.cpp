/// \file
/// Hard cases of contact geometry: fibers that are parallel, coincident, end on, at zero gap, at a grazing angle, deep
/// inside each other, or of very different thickness.

#include <fmt/ranges.h>

#include <numbers>

#include "micro/scene/yarn_section.h"
#include "micro/weave/flat_start.h"
#include "tests/support/hard_case.h"

namespace trame::micro {
namespace {

using namespace test;

constexpr double degree = std::numbers::pi / 180;

/// A pair whose upper fiber is pressed down with `load`.
Scene pressed(const Pair& pair, double load, Index n_increments = 4) {
  Scene scene = pair_scene(pair);
  scene.stages = {stage_with("press", n_increments, {force("grip", BodyDof::z, -load)})};
  return scene;
}

/// Statics of a pressed pair: all of the load goes through the contact.
double load_error(const RunResult& result, double load) {
  return std::abs(normal_resultant(result.last()).z() / load - 1);
}

TEST(ContactGeometry, ZeroGapCostsNothing) {
  for (const double angle : {0.0, 20 * degree, 90 * degree}) {
    Pair pair;
    pair.angle = angle;
    Scene scene = pair_scene(pair);
    scene.stages = {stage_with("rest", 2, {})};
    const RunResult result = run_scene(scene);
    expect_done(result);
    // Round-off of coordinates of 20 radii leaves a gap of 1e-15 R, and a force that goes with its square.
    const double at_rest = normal_resultant(result.last()).norm();
    measured(fmt::format("angle {:.0f} deg: normal force {:.1e} E R^2, {} Newton iterations", angle / degree, at_rest,
                         result.summary.n_newton_iterations));
    EXPECT_LT(at_rest, 1e-20);
    EXPECT_LE(result.summary.n_newton_iterations, 2);
  }
}

TEST(ContactGeometry, ParallelFibersCarryTheLoadSymmetrically) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    Pair pair;
    pair.model = model;
    pair.height = 1.99;  // a body that only its load drives must touch from the start on
    const double load = 0.05;
    const RunResult result = run_scene(pressed(pair, load));
    expect_done(result);
    const std::vector<double>& f = result.last().contacts.normal_force;
    double difference = 0;
    for (std::size_t i = 0; i < f.size(); ++i)
      difference = std::max(difference, std::abs(f[i] - f[f.size() - 1 - i]) / load);
    measured(fmt::format("{}: load error {:.1e}, left against right {:.1e} of the load",
                         model == FiberModel::rod ? "rod" : "enriched", load_error(result, load), difference));
    EXPECT_LT(load_error(result, load), 1e-2);
    EXPECT_LT(difference, 1e-2);
  }
}

TEST(ContactGeometry, AnyAngleFromParallelToSquare) {
  const double load = 0.005;
  double worst = 0, deepest = 0;
  for (const double angle : {0.1, 1.0, 3.0, 10.0, 29.0, 29.99, 31.0, 60.0, 89.9, 90.0}) {
    Pair pair;
    pair.angle = angle * degree;
    pair.height = 1.99;
    Scene scene = pressed(pair, load, 8);
    scene.solver.geometry_tolerance = 1e-4;  // forces inside a fiber, which it is measured by, are far above the load
    const RunResult result = run_scene(scene);
    expect_done(result);
    worst = std::max(worst, load_error(result, load));
    deepest = std::max(deepest, penetration(result.last()));
    EXPECT_LT(load_error(result, load), 2e-2) << angle;
    EXPECT_LT(penetration(result.last()), 0.1) << angle;
  }
  measured(
      fmt::format("10 angles of 0.1 to 90 deg: worst load error {:.1e}, deepest penetration {:.3f} R", worst, deepest));
}

TEST(ContactGeometry, SamplesAndCrossingsAgreeWhereTheyMeet) {
  // Just below 30° a zone of samples carries the load, just above one element does: the height must not jump.
  std::array<double, 2> height{};
  for (const int side : {0, 1}) {
    Pair pair;
    pair.angle = (side == 0 ? 28 : 32) * degree;
    pair.height = 1.99;
    Scene scene = pressed(pair, 0.005, 4);
    scene.stages.push_back(stage_with("hold", 8, {force("grip", BodyDof::z, -0.005)}));
    const RunResult result = run_scene(scene);
    expect_done(result);
    height[side] = node_at(result, 1, 0.5).z() - node_at(result, 0, 0.5).z();
  }
  measured(fmt::format("distance of the axes {:.4f} and {:.4f} R", height[0], height[1]));
  EXPECT_LT(std::abs(height[0] - height[1]), 0.03);  // a target penetration
}

TEST(ContactGeometry, CrossingThatBendsUntilItWraps) {
  // Two fibers pressed together at 31° so hard that (1 − 2Rκ)² < cos² 31°: the closest point is no longer unique,
  // contact along a line begins, and one element cannot follow. (Meier, Popp & Wall 2016 derive such limits of point
  // contact.)
  Pair pair;
  pair.angle = 31 * degree;
  pair.height = 1.99;
  const RunResult result = run_scene(pressed(pair, 0.02, 8));
  expect_clear_status(result);
  measured(fmt::format("{} at {:.2f} of the load, penetration {:.3f} R", result.done() ? "done" : "gave up",
                       result.last().stage_time, penetration(result.last())));
  EXPECT_GE(result.last().stage_time, 0.25);  // the limit is at 0.4 of the load
  EXPECT_LT(penetration(result.last()), 0.2);
}

/// Two fibers along x at (almost) the same place. `offset` moves the nodes of the upper one.
RunResult coincident(FiberModel model, const std::vector<Vec3>& over) {
  Pair pair;
  pair.model = model;
  pair.height = 0;
  Scene scene = pressed(pair, 1e-3, 10);
  scene.fibers[1].points = over;
  return run_scene(scene);
}

TEST(ContactGeometry, CoincidentFibersPart) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    const RunResult result = coincident(model, {{-20, 0, 0}, {20, 0, 0}});
    expect_done(result);
    const Vec3 apart = node_at(result, 1, 0.5) - node_at(result, 0, 0.5);
    measured(fmt::format("{}: axes {:.3f} R apart, {} Newton iterations, {} cuts",
                         model == FiberModel::rod ? "rod" : "enriched", apart.norm(),
                         result.summary.n_newton_iterations, result.summary.n_cut_increments));
    EXPECT_GT(apart.norm(), 1.9);
  }
}

TEST(ContactGeometry, AlmostCoincidentFibersThatWindAroundEachOther) {
  // Directions of the chords differ from sample to sample, and say nothing: 1e-9 R is noise.
  std::vector<Vec3> over;
  for (int i = 0; i <= 20; ++i) over.emplace_back(-20 + 2 * i, 1e-9 * std::cos(i), 1e-9 * std::sin(i));
  const RunResult result = coincident(FiberModel::enriched, over);
  expect_clear_status(result);
  measured(fmt::format("{}, deepest penetration {:.2f} R, {} increments, {} cuts", result.done() ? "done" : "gave up",
                       penetration(result.last()), result.summary.n_increments, result.summary.n_cut_increments));
}

TEST(ContactGeometry, DeepParallelFibersPart) {
  // Axes a tenth of a radius apart: 1.9 R deep.
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    Pair pair;
    pair.model = model;
    pair.height = 0.1;
    const RunResult result = run_scene(pressed(pair, 1e-3, 10));
    expect_done(result);
    const double height = node_at(result, 1, 0.5).z() - node_at(result, 0, 0.5).z();
    measured(fmt::format("{}: axes {:.3f} R apart, {} Newton iterations, {} cuts",
                         model == FiberModel::rod ? "rod" : "enriched", height, result.summary.n_newton_iterations,
                         result.summary.n_cut_increments));
    EXPECT_GT(height, 1.9);
    EXPECT_LT(height, 2.05);  // its ends are pressed, its middle arches
  }
}

TEST(ContactGeometry, SevenFibersInTheRoomOfTwo) {
  // A hexagon packed at half a diameter: every fiber lies one radius deep in up to six others.
  Scene scene;
  scene.name = "packed";
  scene.materials = {isotropic(1, 0.3)};
  scene.fiber_types = {{"f", 0, 1.0, FiberModel::enriched}};
  int i = 0;
  for (const Vec2& c : hexagonal_section(7, 0, 1.0))
    scene.fibers.push_back({fmt::format("f{}", i++), 0, {{-20, c[0], c[1]}, {20, c[0], c[1]}}, 8, {}});
  scene.bodies = {{"left", {-20, 0, 0}, {{"*", FiberEnd::start, TieKind::average}}},
                  {"right", {20, 0, 0}, {{"*", FiberEnd::end, TieKind::average}}}};
  scene.contact.friction = false;
  Stage part = stage_with("part", 10, {});
  part.proximal_start = 1e-2;
  part.proximal_end = 1e-5;
  scene.stages = {part};
  const RunResult result = run_scene(scene);
  expect_done(result);
  measured(fmt::format("penetration {:.2f} R -> {:.3f} R, {} Newton iterations, {} cuts", 1.0,
                       penetration(result.last()), result.summary.n_newton_iterations,
                       result.summary.n_cut_increments));
  EXPECT_LT(penetration(result.last()), 0.1);
}

// Known to fail.
TEST(ContactGeometry, YarnsOfSeveralDiametersPart) {
  // Two flat yarns of four layers each lie wholly inside each other: four diameters deep.
  Scene scene;
  scene.name = "deep yarns";
  scene.materials = {isotropic(3e9, 0.3)};
  const double radius = 1e-5;
  scene.fiber_types = {{"f", 0, radius, FiberModel::rod}};
  const YarnSystem yarns{
      {{.type = 0, .n_fibers = 12, .n_layers = 4, .lattice_spacing = 1.05}}, {0}, 1, 10, 20 * radius, 30 * radius};
  scene.weave = Weave{{{true}}, yarns, yarns};
  Stage separate = stage_with("separate", 12, {});
  for (const auto& [end, sign] : {std::pair{"start", -1.0}, std::pair{"end", 1.0}}) {
    separate.drives.push_back(force(std::string("warp/*/") + end, BodyDof::x, sign * 1e-3));
    separate.drives.push_back(force(std::string("weft/*/") + end, BodyDof::y, sign * 1e-3));
  }
  separate.separate_yarns = true;
  separate.friction = false;
  separate.proximal_start = separate.proximal_end = 1e-3;
  Stage relax = separate;
  relax.name = "relax";
  relax.n_increments = 8;
  relax.separate_yarns = false;
  relax.proximal_end = 0;
  scene.stages = {separate, relax};
  const RunResult result = run_scene(scene);
  expect_done(result);
  measured(fmt::format("crossing in order: {}, penetration {:.3f} R, {} increments, {} Newton iterations, {} cuts",
                       result.summary.crossing_order_ok, result.summary.max_penetration_over_radius,
                       result.summary.n_increments, result.summary.n_newton_iterations,
                       result.summary.n_cut_increments));
  EXPECT_TRUE(result.summary.crossing_order_ok);
  EXPECT_LT(result.summary.max_penetration_over_radius, 0.2);
}

TEST(ContactGeometry, EndOnFibersDoNotMeet) {
  // Only flanks touch in this model: an end face has no contact (see the README's table). What must hold is that
  // ends that run into each other along one line do no harm before they overlap.
  Scene scene = pair_scene({});
  scene.fibers[0].points = {{-40, 0, 0}, {-0.5, 0, 0}};
  scene.fibers[1].points = {{0.5, 0, 0}, {40, 0, 0}};
  scene.stages = {stage_with("approach", 5, {displacement("grip", BodyDof::x, -0.9)})};
  const RunResult result = run_scene(scene);
  expect_done(result);
  measured(fmt::format("ends 0.1 R apart on one line: contact force {:.1e}", normal_resultant(result.last()).norm()));
  EXPECT_LT(normal_resultant(result.last()).norm(), 1e-9);
  EXPECT_EQ(result.summary.n_buried_ends, 0);
}

/// A fiber that stands on another, its tip pushed down by `down` from a gap of 0.05 R.
RunResult tip_on_flank(double down) {
  Scene scene = pair_scene({});
  scene.fibers[1].points = {{0, 0, 1.05}, {0, 0, 41.05}};
  scene.stages = {stage_with("push", 5, {displacement("grip", BodyDof::z, -down)})};
  return run_scene(scene);
}

TEST(ContactGeometry, TipPressedOnAFlankMeetsResistance) {
  // The shortest chord rests at an end of the fiber that presses: a point contact there.
  const RunResult result = tip_on_flank(1.0);
  expect_done(result);
  measured(fmt::format("{} contact elements, force {:.1e} at a tip pushed 0.95 R; {}",
                       result.last().contacts.gap.size(), normal_resultant(result.last()).norm(),
                       fmt::join(result.summary.warnings, "; ")));
  EXPECT_GE(result.last().contacts.gap.size(), 1u);
  EXPECT_GT(normal_resultant(result.last()).norm(), 0);
  EXPECT_EQ(result.summary.n_buried_ends, 0);
  EXPECT_EQ(tip_on_flank(0.02).summary.n_buried_ends, 0);
}

TEST(ContactGeometry, EndsThatLieInPlaceAreNotReported) {
  // A short fiber beside a long one, at the distance of contact: its ends stand on the other's flank, not in it. Bodies
  // hold all ends, two of them together.
  Pair pair;
  pair.height = 1.95;
  Scene scene = pair_scene(pair);
  scene.fibers[1].points = {{-10, 0, 1.95}, {10, 0, 1.95}};
  scene.stages = {stage_with("rest", 1, {})};
  const RunResult result = run_scene(scene);
  expect_done(result);
  EXPECT_EQ(result.summary.n_buried_ends, 0);
  EXPECT_TRUE(result.summary.warnings.empty());
}

/// A hair of a hundredth of the rope's radius, laid across it and pulled down at both ends.
RunResult hair_on_rope(Index n_elements, double down) {
  Scene scene;
  scene.name = "hair on a rope";
  scene.materials = {isotropic(1, 0.3)};
  scene.fiber_types = {{"rope", 0, 1.0, FiberModel::enriched}, {"hair", 0, 0.01, FiberModel::enriched}};
  const double height = 1.0101;
  scene.fibers = {{"rope", 0, {{-10, 0, 0}, {10, 0, 0}}, 6, {}},
                  {"hair", 1, {{0, -2, height}, {0, 2, height}}, n_elements, {}}};
  scene.bodies = {{"table", {0, 0, 0}, {{"rope", FiberEnd::start, {}}, {"rope", FiberEnd::end, {}}}},
                  {"grip", {0, 0, height}, {{"hair", FiberEnd::start, {}}, {"hair", FiberEnd::end, {}}}}};
  scene.contact.friction = false;
  scene.solver.geometry_tolerance = 1e-3;
  scene.solver.min_increment = 1e-2;
  scene.stages = {stage_with("press", 10, {displacement("grip", BodyDof::z, -down)})};
  return run_scene(scene);
}

TEST(ContactGeometry, ThinFiberOverOneAHundredTimesThicker) {
  const RunResult result = hair_on_rope(41, 0.1);  // ten of its radii
  expect_done(result);
  const double pushed = -result.last().bodies.force[1].z(), carried = normal_resultant(result.last()).z();
  // Half of the hair is a beam of length L under tension T, both ends clamped, which goes down by d: with ℓ = √(EI/T)
  // its slope is s = d/(L − 2ℓ) but for the ends, ½∫w'² = ½ s² (L − 3ℓ) stretches it, and each half carries T s.
  const double length = 2, down = 0.1 - 0.0001 - penetration(result.last()), ea = std::numbers::pi * 1e-4,
               ei = ea * 1e-4 / 4;
  double tension = 1e-7, slope = 0;
  for (int i = 0; i < 50; ++i) {
    const double end = std::sqrt(ei / tension);
    slope = down / (length - 2 * end);
    tension = ea * 0.5 * slope * slope * (length - 3 * end) / length;
  }
  const double expected = 2 * tension * slope;
  measured(fmt::format(
      "load error {:.1e}, force over that of theory {:.3f}, penetration {:.2f} of the hair's radius, {} cuts",
      std::abs(carried / pushed - 1), pushed / expected, penetration(result.last(), 0.01),
      result.summary.n_cut_increments));
  EXPECT_LT(std::abs(carried / pushed - 1), 1e-2);
  EXPECT_NEAR(pushed / expected, 1, 0.02);
}

TEST(ContactGeometry, ThinFiberKinksAtAJoint) {
  // Twice as far, with a joint of two elements at the edge.
  const RunResult result = hair_on_rope(40, 0.2);
  expect_clear_status(result);
  measured(fmt::format("{} at {:.2f} of the way", result.done() ? "done" : "gave up", result.last().stage_time));
  EXPECT_GE(result.last().stage_time, 0.5);
}

}  // namespace
}  // namespace trame::micro
