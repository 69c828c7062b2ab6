/// run_workflow without a whole simulation: --check, --print-schema, Ctrl-C, the BLAS kernel.

#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "support/messages.h"
#include "support/process.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"
#include "support/tied_rod.h"

namespace trame::test {
namespace {

TEST(RunWorkflow, CheckSaysWhatWouldBeSimulatedAndWritesNothing) {
  const TemporaryFolder folder;
  const Outcome outcome = run(folder.path(), {TRAME_RUN_WORKFLOW, "plain_small", "--check"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  // 2 × 2 yarns of 7 (warp) and 8 (weft) fibers.
  expect_mentions(outcome.out,
                  {"plain_small", "30 fibers", "effects.contact", "separate_yarns", "separate:", "load:", "side/warp"});
  EXPECT_FALSE(std::filesystem::exists(folder / "results"));
}

TEST(RunWorkflow, SchemaListsTheKeysOfAScene) {
  const TemporaryFolder folder;
  const Outcome outcome = run(folder.path(), {TRAME_RUN_WORKFLOW, "--print-schema"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  expect_mentions(outcome.out,
                  {"title", "young_modulus", "diameter", "friction_coefficient", "yarn_spacing", "separate_yarns"});
}

TEST(RunWorkflow, HelpTellsTheExitCodes) {
  const TemporaryFolder folder;
  const Outcome outcome = run(folder.path(), {TRAME_RUN_WORKFLOW, "--help"});
  EXPECT_EQ(outcome.exit_code, 0);
  expect_mentions(outcome.out, {"--alpha", "--overwrite", "Exit codes"});
}

TEST(RunWorkflow, InterruptSavesEverythingUpToTheCurrentIncrement) {
  const TemporaryFolder folder;
  Process process(folder.path(), {TRAME_RUN_WORKFLOW, "plain_small", "--out", "out"});
  ASSERT_TRUE(process.wait_for_output("increment 1 ", 300));
  process.send(SIGINT);
  const Outcome outcome = process.wait();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  expect_mentions(outcome.out, {"Interrupted"});
  const auto summary = nlohmann::json::parse(read_text(folder / "out/summary.json"));
  EXPECT_EQ(summary.at("status"), "interrupted");
  EXPECT_GE(summary.at("n_increments"), 1);
  EXPECT_GT(std::filesystem::file_size(folder / "out/states.h5"), 0u);
  EXPECT_TRUE(std::filesystem::exists(folder / "out/vtk/fibers.pvd"));
}

TEST(RunWorkflow, WarnsInTheTerminalTheSummaryAndTheReport) {
  // A straight column at twice Euler's load, 4π² (R/2L)²: it stays straight, in an equilibrium that is unstable.
  const TemporaryFolder folder;
  write_text(folder / "column.toml", "title = \"column\"\n" + tied_rod(12) + R"([[stage]]
name = "shorten"
increments = 4
[[stage.drive]]
bodies = "right"
dof = "x"
displacement = "-2 um"
)");
  const Outcome outcome = run(folder.path(), {TRAME_RUN_WORKFLOW, "column.toml", "--out", "out"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto warnings = nlohmann::json::parse(read_text(folder / "out/summary.json")).at("warnings");
  ASSERT_FALSE(warnings.empty());
  const std::string report = read_text(folder / "out/report.html");
  for (const std::string warning : warnings) {
    expect_mentions(outcome.out, {"Warning: " + warning + "."});
    EXPECT_LT(report.find("<b>Warning:</b> " + warning + "."), report.find("<nav>")) << warning;
  }
  EXPECT_NE(warnings.front().get<std::string>().find("unstable"), std::string::npos) << warnings;
}

TEST(RunWorkflow, LeavesAKernelThatTheUserChose) {
  const TemporaryFolder folder;
  Process process(folder.path(), {TRAME_RUN_WORKFLOW, "plain_small", "-v"}, {"OPENBLAS_CORETYPE=Nehalem"});
  EXPECT_TRUE(process.wait_for_output("OpenBLAS kernel Nehalem", 60));
  process.send(SIGKILL);
}

}  // namespace
}  // namespace trame::test
