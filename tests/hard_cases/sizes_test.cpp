/// \file
/// Hard cases of size: one element a fiber and 300, huge and tiny increments, fibers as short as thick, slack ones,
/// one, none.

#include <numbers>

#include "micro/core/error.h"
#include "tests/support/hard_case.h"

namespace trame::micro {
namespace {

using namespace test;

constexpr double pi = std::numbers::pi;

TEST(Sizes, EmptyScene) {
  Scene scene;
  scene.name = "empty";
  scene.materials = {isotropic(1, 0.3)};
  scene.fiber_types = {{"f", 0, 1.0, FiberModel::enriched}};
  scene.stages = {stage_with("nothing", 2, {})};
  try {
    (void)run_scene(scene);
    ADD_FAILURE() << "ran";
  } catch (const InputError& error) {
    measured(fmt::format("refused: {}", error.what()));
  }
}

TEST(Sizes, OneFreeFiber) {
  // Nothing holds it and nothing loads it: it stays, though its tangent is singular.
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    Scene scene = cantilever(model, 0.3, 20, 4);
    scene.bodies.clear();
    scene.contact = {};
    scene.stages = {stage_with("float", 2, {})};
    const RunResult result = run_scene(scene);
    expect_done(result);
    const double moved = (result.tip() - Vec3(20, 0, 0)).norm();
    measured(fmt::format("{}: moved {:.1e} R", model == FiberModel::rod ? "rod" : "enriched", moved));
    EXPECT_LT(moved, 1e-12);
  }
}

TEST(Sizes, FreeFiberPulledHasNoEquilibrium) {
  Scene scene = cantilever(FiberModel::enriched, 0.3, 20, 4);
  scene.bodies = {{"tip", {20, 0, 0}, {{"beam", FiberEnd::end, TieKind::clamped}}}};
  scene.solver.min_increment = 1e-2;
  scene.stages = {stage_with("pull", 2, free_body("tip", {1e-3, 0, 0}))};
  const RunResult result = run_scene(scene);
  expect_clear_status(result);
  measured(fmt::format("{}: {}", result.done() ? "done" : "gave up", result.summary.message.substr(0, 80)));
  EXPECT_FALSE(result.done());
  EXPECT_LT((result.tip() - Vec3(20, 0, 0)).norm(), 1e-12);  // the last good state is the start
}

TEST(Sizes, FiberOfLengthOneDiameter) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    Scene scene = cantilever(model, 0.3, 2, 1);
    scene.solver.force_tolerance = scene.solver.geometry_tolerance = 1e-5;
    scene.stages = {stage_with("pull", 2, {displacement("tip", BodyDof::x, 0.02)}),
                    stage_with("bend", 4, {displacement("tip", BodyDof::ry, 0.2)})};
    const RunResult result = run_scene(scene);
    expect_done(result);
    double pull = 0;
    for (const Increment& i : result.increments)
      if (i.stage == "pull") pull = i.bodies.force[1].x();
    // E A (λ² − 1)/2 λ for a section that may contract; clamped ends keep it from that, up to the uniaxial-strain
    // modulus 1.346.
    const double free = pi * 0.5 * (1.01 * 1.01 - 1) * 1.01;
    measured(fmt::format("{}: force over that of free contraction {:.4f}, {} Newton iterations",
                         model == FiberModel::rod ? "rod" : "enriched", pull / free,
                         result.summary.n_newton_iterations));
    EXPECT_GT(pull / free, 0.99);
    // A rod's tie holds the length of its tangent too, and so the strain at its ends (see the table).
    if (model == FiberModel::enriched) {
      EXPECT_LT(pull / free, 1.36);
    }
  }
}

