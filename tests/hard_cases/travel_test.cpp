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

// What one fiber is loaded with does not excuse the rest of another's travel.
TEST(Travel, AFiberIsInEquilibriumBesideOneThatIsLoaded) {
  const auto held = [](const std::string& name, double z) {
    std::string text = fmt::format(R"(
      [[fiber]]
      name = "{0}"
      fiber_type = "t"
      points = [["-0.3 mm", "0 mm", "{1} mm"], ["0.3 mm", "0 mm", "{1} mm"]]
      elements = 24
      )",
                                   name, z);
    for (const auto& [end, x] : {std::pair("start", -0.3), std::pair("end", 0.3)})
      text += fmt::format(R"(
        [[body]]
        name = "{0}/{1}"
        position = ["{2} mm", "0 mm", "{3} mm"]
        tie = [{{ fibers = "{0}", end = "{1}" }}]
        )",
                          name, end, x, z);
    return text;
  };
  for (const char* model : {"rod", "enriched"}) {
    const Scene scene = parse_scene(fmt::format(R"(
      material.m = {{ model = "isotropic", young_modulus = "3 GPa", poisson_ratio = 0.3 }}
      fiber_type.t = {{ material = "m", diameter = "20 um", model = "{}" }}
      {} {}
      [[stage]]
      name = "lift"
      increments = 2
      drive = [{{ bodies = "loaded/end", dof = "x", displacement = "12 um" }},
               {{ bodies = "lifted/*", dof = "z", displacement = "-36 um" }}]
      )",
                                                model, held("loaded", 0), held("lifted", 1)),
                                    "beside");
    const RunResult result = run_scene(scene);
    expect_done(result);
    double force = 0;
    for (const Vec3& f : {result.last().bodies.force[2], result.last().bodies.force[3]}) force += f.norm();
    measured(fmt::format("{}: ends of the fiber that is only lifted hold it by {:.1e} N", model, force));
    constexpr double stiffness = 3e9 * std::numbers::pi * 1e-10;
    EXPECT_LT(force, 1e-9 * stiffness);
    EXPECT_GT(result.last().bodies.force[1].norm(), 1e-2 * stiffness);
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

// A stiff fiber that is taken far by its bodies presses a slender one deep on the way, axis on axis, before that gives
// way: it must not come out on its other side.
TEST(Travel, ThickFiberDrivenOnASlenderOneDoesNotPassThrough) {
  for (const double angle : {31, 45, 90}) {
    SCOPED_TRACE(angle);
    Scene scene = pair_scene({.model = FiberModel::rod,
                              .angle = angle * std::numbers::pi / 180,
                              .height = 5.12,
                              .length = 60,
                              .n_elements = 24});
    scene.fiber_types.push_back({"thick", 0, 3.0, FiberModel::rod});
    scene.fibers[1].type = 1;
    scene.fibers[1].n_elements = 12;
    scene.stages = {stage_with("drive", 1, {displacement("grip", BodyDof::z, -13.8)})};
    const RunResult result = run_scene(scene);
    expect_done(result);
    EXPECT_GT(node_at(result, 1, 0.5).z() - node_at(result, 0, 0.5).z(), 3.9);
  }
}

}  // namespace
}  // namespace trame::micro
