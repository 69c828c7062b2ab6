/// \file
/// Few fibers between others that are held: a system of their own gives what the whole one gives with all else
/// prescribed, and touches nothing else.

#include "micro/model/model.h"
#include "micro/run/stage_settings.h"
#include "micro/solve/newton.h"
#include "tests/support/hard_case.h"

namespace trame::micro {
namespace {

using namespace test;

/// Three fibers over one, all pressed upon it by what their bodies do.
Scene crossed(FiberModel model, bool friction) {
  Scene scene = pair_scene({.model = model, .angle = 1.2, .height = 1.9, .friction = friction});
  for (const double x : {-8.0, 8.0}) {
    FiberSpec fiber = scene.fibers[1];
    fiber.name = x < 0 ? "left" : "right";
    for (Vec3& point : fiber.points) point.x() += x;
    BodySpec body = scene.bodies[1];
    body.name = fiber.name + " grip";
    body.position.x() += x;
    for (auto& tie : body.ties) tie.fibers = fiber.name;
    scene.fibers.push_back(fiber);
    scene.bodies.push_back(body);
  }
  scene.stages = {stage_with("press", 1, {})};
  return scene;
}

struct Solved {
  State state;
  NewtonOutcome outcome;
  double n_entries = 0;
};

/// The equilibrium of fibers 0 and 2 with all else where it is.
Solved settle(const Scene& scene, bool by_themselves) {
  const Assembly assembly = assemble_scene(scene);
  StageModel model(scene, assembly, scene.stages[0], start_of(assembly));
  std::vector<char> is_free(model.layout.n_nodes(), 0);
  PrescribedMotion held = model.motion(model.start, 0, 1);
  std::fill(held.fixed.begin(), held.fixed.end(), 1);
  std::fill(held.motion.begin(), held.motion.end(), 0.0);
  for (const Index fiber : {0, 2})
    for (Index n = model.field.element_node(fiber, 0); n <= model.field.last_node(fiber); ++n) {
      is_free[n] = 1;
      std::fill(held.fixed.begin() + model.layout.first_dof(n), held.fixed.begin() + model.layout.first_dof(n + 1), 0);
    }
  Timers timers;
  NewtonSettings settings = newton_settings(scene, model, [] { return false; });
  settings.renews_limits = false;
  NewtonSolver newton(model.layout, std::move(settings), 2, timers, by_themselves ? Region(is_free) : Region());
  Solved solved{.state = model.start, .outcome = {}};
  begin_at(model.effects, solved.state, 1);
  newton.cover_sparsity(model.effects);
  solved.n_entries = newton.n_matrix_entries();
  solved.outcome = newton.solve(model.effects, held, 1, solved.state, {});
  return solved;
}

class RegionTest : public testing::TestWithParam<std::pair<FiberModel, bool>> {};

TEST_P(RegionTest, FewFibersSettleAsInTheWholeSystem) {
  const Scene scene = crossed(GetParam().first, GetParam().second);
  const Solved whole = settle(scene, false), few = settle(scene, true);
  ASSERT_TRUE(whole.outcome.converged()) << describe(whole.outcome.status);
  ASSERT_TRUE(few.outcome.converged()) << describe(few.outcome.status);
  EXPECT_LT(few.n_entries, whole.n_entries);
  const Assembly assembly = assemble_scene(scene);
  const StageModel model(scene, assembly, scene.stages[0], start_of(assembly));
  double moved = 0, held = 0, difference = 0;
  for (Index f = 0; f < 4; ++f)
    for (Index n = model.field.element_node(f, 0); n <= model.field.last_node(f); ++n)
      for (Index v = model.layout.first_vector(n); v < model.layout.first_vector(n + 1); ++v) {
        const double step = (few.state.q[v] - model.start.q[v]).norm();
        (f == 0 || f == 2 ? moved : held) += step;
        difference = std::max(difference, (few.state.q[v] - whole.state.q[v]).norm());
      }
  EXPECT_GT(moved, 0.1);
  EXPECT_EQ(held, 0);
  EXPECT_LT(difference, 1e-8);
}

INSTANTIATE_TEST_SUITE_P(Fibers, RegionTest,
                         testing::Values(std::pair(FiberModel::enriched, false), std::pair(FiberModel::enriched, true),
                                         std::pair(FiberModel::rod, false), std::pair(FiberModel::rod, true)));

}  // namespace
}  // namespace trame::micro
