/// \file
/// Runs of periodic cells against closed forms, and one repeat against four.

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "micro/run/stage_settings.h"
#include "tests/periodic/periodic_fixture.h"
#include "tests/periodic/plain_cell.h"

namespace trame::micro {
namespace {

using test::Cell;
using test::CellOptions;
using test::run_scene;
using test::RunResult;

constexpr double area = std::numbers::pi;  // of a fiber of radius 1

// Straight fibers without contact: each is a bar with the period at its end.
TEST(PeriodicCell, StraightFibersPullAsBars) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    Scene scene = test::cell_scene({.model = model, .n_warp = 3, .n_weft = 2});
    scene.contact.scope = ContactScope::none;
    scene.stages[0].n_increments = 10;
    scene.stages[0].drives = {{"cell/warp", BodyDof::x, DriveMode::strain, 0.02, ""},
                              {"cell/weft", BodyDof::y, DriveMode::force, 0.01, ""}};
    const RunResult result = run_scene(scene);
    ASSERT_TRUE(result.done()) << result.summary.message;
    const CurvePoint& end = result.summary.curve.back();
    const auto pull = [](double stretch) { return area * 0.5 * (stretch * stretch - 1) * stretch; };
    EXPECT_NEAR(end.side_strain[0], 0.02, 1e-12);
    // Sections that narrow are held back by their anchors, a little.
    EXPECT_NEAR(end.side_force[0], 3 * pull(1.02), 1e-7 * pull(1.02));
    // The other period is free to go with its load.
    EXPECT_NEAR(end.side_force[1], 0.01, 1e-9);
    EXPECT_NEAR(2 * pull(1 + end.side_strain[1]), 0.01, 1e-6 * 0.01);
    // The last node stays a period from the first one.
    const auto& r = result.last().fibers.r;
    EXPECT_NEAR((result.tip(0) - r[0]).x(), 10 * 1.02, 1e-9);
    EXPECT_LT(std::abs(end.energy.imbalance), 1e-3 * end.energy.stored);
  }
}

// A shallow wave of amplitude a, free of stress, under a pull P: with P_E = E I (2π/L)² its amplitude becomes
// a / (1 + P/P_E), and the period grows by P L/E A + π²a²/L (1 − (1 + P/P_E)⁻²).
TEST(PeriodicCell, AWavyFiberStraightens) {
  constexpr double amplitude = 0.2, length = 60, inertia = area / 4;
  const double euler = inertia * std::pow(2 * std::numbers::pi / length, 2), pull = 0.8 * euler;
  Scene scene = test::cell_scene({.n_warp = 1, .n_weft = 12, .n_elements = 16});
  scene.contact.scope = ContactScope::none;
  scene.stages[0].drives = {{"cell/warp", BodyDof::x, DriveMode::force, pull, ""}};
  Assembly assembly = assemble_scene(scene);
  const FiberMesh& mesh = assembly.mesh;
  FiberConfiguration& c = assembly.configuration;
  for (Index n = mesh.first_node[0]; n < mesh.first_node[1]; ++n) {
    const double phase = 2 * std::numbers::pi * mesh.arc_length[n] / length;
    c.r[n].z() = amplitude * std::sin(phase);
    c.tangent[n] = Vec3(1, 0, amplitude * 2 * std::numbers::pi / length * std::cos(phase)).normalized();
    c.g1[n] = Vec3::UnitY();
    c.g2[n] = c.tangent[n].cross(c.g1[n]);
  }
  const StageStart start = start_of(assembly);
  StageModel model(scene, assembly, scene.stages[0], start);
  Timers timers;
  NewtonSolver newton(model.layout, newton_settings(scene, model, [] { return false; }), 1, timers);
  State state = model.start;
  begin_at(model.effects, state, 1);
  newton.cover_sparsity(model.effects);
  const NewtonOutcome outcome = newton.solve(model.effects, model.motion(state, 0, 1), 1, state, {});
  ASSERT_TRUE(outcome.converged()) << describe(outcome.status);
  const double growth = model.field.period(state, 0).x() - length, shrunk = 1 / (1 + pull / euler);
  const double expected =
      pull * length / area + std::pow(std::numbers::pi * amplitude, 2) / length * (1 - shrunk * shrunk);
  EXPECT_NEAR(growth, expected, 0.01 * expected);
  EXPECT_NEAR(model.field.curve(state, 0, length / 4).r.z() - model.field.curve(state, 0, 3 * length / 4).r.z(),
              2 * amplitude * shrunk, 0.01 * amplitude);
  EXPECT_NEAR(model.pull(state, assembly.period_bodies[0]).first.x(), pull, 1e-9);
}

