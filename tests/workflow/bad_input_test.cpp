/// What users get wrong on the command line: exit code 2, a message that helps, and no results.

#include <gtest/gtest.h>

#include "support/process.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"

namespace trame::test {
namespace {

class BadInput : public testing::TestWithParam<const char*> {
 protected:
  Outcome run_program(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), GetParam());
    return run(folder_.path(), arguments);
  }
  void expect_refused(const std::vector<std::string>& arguments, const std::vector<std::string>& fragments) const {
    const Outcome outcome = run_program(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
    for (const std::string& fragment : fragments)
      EXPECT_NE(outcome.err.find(fragment), std::string::npos) << fragment << "\nin: " << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "results"));
  }

  TemporaryFolder folder_;
};

TEST_P(BadInput, MissingScene) {
  expect_refused({}, {"SCENE"});
  expect_refused({"no_such_scene"}, {"no_such_scene", "plain_small", "twill_small"});
  expect_refused({"./no_such_scene.toml"}, {"./no_such_scene.toml"});
}

TEST_P(BadInput, BrokenScene) {
  write_text(folder_ / "broken.toml", "title = \"open\n");
  expect_refused({"broken.toml"}, {"broken.toml"});
  write_text(folder_ / "typo.toml", "titel = \"a scene\"\n");
  expect_refused({"typo.toml"}, {"typo.toml", "titel"});
  write_text(folder_ / "empty.toml", "");
  expect_refused({"empty.toml"}, {"empty.toml"});
}

TEST_P(BadInput, UnknownOptionOrValue) {
  expect_refused({"plain_small", "--overwrit"}, {"--overwrit"});
  expect_refused({"plain_small", "--threads", "none"}, {"--threads"});
  expect_refused({"plain_small", "--alpha", "inf"}, {"--alpha"});
}

TEST_P(BadInput, ExistingOutput) {
  std::filesystem::create_directory(folder_ / "old");
  write_text(folder_ / "old/states.h5", "precious");
  expect_refused({"plain_small", "--out", "old"}, {"--out old", "--overwrite"});
  EXPECT_EQ(read_text(folder_ / "old/states.h5"), "precious");
}

TEST_P(BadInput, OutputThatCannotBeWritten) {
  write_text(folder_ / "file", "mine");
  expect_refused({"plain_small", "--out", "file"}, {"--out file"});
  expect_refused({"plain_small", "--out", "file/below"}, {"--out file/below"});
  expect_refused({"plain_small", "--out", "/proc/results"}, {"--out /proc/results"});
}

TEST_P(BadInput, DataFolderWithoutScenes) {
  const Outcome outcome = run(folder_.path(), {GetParam(), "plain_small"}, {"TRAME_DATA=" + folder_.path().string()});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find(folder_.path().string()), std::string::npos) << outcome.err;
}

INSTANTIATE_TEST_SUITE_P(Programs, BadInput, testing::Values(TRAME_RUN_WORKFLOW, TRAME_SIMULATE_FIBERS),
                         [](const auto& info) { return std::filesystem::path(info.param).filename().string(); });

}  // namespace
}  // namespace trame::test
