/// The scene that README.md shows must be one that runs.

#include <gtest/gtest.h>

#include "support/process.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"

namespace trame::test {
namespace {

TEST(Readme, SceneIsValid) {
  const std::string readme = read_text(std::filesystem::path(TRAME_DATA_DIR).parent_path() / "README.md"),
                    fence = "```toml\n";
  const std::size_t start = readme.find(fence);
  ASSERT_NE(start, std::string::npos);
  const std::size_t first = start + fence.size();
  const TemporaryFolder folder;
  write_text(folder / "own.toml", readme.substr(first, readme.find("```", first) - first));
  const Outcome outcome = run(folder.path(), {TRAME_RUN_WORKFLOW, "own.toml", "--check"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("Strand of seven filaments"), std::string::npos) << outcome.out;
}

}  // namespace
}  // namespace trame::test
