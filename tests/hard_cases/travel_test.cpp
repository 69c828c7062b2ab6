/// \file
/// Hard cases of motion: fibers that travel far in one increment, alone, or at each other.

#include <numbers>

#include "tests/support/hard_case.h"

namespace trame::micro {
namespace {

using namespace test;

TEST(Travel, AFiberThatNothingIsNearTakesFewIterations) {
  for (const FiberModel model : {FiberModel::rod, FiberModel::enriched}) {
    Scene scene = pair_scene({model});
    scene.fibers.pop_back();
    scene.bodies.pop_back();
    scene.stages = {stage_with("lift", 1, {displacement("table", BodyDof::z, 50)})};
    const RunResult result = run_scene(scene);
    expect_done(result);
    double off = 0;
    for (const Vec3& r : result.last().fibers.r) off = std::max(off, std::abs(r.z() - 50));
    measured(fmt::format("{} Newton iterations, off by {:.1e} R", result.summary.n_newton_iterations, off));
    EXPECT_LT(off, 1e-6);
    EXPECT_LE(result.summary.n_newton_iterations, 20);  // 200 where each may move it by half a radius twice
  }
}

// Thrown from any height in one increment, a fiber lands on the other and is held by it as if it had been laid down.
TEST(Travel, FibersThrownAtEachOtherDoNotPassThrough) {
  constexpr double degree = std::numbers::pi / 180, pressed_by = 0.5;
  for (const FiberModel model : {FiberModel::rod, FiberModel::enriched})
    for (const double angle : {90 * degree, 30 * degree, 10 * degree}) {
      double laid_down = 0;
      for (const double height : {0.0, 1.0, 10.0, 100.0, 1000.0}) {
        SCOPED_TRACE(fmt::format("{} degrees from {} R", angle / degree, height));
        Pair pair{model};
        pair.angle = angle;
        pair.height = 2 + height;
        Scene scene = pair_scene(pair);
        scene.stages = {stage_with("throw", 1, {displacement("grip", BodyDof::z, -height - pressed_by)})};
        const RunResult result = run_scene(scene);
        expect_done(result);
        const double force = normal_resultant(result.last()).z();
        if (height == 0) laid_down = force;
        measured(fmt::format("from {} R: force {:.6e} E R^2, {} iterations", height, force,
                             result.summary.n_newton_iterations));
        EXPECT_GT(node_at(result, 1, 0.5).z() - node_at(result, 0, 0.5).z(), 1.9);
        EXPECT_NEAR(force, laid_down, 1e-2 * laid_down);
      }
    }
}

}  // namespace
}  // namespace trame::micro
