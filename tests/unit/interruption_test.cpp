// Runs that end before their last increment, and what they leave.

#include <gtest/gtest.h>

#include <atomic>

#include "tests/support/run_scene.h"

namespace trame::micro {
namespace {

using Status = SimulationSummary::Status;

/// A cantilever that is bent far, in increments of several iterations, of which only each fourth is saved.
Scene bent_cantilever() {
  Scene scene = test::cantilever(FiberModel::rod, 0, 100, 8);
  Stage stage;
  stage.name = "bend";
  stage.n_increments = 10;
  stage.save_every = 4;
  stage.drives = {{"tip", BodyDof::z, DriveMode::displacement, 50, ""}};
  scene.stages = {stage};
  return scene;
}

struct Ended {
  SimulationSummary summary;
  int n_iterations_after = 0;  ///< begun after the stop was asked for
};

/// Asks for the stop at an iteration of the increment after `n_accepted` ones.
Ended stop_within_increment(const std::filesystem::path& states, Index n_accepted) {
  std::atomic<bool> stop = false;
  Index accepted = 0;
  Ended ended;
  SimulateOptions options;
  options.states = states;
  options.n_threads = 1;
  options.stop = &stop;
  options.on_increment = [&](const Progress& progress) { accepted = progress.increment; };
  options.log = [&](const std::string& line) {
    if (line.find("  iteration ") == std::string::npos) return;
    ended.n_iterations_after += stop ? 1 : 0;
    stop = stop || (accepted == n_accepted && line.find("iteration  1") != std::string::npos);
  };
  ended.summary = simulate(bent_cantilever(), options);
  return ended;
}

TEST(Stop, IsObeyedWithinAnIncrementAndSavesTheLastAccepted) {
  const trame::test::TemporaryFolder folder;
  const Ended ended = stop_within_increment(folder / "states.h5", 2);
  EXPECT_EQ(ended.summary.status, Status::interrupted);
  EXPECT_EQ(ended.n_iterations_after, 0);
  EXPECT_EQ(ended.summary.n_increments, 2);
  const SnapshotReader states(folder / "states.h5");
  ASSERT_EQ(states.n_increments(), 2) << "the start, and the second increment though it is not a fourth one";
  EXPECT_NEAR(states.read(1).stage_time, 0.2, 1e-12);

  SimulateOptions whole;
  whole.states = folder / "whole.h5";
  whole.n_threads = 1;
  Scene scene = bent_cantilever();
  scene.stages[0].save_every = 1;
  (void)simulate(scene, whole);
  EXPECT_EQ(states.read(1).fibers.r, SnapshotReader(whole.states).read(2).fibers.r) << "bit by bit";
}

TEST(Stop, InTheFirstIncrementLeavesTheStart) {
  const trame::test::TemporaryFolder folder;
  const Ended ended = stop_within_increment(folder / "states.h5", 0);
  EXPECT_EQ(ended.summary.status, Status::interrupted);
  EXPECT_EQ(ended.summary.n_increments, 0);
  EXPECT_EQ(SnapshotReader(folder / "states.h5").n_increments(), 1);
}

TEST(StatesThatCannotBeWritten, EndTheRunWithAllThatItKnows) {
  const trame::test::TemporaryFolder folder;
  SimulateOptions options;
  options.states = folder / "states.h5";
  options.n_threads = 1;
  options.on_increment = [&](const Progress& progress) {
    if (progress.increment == 5) std::filesystem::remove(options.states);
  };
  const SimulationSummary summary = simulate(bent_cantilever(), options);
  EXPECT_EQ(summary.status, Status::cannot_write);
  EXPECT_EQ(summary.n_increments, 8) << "of which the eighth was to be saved";
  EXPECT_NE(summary.message.find("states.h5: was removed or replaced"), std::string::npos) << summary.message;
  EXPECT_EQ(summary.message.find("--resume"), std::string::npos) << "there is nothing to go on from";
}

}  // namespace
}  // namespace trame::micro