/// A plain weave of `n` by `n` yarns, woven and pulled with friction, but woven without: on the way to a woven state,
/// which is found only roughly, friction would keep what differs. Penalties that adapt do so over so many contacts in a
/// row, which depends on where a fiber begins: they stay.
Scene woven_cell(Index n, Index fibers) {
  Scene scene = parse_scene(
      test::plain_cell({.warps = n,
                        .wefts = n,
                        .fibers = fibers,
                        .more = "[effects]\nadapt_penalty = false\n[solver]\nforce_tolerance = 1e-8\n[test]\nkind = "
                                "\"biaxial\"\nwarp_strain = 0.01\nweft_strain = 0.005\nincrements = 3"}),
      "cell.toml");
  for (Stage& stage : scene.stages) stage.friction = stage.name == "biaxial";
  return scene;
}

void expect_four_are_like_one(const RunResult& one, const RunResult& four, double tolerance) {
  ASSERT_TRUE(one.done()) << one.summary.message;
  ASSERT_TRUE(four.done()) << four.summary.message;
  EXPECT_EQ(one.summary.n_crossings_ok, 4);
  EXPECT_EQ(four.summary.n_crossings_ok, 16);
  for (int d = 0; d < 2; ++d) {
    const double force = one.summary.curve.back().side_force[d];
    EXPECT_GT(force, 0);
    EXPECT_NEAR(four.summary.curve.back().side_force[d], 2 * force, 2 * tolerance * force) << d;
  }
  EXPECT_NEAR(four.summary.energy.stored, 4 * one.summary.energy.stored, 4 * tolerance * one.summary.energy.stored);
  // What the periods' forces do is what comes in.
  EXPECT_LT(std::abs(one.summary.energy.imbalance), 0.02 * one.summary.energy.external_work);
}

TEST(PeriodicCell, TwoByTwoRepeatsAreLikeOne) {
  expect_four_are_like_one(run_scene(woven_cell(2, 1)), run_scene(woven_cell(4, 1)), 1e-6);
}

TEST(PeriodicCellStudy, TwoByTwoRepeatsOfYarnsAreLikeOne) {
  expect_four_are_like_one(run_scene(woven_cell(2, 3)), run_scene(woven_cell(4, 3)), 1e-6);
}

// A run that was left in each stage goes on to what it would have been, to the bit.
TEST(PeriodicCell, GoesOnToTheBit) {
  const Scene scene = parse_scene(
      test::plain_cell({.fibers = 2, .more = "[test]\nkind = \"biaxial\"\nwarp_strain = 0.01\nincrements = 3"}),
      "cell.toml");
  const RunResult whole = run_scene(scene);
  const trame::test::TemporaryFolder folder;
  SimulateOptions options;
  options.states = folder / "states.h5";
  options.n_threads = 1;
  options.resume = true;
  std::atomic<bool> stop = false;
  options.stop = &stop;
  options.on_increment = [&](const Progress& progress) { stop = progress.increment % 9 == 0; };
  SimulationSummary summary;
  int n_runs = 0;
  do {
    stop = false;
    summary = simulate(scene, options);
    ASSERT_LT(++n_runs, 20);
  } while (summary.status == SimulationSummary::Status::interrupted);
  ASSERT_EQ(summary.status, SimulationSummary::Status::done) << summary.message;
  EXPECT_GT(n_runs, 3);
  const SnapshotReader reader(options.states);
  ASSERT_EQ(reader.n_increments(), static_cast<Index>(whole.increments.size()));
  const Increment last = reader.read(reader.n_increments() - 1);
  EXPECT_EQ(last.fibers.r, whole.last().fibers.r);
  EXPECT_EQ(last.contacts.s_a, whole.last().contacts.s_a);
  EXPECT_EQ(last.contacts.image_warp, whole.last().contacts.image_warp);
  EXPECT_EQ(last.bodies.force, whole.last().bodies.force);
}

}  // namespace
}  // namespace trame::micro
