#include "workflows/program/terminal.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>

#include "workflows/program/environment.h"
#include "workflows/scene_overview.h"

namespace trame::workflows {
namespace {

TEST(Durations, AreWrittenInTheUnitsPeopleUse) {
  EXPECT_EQ(duration_text(0), "0 ms");
  EXPECT_EQ(duration_text(0.0614), "61 ms");
  EXPECT_EQ(duration_text(0.9999), "1.0 s");
  EXPECT_EQ(duration_text(12.34), "12.3 s");
  EXPECT_EQ(duration_text(59.97), "1 min 00 s");
  EXPECT_EQ(duration_text(245), "4 min 05 s");
  EXPECT_EQ(duration_text(3599.6), "1 h 00 min");
  EXPECT_EQ(duration_text(7800), "2 h 10 min");
}

TEST(Bytes, AreWrittenWithTwoDigitsOrMore) {
  EXPECT_EQ(bytes_text(0), "0 B");
  EXPECT_EQ(bytes_text(999), "999 B");
  EXPECT_EQ(bytes_text(512e3), "512 kB");
  EXPECT_EQ(bytes_text(999.9e6), "1.0 GB");
  EXPECT_EQ(bytes_text(1.34e9), "1.3 GB");
}

TEST(ProgressText, ExtrapolatesTheTimeThatIsLeft) {
  micro::SolverRecord solver;
  solver.n_newton_iterations = 9;
  solver.max_penetration_over_radius = 0.0213;
  micro::Progress progress;
  progress.stage = "relax";
  progress.stage_index = 1;
  progress.n_stages = 4;
  progress.fraction = 0.25;
  progress.increment = 17;
  progress.solver = &solver;
  progress.n_contact_elements = 3050;
  EXPECT_EQ(progress_text(progress, 60),
            " 25 %  relax (2/4)  increment 17  1 min 00 s, about 3 min 00 s left  3050 contacts, 9 iterations, "
            "penetration 0.021 R");
  progress.begun_at = 0.2;  // a run that was gone on with
  EXPECT_NE(progress_text(progress, 60).find("about 15 min 00 s left"), std::string::npos);
}

TEST(ProgressText, GuessesNoTimeAtTheStartAndAtTheEnd) {
  micro::Progress progress;
  progress.stage = "load";
  progress.n_stages = 1;
  EXPECT_EQ(progress_text(progress, 2).find("left"), std::string::npos);
  progress.fraction = 1;
  EXPECT_EQ(progress_text(progress, 2).find("left"), std::string::npos);
}

TEST(StopOnSignals, AsksFirstAndEndsAtTheSecondTime) {
  const auto interrupt_twice = [] {
    watch_signals();
    const std::atomic<bool>& stop = stop_on_signals();
    if (stop) std::exit(1);
    kill(getpid(), SIGINT);
    stop.wait(false);
    kill(getpid(), SIGINT);
    sleep(10);
    std::exit(2);
  };
  EXPECT_EXIT(interrupt_twice(), testing::KilledBySignal(SIGINT), "Stopping after this iteration");
}

TEST(StopOnSignals, NothingElseEndsAtTheFirstTime) {
  const auto interrupt = [] {
    watch_signals();
    kill(getpid(), SIGINT);
    sleep(10);
    std::_Exit(1);
  };
  EXPECT_EXIT(interrupt(), testing::KilledBySignal(SIGINT), "^$");
}

TEST(StopOnSignals, AreNotLostWhereALibraryHandlesThemMeanwhile) {
  const auto handle_meanwhile = [] {
    watch_signals();
    const std::atomic<bool>& stop = stop_on_signals();
    std::signal(SIGTERM, [](int) { std::_Exit(1); });  // as METIS does
    kill(getpid(), SIGTERM);
    stop.wait(false);
    std::_Exit(stop ? 0 : 2);
  };
  EXPECT_EXIT(handle_meanwhile(), testing::ExitedWithCode(0), "Stopping after this iteration");
}

TEST(BlasKernel, FollowsTheInstructionSets) {
  EXPECT_EQ(fitting_blas_kernel(true, true), "SKYLAKEX");
  EXPECT_EQ(fitting_blas_kernel(false, true), "HASWELL");
  EXPECT_EQ(fitting_blas_kernel(false, false), "");
}

bool calls(const micro::Scene& scene, const std::string& effect, const std::string& key) {
  for (const CalledEffect& called : called_effects(scene))
    if (called.effect.find(effect) != std::string::npos && called.key.find(key) != std::string::npos) return true;
  return false;
}

TEST(CalledEffects, NameTheKeyThatCallsForThem) {
  micro::Scene scene;
  scene.fiber_types.resize(1);
  scene.fiber_types[0].name = "PA66";
  scene.bundles.resize(1);
  scene.stages.resize(2);
  scene.stages[0].name = "separate";
  scene.stages[0].separate_yarns = true;
  scene.stages[0].proximal_start = 1e-3;
  scene.stages[0].fiber_model = micro::FiberModel::rod;
  EXPECT_TRUE(calls(scene, "enriched", "fiber_type.PA66.model"));
  EXPECT_TRUE(calls(scene, "rods", "fiber_model = \"rod\" of stage \"separate\""));
  scene.stages[1].fiber_model = micro::FiberModel::rod;  // now no stage leaves the type its own model
  EXPECT_FALSE(calls(scene, "enriched", ""));
  EXPECT_TRUE(calls(scene, "crossing order", "separate_yarns"));
  EXPECT_TRUE(calls(scene, "damping", "proximal_start"));
  EXPECT_TRUE(calls(scene, "contact of all fibers", "effects.contact = \"all\""));
  EXPECT_TRUE(calls(scene, "friction", "effects.friction = true (default)"));
  scene.stated_effects = {"friction"};
  EXPECT_FALSE(calls(scene, "friction", "default"));
  scene.stages[0].friction = scene.stages[1].friction = false;
  EXPECT_FALSE(calls(scene, "friction", ""));
  EXPECT_FALSE(calls(scene, "itself", ""));
  EXPECT_FALSE(calls(scene, "twist", ""));
}

TEST(CalledEffects, AreNoneOfContactWhereThereIsNoContact) {
  micro::Scene scene;
  scene.contact.scope = micro::ContactScope::none;
  EXPECT_TRUE(called_effects(scene).empty());
}

TEST(CalledEffects, OfFiberTypesThatNoFiberHasAreNone) {
  micro::Scene scene;
  scene.fiber_types.resize(2);
  scene.fiber_types[0].name = "used";
  scene.fiber_types[1].name = "idle";
  scene.bundles.resize(1);
  EXPECT_TRUE(calls(scene, "enriched", "fiber_type.used"));
  EXPECT_FALSE(calls(scene, "", "fiber_type.idle"));
}

TEST(SceneOverview, TellsWhatEachEffectCosts) {
  micro::Scene scene;
  scene.fiber_types.resize(1);
  scene.fiber_types[0].name = "PA66";
  scene.bundles.resize(1);
  scene.stated_effects = {"contact"};
  micro::CostEstimate cost;
  cost.effects = {{micro::PricedEffect::enriched_beams, 7290, 12.3, 4e7}, {micro::PricedEffect::contact, 0, 2.5, 8e6}};
  cost.seconds = 12'300;
  cost.bytes = 1.2e9;
  const std::string text = scene_overview(scene, {}, cost);
  for (const char* part : {"7290    40 MB       12.3 s  fiber_type.PA66.model = \"enriched\"", "order of magnitude",
                           "0   8.0 MB        2.5 s  effects.contact = \"all\"\n", "1.2 GB   3 h 25 min\n"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\nin: " << text;
}

TEST(SceneOverview, TellsStagesWithTheirDrives) {
  micro::Scene scene;
  scene.stages.resize(1);
  scene.stages[0].name = "load";
  scene.stages[0].n_increments = 20;
  micro::Drive strain, follow, moment;
  strain.bodies = "side/warp/*";
  strain.mode = micro::DriveMode::strain;
  strain.value = 0.02;
  follow.bodies = "warp/*/end";
  follow.mode = micro::DriveMode::follow;
  follow.leader = "side/warp/end";
  moment.bodies = "tip";
  moment.dof = micro::BodyDof::rz;
  moment.mode = micro::DriveMode::force;
  moment.value = 0.001;
  scene.stages[0].drives = {strain, follow, moment};
  micro::ModelSize size;
  size.n_dofs_per_stage = {7290};
  const std::string text = scene_overview(scene, size, {});
  for (const char* line : {"load: 20 increments, 7290 dofs", "side/warp/* x to strain 0.02",
                           "warp/*/end x follows side/warp/end", "tip rz to moment 0.001 N m"})
    EXPECT_NE(text.find(line), std::string::npos) << line << "\nin: " << text;
}

}  // namespace
}  // namespace trame::workflows
