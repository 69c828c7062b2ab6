/// \file
/// What `--check` says about the cost of a scene against a run of it.

#include "micro/cost_estimate.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <nlohmann/json.hpp>

#include "support/process.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"

namespace trame::test {
namespace {

/// CPU time of the programs that this one has started and that have ended, s.
double seconds_of_children() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

TEST(CostEstimate, IsWithinAFactorOfThreeOfARun) {
  const micro::CostEstimate estimate =
      micro::estimate_cost(micro::read_scene(TRAME_DATA_DIR "/scenes/plain_small.toml"));
  const TemporaryFolder folder;
  const double before = seconds_of_children();
  const Outcome outcome = run(folder.path(), {TRAME_SIMULATE_FIBERS, "plain_small", "--threads", "1", "--out", "out"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  // Of one thread: other programs on the machine do not count. Two threads gain a factor of 1.5 on so small a scene.
  const double seconds = (seconds_of_children() - before) / 1.5;
  const auto summary = nlohmann::json::parse(read_text(folder / "out/summary.json"));
  const double bytes = summary.at("peak_memory_bytes");
  EXPECT_GT(estimate.seconds, seconds / 3);
  EXPECT_LT(estimate.seconds, seconds * 3);
  EXPECT_GT(estimate.bytes, bytes / 3);
  EXPECT_LT(estimate.bytes, bytes * 3);
}

}  // namespace
}  // namespace trame::test
