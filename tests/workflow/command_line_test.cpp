#include "workflows/program/command_line.h"

#include <gtest/gtest.h>

#include <cmath>

#include "micro/core/error.h"
#include "support/messages.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"
#include "workflows/load_ratio.h"

namespace trame::workflows {
namespace {

using namespace micro;
using test::TemporaryFolder;
using trame::test::expect_mentions;
using trame::test::input_error;

std::optional<Options> parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "run_workflow");
  return parse_command_line(static_cast<int>(arguments.size()), arguments.data(), "");
}

TEST(CommandLine, HasDefaultsForAllButTheScene) {
  const auto options = parse({"plain"});
  ASSERT_TRUE(options);
  EXPECT_EQ(options->scene, "plain");
  EXPECT_FALSE(options->out || options->alpha || options->overwrite || options->check || options->verbose);
  EXPECT_EQ(options->n_threads, 0);
}

TEST(CommandLine, ReadsEveryOption) {
  const auto options =
      parse({"a.toml", "--out", "dir", "--overwrite", "--check", "-v", "--threads", "3", "--alpha", "-0.5"});
  ASSERT_TRUE(options);
  EXPECT_EQ(options->out, std::filesystem::path("dir"));
  EXPECT_TRUE(options->overwrite && options->check && options->verbose && !options->print_schema);
  EXPECT_EQ(options->n_threads, 3);
  EXPECT_EQ(options->alpha, -0.5);
}

TEST(CommandLine, NeedsNoSceneForTheSchema) {
  const auto options = parse({"--print-schema"});
  EXPECT_TRUE(options && options->print_schema);
}

TEST(CommandLine, NamesTheOptionThatIsWrong) {
  expect_mentions(input_error([] { (void)parse({}); }), {"SCENE"});
  expect_mentions(input_error([] { (void)parse({"plain", "--thread", "2"}); }), {"--thread"});
  expect_mentions(input_error([] { (void)parse({"plain", "--threads", "0"}); }), {"--threads", "1 to 1024", "0"});
  expect_mentions(input_error([] { (void)parse({"plain", "--alpha", "much"}); }), {"--alpha", "much"});
  expect_mentions(input_error([] { (void)parse({"plain", "twill"}); }), {"twill"});
}

TEST(FindScene, TakesNamesFromTheDataFolderAndPathsAsTheyAre) {
  const TemporaryFolder data;
  std::filesystem::create_directory(data / "scenes");
  test::write_text(data / "scenes/plain.toml", "");
  test::write_text(data / "own", "");
  EXPECT_EQ(find_scene("plain", data.path()), data / "scenes/plain.toml");
  EXPECT_EQ(find_scene((data / "own").string(), data.path()), data / "own");
}

TEST(FindScene, ListsTheScenesThereAreWhereOneIsMissing) {
  const TemporaryFolder data;
  std::filesystem::create_directory(data / "scenes");
  for (const char* name : {"scenes/twill.toml", "scenes/plain.toml", "scenes/notes.txt"})
    test::write_text(data / name, "");
  expect_mentions(input_error([&] { (void)find_scene("plian", data.path()); }), {"plian", ": plain, twill"});
  expect_mentions(input_error([&] { (void)find_scene("./plain.toml", data.path()); }),
                  {"./plain.toml", ": plain, twill"});
  expect_mentions(input_error([&] { (void)find_scene(data.path().string(), data.path()); }), {"must be a file"});
}

TEST(DefaultOutput, KeepsRatiosApart) {
  EXPECT_EQ(default_output("plain", {}), "results/plain");
  EXPECT_EQ(default_output("plain", 1.0), "results/plain_alpha_1");
  EXPECT_EQ(default_output("plain", 0.5), "results/plain_alpha_0.5");
}

Scene biaxial_scene() {
  const auto drive = [](const char* bodies, BodyDof dof, DriveMode mode, double value) {
    Drive made;
    made.bodies = bodies;
    made.dof = dof;
    made.mode = mode;
    made.value = value;
    return made;
  };
  Scene scene;
  scene.name = "plain";
  scene.stages.resize(2);
  scene.stages[0].drives = {drive("side/weft/*", BodyDof::y, DriveMode::strain, 0.3)};
  scene.stages[1].name = "load";
  scene.stages[1].drives = {
      drive("side/warp/*", BodyDof::x, DriveMode::strain, 0.02), drive("weft/*", BodyDof::x, DriveMode::strain, 0.02),
      drive("side/weft/*", BodyDof::y, DriveMode::strain, 0), drive("warp/*", BodyDof::y, DriveMode::strain, 0),
      drive("warp/*", BodyDof::y, DriveMode::force, 7)};
  return scene;
}

TEST(WeftRatio, ScalesTheWeftStrainsOfTheLastStageOnly) {
  const Scene scene = with_weft_ratio(biaxial_scene(), 0.5);
  EXPECT_EQ(scene.stages[0].drives[0].value, 0.3);
  const std::vector<Drive>& drives = scene.stages[1].drives;
  EXPECT_EQ(drives[0].value, 0.02);
  EXPECT_EQ(drives[1].value, 0.02);
  EXPECT_EQ(drives[2].value, 0.01);
  EXPECT_EQ(drives[3].value, 0.01);
  EXPECT_EQ(drives[4].value, 7);
}

TEST(WeftRatio, IsAnErrorWhereTheLastStageIsNotBiaxial) {
  Scene scene = biaxial_scene();
  scene.stages[1].drives.resize(2);
  expect_mentions(input_error([&] { (void)with_weft_ratio(scene, 1); }), {"--alpha 1", "plain", "load", "x and y"});
  scene.stages.clear();
  expect_mentions(input_error([&] { (void)with_weft_ratio(scene, 1); }), {"no stages"});
}

TEST(WeftRatio, IsAnErrorWhereWarpStrainsDiffer) {
  Scene scene = biaxial_scene();
  scene.stages[1].drives[1].value = 0.01;
  expect_mentions(input_error([&] { (void)with_weft_ratio(scene, 1); }), {"0.02", "0.01", "must be equal"});
}

TEST(WeftRatio, MustBeFinite) {
  for (const double alpha : {NAN, INFINITY})
    expect_mentions(input_error([&] { (void)with_weft_ratio(biaxial_scene(), alpha); }), {"--alpha", "finite"});
}

}  // namespace
}  // namespace trame::workflows
