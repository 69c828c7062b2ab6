// What a new user gets from `bootstrap SCENE`.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>

#include "support/process.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"

namespace trame::test {
namespace {

namespace fs = std::filesystem;

const fs::path source = fs::path(TRAME_DATA_DIR).parent_path();

void write_program(const fs::path& file, const std::string& body) {
  fs::create_directories(file.parent_path());
  write_text(file, "#!/bin/sh\n" + body + "\n");
  fs::permissions(file, fs::perms::owner_all);
}

/// Programs that their README promises in build/release/bin.
std::set<std::string> promised_programs() {
  std::set<std::string> names;
  std::istringstream lines(read_text(source / "workflows/README.md"));
  for (std::string line; std::getline(lines, line);)
    if (std::smatch match; std::regex_search(line, match, std::regex(R"(^\| `([a-z_]+) (SCENE|states\.h5)` \|)")))
      names.insert(match[1]);
  return names;
}

/// A copy of `bootstrap` in a clean folder, with a CMake that only notes what it is asked for.
class Bootstrap : public testing::Test {
 protected:
  Bootstrap() {
    fs::create_directories(folder_ / "workflows");
    for (const char* file : {"bootstrap", "debian-packages.txt"})
      fs::copy_file(source / "workflows" / file, folder_ / "workflows" / file);
    write_program(folder_ / "stubs/dpkg-query", "echo installed");
    write_program(folder_ / "stubs/cmake", "echo \"$@\" >> " + (folder_ / "cmake.log").string());
    write_program(folder_ / "build/release/bin/run_workflow", "echo ran \"$@\"");
  }
  [[nodiscard]] Outcome bootstrap(const std::vector<std::string>& arguments) const {
    std::vector<std::string> command = {(folder_ / "workflows/bootstrap").string()};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return run(folder_.path(), command, {"PATH=" + (folder_ / "stubs").string() + ":" + std::getenv("PATH")});
  }
  [[nodiscard]] std::set<std::string> targets() const {
    const std::string log = read_text(folder_ / "cmake.log");
    std::istringstream words(log.substr(std::min(log.size(), log.find("--target") + 8)));
    return {std::istream_iterator<std::string>(words), {}};
  }

  TemporaryFolder folder_;
};

TEST_F(Bootstrap, BuildsEveryProgramThatTheReadmePromises) {
  const std::set<std::string> promised = promised_programs();
  ASSERT_TRUE(promised.contains("run_workflow"));
  ASSERT_TRUE(promised.contains("render_patch")) << "which draws the report's pictures";
  const Outcome outcome = bootstrap({"plain_small", "--alpha", "1"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(targets(), promised);
  EXPECT_NE(outcome.out.find("ran plain_small --alpha 1"), std::string::npos) << outcome.out;
}

TEST_F(Bootstrap, RunsWhatReadsFilesUnderSanitizers) {
  write_program(folder_ / "stubs/ctest", "echo tested \"$@\"");
  const Outcome outcome = bootstrap({"fuzz", "-L", "sanitized"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(targets(), std::set<std::string>{"fuzzers"});
  EXPECT_NE(read_text(folder_ / "cmake.log").find("--build --preset fuzz"), std::string::npos);
  EXPECT_NE(outcome.out.find("tested --preset fuzz --no-tests=error -j "), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find(" -L sanitized"), std::string::npos) << outcome.out;
}

TEST(Build, PutsRenderPatchBesideTheProgramsThatStartIt) {
  for (const fs::path program : {TRAME_RUN_WORKFLOW, TRAME_STRAIN_POST})
    EXPECT_TRUE(fs::exists(program.parent_path() / "render_patch")) << program;
}

}  // namespace
}  // namespace trame::test