TEST(Sizes, ShortFibersInContact) {
  // Two stubs, one diameter long, on top of each other and pressed.
  Pair pair;
  pair.length = 2;
  pair.n_elements = 1;
  pair.height = 1.99;
  for (const double angle : {0.0, 0.5 * pi}) {
    pair.angle = angle;
    Scene scene = pair_scene(pair);
    scene.stages = {stage_with("press", 4, {displacement("grip", BodyDof::z, -0.1)})};
    const RunResult result = run_scene(scene);
    expect_done(result);
    const double carried = normal_resultant(result.last()).z(), pushed = -result.last().bodies.force[1].z();
    measured(fmt::format("angle {:.0f} deg: load error {:.1e}, penetration {:.3f} R", angle * 180 / pi,
                         std::abs(carried / pushed - 1), penetration(result.last())));
    EXPECT_GT(carried, 0);
    EXPECT_LT(std::abs(carried / pushed - 1), 1e-2);
    EXPECT_LT(penetration(result.last()), 0.2);
  }
}

/// Crossed fibers pressed by a displacement, with few or many elements. Returns the reaction.
double crossed_reaction(FiberModel model, Index n_elements, double length) {
  Pair pair;
  pair.model = model;
  pair.angle = pi / 2;
  pair.height = 1.99;
  pair.length = length;
  pair.n_elements = n_elements;
  Scene scene = pair_scene(pair);
  scene.solver.force_tolerance = scene.solver.geometry_tolerance =
      1e-6;  // long fibers carry far more along than across
  scene.solver.max_geometry_updates = 20;
  scene.stages = {stage_with("press", 6, {displacement("grip", BodyDof::z, -0.005 * length)})};
  const RunResult result = run_scene(scene);
  expect_done(result);
  const double pushed = -result.last().bodies.force[1].z();
  EXPECT_LT(std::abs(normal_resultant(result.last()).z() / pushed - 1), 1e-2);
  measured(fmt::format("{}, {} elements of {:.2f} R: force {:.3e} E R^2, {} Newton iterations, {} cuts",
                       model == FiberModel::rod ? "rod" : "enriched", n_elements, length / n_elements, pushed,
                       result.summary.n_newton_iterations, result.summary.n_cut_increments));
  return pushed;
}

TEST(Sizes, OneElementAFiber) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) EXPECT_GT(crossed_reaction(model, 1, 20), 0);
}

TEST(Sizes, ThreeHundredElementsAFiber) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod})
    EXPECT_GT(crossed_reaction(model, 300, 600), 0);
}

TEST(Sizes, ElementsShorterThanThick) {
  // 100 elements of a fifth of a radius: samples far closer than the fibers are thick.
  const double fine = crossed_reaction(FiberModel::enriched, 100, 20),
               coarse = crossed_reaction(FiberModel::enriched, 20, 20);
  EXPECT_NEAR(fine / coarse, 1, 0.1);
}

TEST(Sizes, CantileverOfOneElement) {
  // A cubic is exact for a tip force, so one rod element is. A 3-node element with two Gauss points finds the right
  // end, too.
  constexpr double length = 20, deflection = 0.02;
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    Scene scene = cantilever(model, 0, length, 1);
    scene.solver.force_tolerance = scene.solver.geometry_tolerance = 1e-5;
    const double load = deflection * 3 * (pi / 4) / (length * length * length);
    scene.stages = {stage_with(
        "bend", 1, {force("tip", BodyDof::z, load), force("tip", BodyDof::x, 0), force("tip", BodyDof::ry, 0)})};
    const RunResult result = run_scene(scene);
    expect_done(result);
    measured(fmt::format("{}: deflection over theory {:.4f}", model == FiberModel::rod ? "rod" : "enriched",
                         result.tip().z() / deflection));
    if (model == FiberModel::rod) {
      EXPECT_NEAR(result.tip().z() / deflection, 1, 3e-3);  // ties: 3·10⁻³ for one element
    }
    EXPECT_GT(result.tip().z() / deflection, 0.5);
    EXPECT_LT(result.tip().z() / deflection, 1.2);
  }
}

