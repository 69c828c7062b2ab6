/// The scene that the tutorial shows must be one that runs.

#include <gtest/gtest.h>

#include "support/process.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"

namespace trame::test {
namespace {

TEST(Tutorial, SceneIsValid) {
  const std::string text = read_text(std::filesystem::path(TRAME_DATA_DIR) / "tutorial/README.md"),
                    fence = "```toml\n";
  const std::size_t start = text.find(fence + "title = ");  // others are parts of scenes
  ASSERT_NE(start, std::string::npos);
  const std::size_t first = start + fence.size();
  const TemporaryFolder folder;
  write_text(folder / "own.toml", text.substr(first, text.find("```", first) - first));
  const Outcome outcome = run(folder.path(), {TRAME_RUN_WORKFLOW, "own.toml", "--check"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("Strand of seven filaments"), std::string::npos) << outcome.out;
}

}  // namespace
}  // namespace trame::test
