/// \file
/// Hard cases of friction: reversal of sliding, none to much of it, sticking for long, loads to zero and back.

#include <numbers>

#include "tests/support/hard_case.h"

namespace trame::micro {
namespace {

using namespace test;

/// Two short, stiff fibers across each other. The upper one is pressed on with `load`, then dragged to and fro along
/// the lower.
struct Drag {
  double friction = 0.5;
  double load = 1e-3;
  double stroke = 2;  ///< R
  Index n_increments = 10;
  FiberModel model = FiberModel::enriched;
};

Scene drag_scene(const Drag& d) {
  Pair pair;
  pair.model = d.model;
  pair.angle = std::numbers::pi / 2;
  pair.length = 10;
  pair.n_elements = 5;
  pair.height = 1.995;
  pair.friction = true;
  Scene scene = pair_scene(pair);
  scene.contact.friction_coefficient = d.friction;
  scene.contact.adapt_penalty = false;
  scene.solver.force_tolerance = 1e-6;
  scene.solver.geometry_tolerance = 1e-5;
  scene.solver.max_geometry_updates = 30;
  const Drive press = force("grip", BodyDof::z, -d.load);
  const auto stroke = [&](const std::string& name, double by) {
    return stage_with(name, d.n_increments, {press, displacement("grip", BodyDof::x, by)});
  };
  scene.stages = {stage_with("press", 4, {press}), stroke("forth", d.stroke), stroke("back", -2 * d.stroke),
                  stroke("again", 2 * d.stroke)};
  return scene;
}

/// The grip's pull along x at the end of a stage, over the load.
double drag_force(const RunResult& result, const std::string& stage, double load) {
  double pull = 0;
  for (const Increment& i : result.increments)
    if (i.stage == stage) pull = i.bodies.force[1].x();
  return pull / load;
}

bool dissipation_never_falls(const RunResult& result) {
  for (std::size_t i = 1; i < result.increments.size(); ++i)
    if (result.increments[i].solver.energy.friction < result.increments[i - 1].solver.energy.friction - 1e-15)
      return false;
  return true;
}

TEST(Friction, ReversalForCoefficientsFromNoneToOneAndAHalf) {
  for (const double mu : {0.0, 0.05, 0.2, 0.5, 1.0, 1.5}) {
    Drag d;
    d.friction = mu;
    const RunResult result = run_scene(drag_scene(d));
    expect_done(result);
    const double forth = drag_force(result, "forth", d.load), back = drag_force(result, "back", d.load),
                 again = drag_force(result, "again", d.load);
    // Three strokes of 2, 4 and 4 R slide all but the elastic slip u_rev = 0.05 R, once at the start and twice at each
    // reversal, and what the fibers give.
    const double slid = 10 - 5 * 0.05, dissipated = result.summary.energy.friction / d.load;
    measured(fmt::format("mu {}: drag over load {:.4f} {:.4f} {:.4f}, dissipated over mu N slip {:.4f}, {} cuts", mu,
                         forth, back, again, mu > 0 ? dissipated / (mu * slid) : dissipated,
                         result.summary.n_cut_increments));
    // The lower fiber sags by F L³/192 EI = 0.007 R, so the load leans by up to 0.003.
    EXPECT_NEAR(forth, mu, 0.01 * mu + 3e-3);
    EXPECT_NEAR(back, -mu, 0.01 * mu + 3e-3);
    EXPECT_NEAR(again, mu, 0.01 * mu + 3e-3);
    EXPECT_NEAR(dissipated, mu * slid, 0.02 * mu * slid);
    EXPECT_TRUE(dissipation_never_falls(result));
  }
}

TEST(Friction, CycleBalancesItsEnergy) {
  // Increments well below the elastic slip of 0.05 R: the work of a force that rises within an increment is taken by
  // the trapezoidal rule. Every loop is open, and its area is what friction took.
  Drag d;
  d.n_increments = 80;
  const RunResult result = run_scene(drag_scene(d));
  expect_done(result);
  measured(fmt::format("imbalance over work {:.4f}, dissipated {:.3f} mu N R", relative_imbalance(result),
                       result.summary.energy.friction / (d.friction * d.load)));
  EXPECT_LT(relative_imbalance(result), 0.01);
  EXPECT_GT(result.summary.energy.external_work, 0);
  EXPECT_TRUE(dissipation_never_falls(result));
}

TEST(Friction, NoneDissipatesNothing) {
  Drag d;
  d.friction = 0;
  const RunResult result = run_scene(drag_scene(d));
  expect_done(result);
  measured(fmt::format("dissipated {:.1e}", result.summary.energy.friction));
  EXPECT_EQ(result.summary.energy.friction, 0);
}

TEST(Friction, IndependentOfTheSizeOfIncrements) {
  // Rates do not enter: as many increments as one likes, the same force and the same work.
  std::vector<double> work;
  for (const Index n : {4, 16, 64}) {
    Drag d;
    d.n_increments = n;
    const RunResult result = run_scene(drag_scene(d));
    expect_done(result);
    EXPECT_NEAR(drag_force(result, "again", d.load), d.friction, 0.01 * d.friction);
    work.push_back(result.summary.energy.friction / (d.load * d.friction));
  }
  measured(fmt::format("slip for 4, 16, 64 increments a stroke: {:.4f} {:.4f} {:.4f} R", work[0], work[1], work[2]));
  EXPECT_NEAR(work[0], work[2], 0.01 * work[2]);
  EXPECT_NEAR(work[1], work[2], 0.01 * work[2]);
}

TEST(Friction, SticksBelowTheLimitForTwoHundredIncrements) {
  // Held by 95 % of µN for 200 increments: what gives way is elastic, and no more with time.
  const double mu = 0.5, load = 1e-3, share = 0.95;
  Drag d;
  d.friction = mu;
  Scene scene = drag_scene(d);
  const Drive press = force("grip", BodyDof::z, -load), pull = force("grip", BodyDof::x, share * mu * load);
  scene.stages = {scene.stages[0], stage_with("pull", 20, {press, pull}), stage_with("hold", 200, {press, pull})};
  const RunResult result = run_scene(scene);
  expect_done(result);
  double at_pull = 0;
  for (const Increment& i : result.increments)
    if (i.stage == "pull") at_pull = i.bodies.position[1].x();
  const double crept = result.last().bodies.position[1].x() - at_pull;
  measured(fmt::format("moved {:.4f} R while the pull rose, {:.1e} R in 200 increments of holding", at_pull, crept));
  EXPECT_LT(at_pull, 0.05 * 1.5);
  EXPECT_LT(std::abs(crept), 1e-4);
}

TEST(Friction, JustAboveTheLimitNothingHolds) {
  // A body pulled by 105 % of µN slides away without end: no equilibrium, and no state that pretends to be one.
  const double mu = 0.5, load = 1e-3;
  Drag d;
  d.friction = mu;
  Scene scene = drag_scene(d);
  scene.solver.min_increment = 1e-2;
  const Drive press = force("grip", BodyDof::z, -load), pull = force("grip", BodyDof::x, 1.05 * mu * load);
  scene.stages = {scene.stages[0], stage_with("pull", 21, {press, pull})};
  const RunResult result = run_scene(scene);
  expect_clear_status(result);
  const double held = result.last().bodies.force[1].x() / (mu * load);
  measured(fmt::format("{}: last state holds {:.3f} of the limit: {}", result.done() ? "done" : "gave up", held,
                       result.summary.message.substr(0, 90)));
  EXPECT_FALSE(result.done());
  EXPECT_GT(held, 0.9);
  EXPECT_LE(held, 1.001);
}

/// Seven fibers clamped together at the left, bent by a body at the right and let go again.
RunResult bent_strand(double friction, double reversible_slip) {
  Scene scene;
  scene.name = "strand";
  scene.materials = {isotropic(1, 0.3)};
  scene.fiber_types = {{"f", 0, 1.0, FiberModel::enriched}};
  scene.bundles = {{"strand", 0, {{0, 0, 0}, {60, 0, 0}}, 10, 7, 0, 1.0, 0.5}};
  scene.bodies = {{"left", {0, 0, 0}, {{"strand", FiberEnd::start, TieKind::clamped}}},
                  {"right", {60, 0, 0}, {{"strand", FiberEnd::end, TieKind::clamped}}}};
  scene.contact.friction = friction > 0;
  scene.contact.friction_coefficient = friction;
  scene.contact.reversible_slip = reversible_slip;
  scene.solver.force_tolerance = 1e-5;
  scene.solver.geometry_tolerance = 1e-3;
  const Drive pull = force("right", BodyDof::x, 0.05);
  scene.stages = {stage_with("pull", 4, {pull})};
  scene.stages.push_back(stage_with("bend", 10, {pull, displacement("right", BodyDof::y, 4)}));
  scene.stages.push_back(stage_with("back", 10, {pull, displacement("right", BodyDof::y, -4)}));
  scene.stages.push_back(stage_with("release", 4, {force("right", BodyDof::x, 0)}));
  return run_scene(scene);
}

// Known to fail: 3 % at u_rev = 0.002 R. In the first increment preloads take over the whole of a contact that is soft
// at first, in rounds too large for the mean of their forces.
TEST(FrictionStudy, StrandToZeroAndBackHasAPositiveHysteresis) {
  // The smaller the reversible slip beside the true one (about 0.1 R here), the larger the hysteresis (see the table).
  for (const double reversible_slip : {0.05, 0.01, 0.002}) {
    const RunResult result = bent_strand(0.3, reversible_slip);
    expect_done(result);
    const EnergyRecord& e = result.summary.energy;
    measured(fmt::format(
        "u_rev {} R: work over the cycle {:.2e}, stored at its end {:.1e}, friction {:.2e}, imbalance {:.3f}, {} cuts",
        reversible_slip, e.external_work, e.stored, e.friction, relative_imbalance(result),
        result.summary.n_cut_increments));
    EXPECT_TRUE(dissipation_never_falls(result));
    EXPECT_GT(e.friction, 0);
    EXPECT_GT(e.external_work, 0);
    if (reversible_slip == 0.002) {
      EXPECT_LT(relative_imbalance(result), 0.01);
    }
  }
}

TEST(Friction, WithoutItTheStrandReturns) {
  const RunResult result = bent_strand(0, 0.05);
  expect_done(result);
  const double back = (result.tip() - result.increments[0].fibers.r[result.last_node(0)]).norm();
  measured(
      fmt::format("tip returns to {:.1e} R, work over the cycle {:.1e}", back, result.summary.energy.external_work));
  EXPECT_LT(back, 1e-2);
  EXPECT_EQ(result.summary.energy.friction, 0);
}

}  // namespace
}  // namespace trame::micro