/// A strand of seven fibers, a third of a turn, pulled by `strain` in `n` increments.
RunResult pulled_strand(double strain, Index n, Index max_iterations, ContactScope scope = ContactScope::all) {
  Scene scene;
  scene.name = "strand";
  scene.materials = {isotropic(1, 0.3)};
  scene.fiber_types = {{"f", 0, 1.0, FiberModel::enriched}};
  scene.bundles = {{"strand", 0, {{0, 0, 0}, {60, 0, 0}}, 10, 7, 0, 1.05, 0.33}};
  scene.bodies = {{"left", {0, 0, 0}, {{"strand", FiberEnd::start, TieKind::clamped}}},
                  {"right", {60, 0, 0}, {{"strand", FiberEnd::end, TieKind::clamped}}}};
  scene.contact.friction = false;
  scene.contact.scope = scope;
  scene.solver.max_newton_iterations = max_iterations;
  scene.solver.geometry_tolerance = 1e-4;
  scene.stages = {stage_with("pull", n, {displacement("right", BodyDof::x, 60 * strain)})};
  return run_scene(scene);
}

TEST(Sizes, TenPercentInOneIncrement) {
  const RunResult one = pulled_strand(0.1, 1, 40), many = pulled_strand(0.1, 40, 40);
  expect_done(one);
  expect_done(many);
  const double f = one.last().bodies.force[1].x(), g = many.last().bodies.force[1].x();
  measured(fmt::format("force in one and in 40 increments {:.5f} {:.5f} E R^2; {} cuts, {} Newton iterations", f, g,
                       one.summary.n_cut_increments, one.summary.n_newton_iterations));
  EXPECT_NEAR(f / g, 1, 2e-3);
}

TEST(Sizes, TenPercentMustBeCut) {
  // 6 R in Newton steps of half a radius, of which four are allowed: it is cut, and the result is that of small
  // increments.
  const RunResult one = pulled_strand(0.1, 1, 4, ContactScope::none),
                  many = pulled_strand(0.1, 40, 40, ContactScope::none);
  expect_done(one);
  expect_done(many);
  const double f = one.last().bodies.force[1].x(), g = many.last().bodies.force[1].x();
  measured(fmt::format("{} cuts, {} increments, force {:.5f} against {:.5f} E R^2", one.summary.n_cut_increments,
                       one.summary.n_increments, f, g));
  EXPECT_GT(one.summary.n_cut_increments, 0);
  EXPECT_NEAR(f / g, 1, 2e-3);
}

TEST(Sizes, TinyIncrements) {
  // A strain of 10⁻⁵ in 200 increments of 5·10⁻⁸.
  const RunResult result = pulled_strand(1e-5, 200, 40);
  expect_done(result);
  const double force = result.last().bodies.force[1].x(), once = pulled_strand(1e-5, 1, 40).last().bodies.force[1].x();
  measured(fmt::format("force over that of one increment {:.6f}, {} increments, {} Newton iterations", force / once,
                       result.summary.n_increments, result.summary.n_newton_iterations));
  EXPECT_NEAR(force / once, 1, 1e-3);
}

TEST(Sizes, LoadOfATrillionth) {
  // A strain of 10⁻¹² is below what double precision resolves beside coordinates of 60 R: zero force within round-off,
  // not a failure.
  const RunResult result = pulled_strand(1e-12, 2, 40);
  expect_clear_status(result);
  measured(
      fmt::format("{}, force {:.1e} E R^2", result.done() ? "done" : "gave up", result.last().bodies.force[1].x()));
}

