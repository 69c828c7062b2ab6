/// Drives that follow a table, and drives along or about any direction: reading, and what runs make of them.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <numbers>

#include "tests/support/messages.h"
#include "tests/support/run_scene.h"
#include "tests/support/tied_rod.h"

namespace trame::micro {
namespace {

using trame::test::expect_mentions;
using trame::test::input_error;

TEST(Amplitude, IsARampWithoutPointsAndStraightBetweenThem) {
  EXPECT_EQ(Amplitude().at(0.3), 0.3);
  const Amplitude cycle{{{0.25, 1}, {0.75, -1}, {1, 0}}};
  EXPECT_DOUBLE_EQ(cycle.at(0), 0);
  EXPECT_DOUBLE_EQ(cycle.at(0.125), 0.5);
  EXPECT_DOUBLE_EQ(cycle.at(0.25), 1);
  EXPECT_DOUBLE_EQ(cycle.at(0.5), 0);
  EXPECT_DOUBLE_EQ(cycle.at(0.875), -0.5);
  EXPECT_DOUBLE_EQ(cycle.at(1), 0);
}

std::string scene_with(const std::string& drive, int increments = 4) {
  return trame::test::tied_rod(4) + fmt::format(R"([[stage]]
name = "pull"
increments = {}
[[stage.drive]]
bodies = "right"
{}
)",
                                         increments, drive);
}

Scene scene_of(const std::string& drive, int increments = 4) {
  return parse_scene(scene_with(drive, increments), "s.toml");
}

TEST(Amplitude, IsReadFromTheScene) {
  const Scene scene = scene_of("dof = \"x\"\ndisplacement = \"10 um\"\namplitude = [[0, 0], [0.25, 1], [1, -0.5]]");
  EXPECT_EQ(scene.stages[0].drives.at(0).amplitude, (Amplitude{{{0.25, 1}, {1, -0.5}}}));
  EXPECT_TRUE(scene_of("dof = \"x\"\ndisplacement = \"10 um\"").stages[0].drives[0].amplitude.points.empty());
}

TEST(Amplitude, ThatIsNoneIsRefusedWithItsPlace) {
  const auto error = [](const std::string& table, const std::string& what = "dof = \"x\"\ndisplacement = \"10 um\"") {
    return input_error([&] { (void)scene_of(what + "\namplitude = " + table); });
  };
  expect_mentions(error("[[0.5, 1]]"), {"s.toml", "amplitude", "must end at stage time 1"});
  expect_mentions(error("[[0, 0.5], [1, 1]]"), {"amplitude", "0.5", "must be 0 at stage time 0"});
  expect_mentions(error("[[0.1, 1], [1, 0]]"), {"0.1", "at least an increment, 0.25", "4 increments"});
  expect_mentions(error("[[0.5, 1], [0.5, 0], [1, 1]]"), {"at least an increment"});
  expect_mentions(error("[[0.5, 1], [2, 0]]"), {"2", "at most 1"});
  expect_mentions(error("[[0.5], [1, 0]]"), {"must be a stage time and a share"});
  expect_mentions(error("[[0.5, 1e9], [1, 0]]"), {"1000"});
  expect_mentions(error("1"), {"list of [stage time, share]"});
  expect_mentions(error("[[1, 1]]", "dof = \"x\"\nfollow = \"left\""), {"follows a body"});
}

TEST(Direction, ExpandsIntoDofs) {
  const Scene along = scene_of("along = [3, 0, -4]\ndisplacement = \"10 um\"");
  ASSERT_EQ(along.stages[0].drives.size(), 3U);
  EXPECT_NEAR(along.stages[0].drives[0].value, 6e-6, 1e-18);
  EXPECT_EQ(along.stages[0].drives[1].value, 0);
  EXPECT_NEAR(along.stages[0].drives[2].value, -8e-6, 1e-18);
  const Scene about = scene_of("about = [0, 2, 0]\nforce = \"2 nN m\"");
  EXPECT_EQ(about.stages[0].drives[1].dof, BodyDof::ry);
  EXPECT_EQ(about.stages[0].drives[1].mode, DriveMode::force);
  EXPECT_NEAR(about.stages[0].drives[1].value, 2e-9, 1e-20);
}

TEST(Direction, ThatIsNoneIsRefusedWithItsPlace) {
  const auto error = [](const std::string& drive) { return input_error([&] { (void)scene_of(drive); }); };
  expect_mentions(error("along = [0, 0, 0]\ndisplacement = \"1 um\""), {"along", "must not be zero"});
  expect_mentions(error("along = [1, 0, 0]\nstrain = 0.1"), {"along", "strain, force_per_width and follow must have a dof"});
  expect_mentions(error("displacement = \"1 um\""), {"exactly one of \"dof\", \"along\" and \"about\""});
  expect_mentions(error("dof = \"x\"\nabout = [1, 0, 0]\ndisplacement = \"1 um\""), {"exactly one of"});
  expect_mentions(error("about = [1, 0, 0]\ndisplacement = \"1 um\""), {"displacement", "an angle"});
  expect_mentions(error("along = [1, 0, 0]\ndisplacement = \"1e9 km\""), {"displacement"});
}

/// Stage times, and motion and reaction of a dof of body 1, of all increments.
struct Path {
  std::vector<double> time, motion, reaction;
};
Path path_of(const SimulationSummary& summary, BodyDof dof) {
  Path path;
  for (const CurvePoint& point : summary.curve) {
    path.time.push_back(point.stage_time);
    path.motion.push_back(point.motion[6 + static_cast<int>(dof)]);
    path.reaction.push_back(point.reaction[6 + static_cast<int>(dof)]);
  }
  return path;
}

TEST(Amplitude, IncrementsEndWhereADriveTurns) {
  const auto result = test::run_scene(
      scene_of("dof = \"x\"\ndisplacement = \"10 um\"\namplitude = [[0.4, 1], [0.9, -0.5], [1, 0]]", 10));
  ASSERT_TRUE(result.done()) << result.summary.message;
  const Path path = path_of(result.summary, BodyDof::x);
  ASSERT_EQ(path.time.size(), 10U) << "turns at tenths need no further increments";
  EXPECT_NEAR(path.motion[3], 10e-6, 1e-15);
  EXPECT_NEAR(path.motion[8], -5e-6, 1e-15);
  EXPECT_NEAR(path.motion[9], 0, 1e-15);
  EXPECT_NEAR(path.reaction[9], 0, 1e-9 * path.reaction[3]);
}

TEST(Amplitude, TurnsBetweenIncrementsCutThem) {
  const auto result =
      test::run_scene(scene_of("dof = \"x\"\ndisplacement = \"10 um\"\namplitude = [[0.6, 1], [1, 0]]", 4));
  ASSERT_TRUE(result.done()) << result.summary.message;
  const Path path = path_of(result.summary, BodyDof::x);
  std::size_t turn = 0;
  while (turn < path.time.size() && std::abs(path.time[turn] - 0.6) > 1e-12) ++turn;
  ASSERT_LT(turn, path.time.size()) << "an increment ends at 0.6";
  EXPECT_NEAR(path.motion[turn], 10e-6, 1e-15);
  EXPECT_NEAR(path.motion.back(), 0, 1e-15);
  EXPECT_LE(path.time.size(), 7U);
}

TEST(Amplitude, OfAForceAndOfARotation) {
  const auto force = test::run_scene(scene_of("dof = \"x\"\nforce = \"2 mN\"\namplitude = [[0.5, 1], [1, 0.25]]", 4));
  ASSERT_TRUE(force.done());
  const Path pull = path_of(force.summary, BodyDof::x);
  EXPECT_NEAR(pull.reaction[0], 1e-3, 1e-9);
  EXPECT_NEAR(pull.reaction[1], 2e-3, 1e-9);
  EXPECT_NEAR(pull.reaction[3], 0.5e-3, 1e-9);
  EXPECT_GT(pull.motion[1], 3 * pull.motion[3]);
  const auto turned =
      test::run_scene(scene_of("about = [1, 0, 0]\ndisplacement = \"1 rad\"\namplitude = [[0.5, 4], [1, 3]]", 8));
  ASSERT_TRUE(turned.done());
  const Path turn = path_of(turned.summary, BodyDof::rx);
  EXPECT_NEAR(turn.motion[3], 4, 1e-9) << "more than half a turn";
  EXPECT_NEAR(turn.motion.back(), 3, 1e-9);
}

TEST(Direction, MovesABodyAlongIt) {
  const auto result = test::run_scene(scene_of("along = [1, 1, 0]\ndisplacement = \"10 um\"", 2));
  ASSERT_TRUE(result.done());
  for (const BodyDof dof : {BodyDof::x, BodyDof::y})
    EXPECT_NEAR(path_of(result.summary, dof).motion.back(), 10e-6 / std::numbers::sqrt2, 1e-15);
  EXPECT_EQ(path_of(result.summary, BodyDof::z).motion.back(), 0);
}

TEST(Amplitude, RunsThatGoOnMeetTheSameTurns) {
  const Scene scene = scene_of("dof = \"x\"\ndisplacement = \"10 um\"\namplitude = [[0.6, 1], [1, 0]]", 4);
  const trame::test::TemporaryFolder folder;
  const auto run = [&](const std::string& states, Index last, bool resume) {
    std::atomic<bool> stop = false;
    SimulateOptions options;
    options.states = folder / states;
    options.n_threads = 1;
    options.resume = resume;
    options.stop = &stop;
    options.on_increment = [&](const Progress& progress) { stop = progress.increment == last; };
    return simulate(scene, options);
  };
  const SimulationSummary whole = run("whole.h5", 0, false);
  for (const Index last : {1, 2, 3}) {
    const std::string states = fmt::format("{}.h5", last);
    ASSERT_EQ(run(states, last, false).status, SimulationSummary::Status::interrupted);
    const SimulationSummary parts = run(states, 0, true);
    EXPECT_EQ(path_of(parts, BodyDof::x).time, path_of(whole, BodyDof::x).time) << last;
    EXPECT_EQ(path_of(parts, BodyDof::x).motion, path_of(whole, BodyDof::x).motion) << last;
    EXPECT_EQ(path_of(parts, BodyDof::x).reaction, path_of(whole, BodyDof::x).reaction) << last;
    EXPECT_EQ(parts.stage_starts.size(), 1U);
  }
}

}  // namespace
}  // namespace trame::micro
