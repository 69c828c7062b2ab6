/// \file
/// Both fiber models in one scene, and stages that turn fibers of one model into the other.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/reference_table.h"
#include "tests/support/run_scene.h"

namespace trame::micro {
namespace {

using Models = std::vector<std::optional<FiberModel>>;

constexpr auto enriched = FiberModel::enriched, rod = FiberModel::rod;

/// Two warp over two weft yarns of three fibers of radius 1: separated, relaxed, pulled by 2 % along the warp. `models`
/// of the three stages; without one, fibers are of the model of their type.
Scene small_weave(FiberModel warp, FiberModel weft, const Models& models) {
  Scene scene;
  scene.name = "weave";
  scene.materials = {test::isotropic(1, 0.39)};
  scene.fiber_types = {{"warp", 0, 1.0, warp}, {"weft", 0, 1.0, weft}};
  const YarnSystem yarns{{{.type = 0, .n_fibers = 3, .n_layers = 1, .lattice_spacing = 1.05}}, {0}, 2, 9, 14, 10};
  scene.weave = Weave{{{true, false}, {false, true}}, yarns, yarns};
  scene.weave->weft.kinds[0].type = 1;
  const auto pull = [](const char* bodies, BodyDof dof, double force) {
    return Drive{bodies, dof, DriveMode::force, force, ""};
  };
  const auto ends = [&](double force) {
    return std::vector<Drive>{pull("warp/*/start", BodyDof::x, -force), pull("warp/*/end", BodyDof::x, force),
                              pull("weft/*/start", BodyDof::y, -force), pull("weft/*/end", BodyDof::y, force)};
  };
  Stage separate, relax, load;
  separate.name = "separate";
  separate.separate_yarns = true;
  separate.friction = false;
  separate.n_increments = 8;
  separate.proximal_start = separate.proximal_end = 1e-3;
  separate.drives = ends(4e-3);
  relax.name = "relax";
  relax.n_increments = 6;
  relax.proximal_start = 1e-3;
  relax.drives = ends(4e-4);
  load.name = "load";
  load.n_increments = 10;
  load.drives = {{"warp/*", BodyDof::x, DriveMode::strain, 0.02, ""}};
  scene.stages = {separate, relax, load};
  for (std::size_t i = 0; i < models.size(); ++i) scene.stages[i].fiber_model = models[i];
  return scene;
}

/// Pull of the warp's end bodies along x at the end of the run.
double warp_force(const test::RunResult& result) {
  double force = 0;
  for (std::size_t b = 0; b < result.header.body_names.size(); ++b) {
    const std::string& name = result.header.body_names[b];
    if (name.starts_with("warp/") && name.ends_with("/end")) force += result.last().bodies.force[b].x();
  }
  return force;
}

void expect_woven(const test::RunResult& result) {
  ASSERT_TRUE(result.done()) << result.summary.message;
  EXPECT_TRUE(result.summary.crossing_order_ok)
      << result.summary.n_crossings_ok << " of " << result.summary.n_crossings;
  EXPECT_LT(result.summary.max_penetration_over_radius, 0.1);
  EXPECT_LT(result.summary.force_imbalance, SolverSettings{}.geometry_tolerance);
}

TEST(FiberModels, WarpOfRodsAndWeftOfBeamsWeaveAndPull) {
  const auto beams = test::run_scene(small_weave(enriched, enriched, {rod, rod, {}}));
  const auto rods = test::run_scene(small_weave(rod, rod, {}));
  const auto mixed = test::run_scene(small_weave(rod, enriched, {}));
  for (const auto* result : {&beams, &rods, &mixed}) expect_woven(*result);
  // Nothing is converted in these two, so the balance is that of steps and detections.
  for (const auto* result : {&rods, &mixed})
    EXPECT_LT(std::abs(result->summary.energy.imbalance), 0.1 * result->summary.energy.external_work);
  const Index n_rod = 6 * (9 + 1), n_enriched = 9 * (2 * 9 + 1), n_fibers = 6, n_bodies = 4 + 4 + 4;
  EXPECT_EQ(beams.summary.size.n_dofs_per_stage.at(0), 2 * n_fibers * n_rod + 6 * n_bodies);
  EXPECT_EQ(beams.summary.size.n_dofs_per_stage.at(2), 2 * n_fibers * n_enriched + 6 * n_bodies);
  for (const auto n : mixed.summary.size.n_dofs_per_stage) EXPECT_EQ(n, n_fibers * (n_rod + n_enriched) + 6 * n_bodies);
  fmt::print("warp force at 2 %: enriched {:.5f}, rods {:.5f}, mixed {:.5f} E R²\n", warp_force(beams),
             warp_force(rods), warp_force(mixed));
  // Six fibers of EA = π stretched by 2 % less what crimp gives: no model may change the sum by more than sections that
  // give way do.
  const double straight = 6 * std::numbers::pi * 0.02;
  for (const auto* result : {&beams, &rods, &mixed}) {
    EXPECT_GT(warp_force(*result), 0.3 * straight);
    EXPECT_LT(warp_force(*result), 1.05 * straight);
    EXPECT_NEAR(warp_force(*result) / warp_force(beams), 1, 0.15);
  }
}

TEST(FiberModels, AWeaveSurvivesTheChangeThereAndBack) {
  Scene scene = small_weave(enriched, enriched, {rod, rod, rod});
  Stage settle = scene.stages[1];
  settle.name = "settle";
  settle.proximal_start = 0;
  settle.n_increments = 2;
  settle.fiber_model = enriched;
  Stage back = settle;
  back.name = "back";
  back.fiber_model = rod;
  scene.stages.insert(scene.stages.begin() + 2, {settle, back});
  const auto direct = test::run_scene(small_weave(rod, rod, {})), there_and_back = test::run_scene(scene);
  expect_woven(direct);
  expect_woven(there_and_back);
  fmt::print("warp force at 2 %: {:.5f} directly, {:.5f} there and back\n", warp_force(direct),
             warp_force(there_and_back));
  EXPECT_NEAR(warp_force(there_and_back) / warp_force(direct), 1, 0.05);
  // Sections that beams let be squeezed are round again in rods: that comes in as work where the model changes, and is
  // released in the first increment, which goes there in one step. Nothing else is.
  const EnergyRecord &direct_energy = direct.summary.energy, &energy = there_and_back.summary.energy;
  const double conversion = energy.external_work - direct_energy.external_work;
  EXPECT_GT(conversion, 0);
  EXPECT_LT(conversion, 0.1 * direct_energy.external_work);
  EXPECT_NEAR(energy.release - direct_energy.release, conversion, 0.1 * conversion);
  EXPECT_NEAR(energy.imbalance, direct_energy.imbalance, 0.1 * conversion);
}

TEST(FiberModels, ABentCantileverStaysWhereItIsThroughChangesOfModel) {
  // The elastica knows nothing of models: each must hold the shape that the other found, with the same load, to what
  // EndForce in elastica_test.cpp allows them.
  constexpr double length = 400, tolerance = 5e-5;
  for (const auto& row : trame::test::reference_table("elastica_end_force")) {
    Scene scene = test::cantilever(rod, 0.39, length, 40);
    const double force = row[0] * 0.25 * std::numbers::pi / (length * length);
    for (const auto model : {rod, enriched, rod}) {
      Stage stage;
      stage.name = fmt::format("{}", scene.stages.size());
      stage.n_increments = scene.stages.empty() ? 10 : 1;
      stage.fiber_model = model;
      stage.drives = {{"tip", BodyDof::x, DriveMode::force, 0, ""},
                      {"tip", BodyDof::z, DriveMode::force, force, ""},
                      {"tip", BodyDof::ry, DriveMode::force, 0, ""}};
      scene.stages.push_back(stage);
    }
    const auto result = test::run_scene(scene);
    ASSERT_TRUE(result.done()) << result.summary.message;
    double work = 0;
    for (const Increment& increment : result.increments) {
      if (increment.stage_time < 1) continue;
      const Vec3 tip = increment.fibers.r[result.last_node(0)];
      EXPECT_NEAR(tip.z() / length, row[1], tolerance) << "P = " << row[0] << ", stage " << increment.stage;
      EXPECT_NEAR(1 - tip.x() / length, row[2], tolerance) << "P = " << row[0] << ", stage " << increment.stage;
      if (work > 0) {
        EXPECT_NEAR(increment.solver.energy.external_work, work, 1e-3 * work)
            << "P = " << row[0] << ", stage " << increment.stage;
      }
      work = increment.solver.energy.external_work;
    }
    EXPECT_GT(work, 0);
  }
}

}  // namespace
}  // namespace trame::micro