// Known to fail: gives up where the arch snaps.
TEST(SizesStudy, SlackFibersAcrossEachOther) {
  // Both fibers are longer than the distance of their ends, free of stress in that shape, and hang in each other's way;
  // the upper one is carried down by four diameters and back without any tension. The lower, an arch, snaps through on
  // the way and stays so.
  const auto arc = [](const Vec3& from, const Vec3& to, const Vec3& bow) -> std::vector<Vec3> {
    return {from, 0.5 * (from + to) + bow, to};
  };
  for (const bool friction : {false, true}) {
    Pair pair;
    pair.friction = friction;
    Scene scene = pair_scene(pair);
    scene.fibers[0].points = arc({-20, 0, 0}, {20, 0, 0}, {0, 0, 5});
    scene.fibers[1].points = arc({0, -20, 10}, {0, 20, 10}, {0, 0, -2.9});
    scene.bodies[1].position = {0, 0, 10};
    scene.stages = {stage_with("rest", 2, {}), stage_with("down", 10, {displacement("grip", BodyDof::z, -8)}),
                    stage_with("hold", 4, {}), stage_with("up", 10, {displacement("grip", BodyDof::z, 8)})};
    const RunResult result = run_scene(scene);
    expect_done(result);
    double deepest = 0, held = 0;
    for (const Increment& i : result.increments) {
      deepest = std::max(deepest, penetration(i));
      if (i.stage == "hold") held = penetration(i);
    }
    measured(fmt::format("{}: penetration {:.3f} R on the way, {:.3f} R held, {} Newton iterations, {} cuts",
                         friction ? "friction" : "smooth", deepest, held, result.summary.n_newton_iterations,
                         result.summary.n_cut_increments));
    // Penalties rise by up to four an increment, so the first touch goes deeper than the target of 0.03 R, but not
    // half-way to the axis.
    EXPECT_LT(deepest, 0.5);
    EXPECT_LT(held, 0.06);
  }
}

/// Two by two yarns woven while nothing pulls at their ends, which are free to move along their yarns.
RunResult slack_weave(bool friction) {
  Scene scene;
  scene.name = "slack";
  scene.materials = {isotropic(3e9, 0.3)};
  const double radius = 1e-5;
  scene.fiber_types = {{"f", 0, radius, FiberModel::rod}};
  const YarnSystem yarns{
      {{.type = 0, .n_fibers = 4, .n_layers = 2, .lattice_spacing = 1.05}}, {0}, 2, 10, 14 * radius, 10 * radius};
  scene.weave = Weave{{{false, true}, {true, false}}, yarns, yarns};
  Stage separate = stage_with("separate", 12, {});
  for (const char* end : {"start", "end"}) {
    separate.drives.push_back(force(std::string("warp/*/") + end, BodyDof::x, 0));
    separate.drives.push_back(force(std::string("weft/*/") + end, BodyDof::y, 0));
  }
  separate.separate_yarns = true;
  separate.friction = false;
  separate.proximal_start = separate.proximal_end = 1e-2;
  Stage relax = separate;
  relax.name = "relax";
  relax.separate_yarns = false;
  relax.friction = friction;
  relax.proximal_end = 1e-4;
  scene.stages = {separate, relax};
  return run_scene(scene);
}

TEST(Sizes, WeaveWithoutTension) {
  // Friction alone holds slack yarns. Without it nothing does: a yarn whose ends are both pulled by the same force,
  // however large, is free to slide along itself, and bending drives it out of its crossings. Then the summary must say
  // so.
  for (const bool friction : {true, false}) {
    const RunResult result = slack_weave(friction);
    expect_clear_status(result);
    measured(fmt::format("{}: {}: crossings in order {} of {}, penetration {:.3f} R, {} Newton iterations, {} cuts",
                         friction ? "friction" : "smooth", result.done() ? "done" : "gave up",
                         result.summary.n_crossings_ok, result.summary.n_crossings,
                         result.summary.max_penetration_over_radius, result.summary.n_newton_iterations,
                         result.summary.n_cut_increments));
    EXPECT_LT(result.summary.max_penetration_over_radius, 0.2);
    EXPECT_EQ(result.summary.crossing_order_ok, result.summary.n_crossings_ok == 4);
    if (friction) {
      EXPECT_TRUE(result.done()) << result.summary.message;
      EXPECT_EQ(result.summary.n_crossings_ok, 4);
    }
  }
}

}  // namespace
}  // namespace trame::micro
