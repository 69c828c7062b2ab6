#include "workflows/report.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace trame::workflows {
namespace {

using micro::SimulationSummary;

TEST(SummaryJson, HoldsEveryNumberOfTheRun) {
  SimulationSummary summary;
  summary.status = SimulationSummary::Status::gave_up;
  summary.message = "stage load, increment 7";
  summary.size.n_fibers = 30;
  summary.size.n_nodes = 810;
  summary.size.n_dofs = 7290;
  summary.n_contact_elements_max = 1234;
  summary.n_increments = 41;
  summary.n_cut_increments = 3;
  summary.n_newton_iterations = 502;
  summary.n_factorizations = 510;
  summary.max_penetration_over_radius = 0.031;
  summary.force_imbalance = 1e-5;
  summary.moment_imbalance = 2e-5;
  summary.energy = {.external_work = 5,
                    .stored = 3,
                    .friction = 1.25,
                    .damping = 0.25,
                    .imbalance = 0.25,
                    .release = 0.25,
                    .work = {1, 2, 3, 4, 5, 6, -23, 7}};
  summary.crossing_order_ok = false;
  summary.n_threads = 2;
  summary.timers.add(Phase::factorization, 12.5);
  summary.timers.add(Phase::meso, 0.5);
  const nlohmann::json json = summary_json("plain_small", 0.5, summary);
  const nlohmann::json expected = {{"version", TRAME_VERSION},
                                   {"scene", "plain_small"},
                                   {"alpha", 0.5},
                                   {"status", "gave_up"},
                                   {"message", "stage load, increment 7"},
                                   {"n_fibers", 30},
                                   {"n_nodes", 810},
                                   {"n_dofs", 7290},
                                   {"n_contact_elements_max", 1234},
                                   {"n_increments", 41},
                                   {"n_cut_increments", 3},
                                   {"n_newton_iterations", 502},
                                   {"n_factorizations", 510},
                                   {"max_penetration_over_radius", 0.031},
                                   {"force_imbalance", 1e-5},
                                   {"moment_imbalance", 2e-5},
                                   {"crossing_order_ok", false},
                                   {"threads", 2}};
  for (const auto& [key, value] : expected.items()) EXPECT_EQ(json.at(key), value) << key;
  EXPECT_EQ(json.at("energy"), nlohmann::json({{"external_work", 5.0},
                                               {"stored", 3.0},
                                               {"friction", 1.25},
                                               {"damping", 0.25},
                                               {"release", 0.25},
                                               {"imbalance", 0.25},
                                               {"work",
                                                {{"bodies", 1.0},
                                                 {"separation", 2.0},
                                                 {"contacts", 3.0},
                                                 {"preloads", 4.0},
                                                 {"gap_offsets", 5.0},
                                                 {"friction_limits", 6.0},
                                                 {"stages", -23.0},
                                                 {"fiber_loads", 7.0}}}}));
  EXPECT_EQ(json.at("seconds").at("factorization"), 12.5);
  EXPECT_EQ(json.at("seconds").at("meso"), 0.5);
  EXPECT_EQ(json.at("seconds").at("symbolic"), 0.0);
  EXPECT_EQ(json.at("seconds").size(), n_phases + 1);
  EXPECT_GE(json.at("seconds").at("total"), 0.0);
}

TEST(SummaryJson, CountsMemoryInBytes) {
  const std::size_t block = 64u << 20;
  const std::vector<char> touched(block, 1);
  EXPECT_GT(summary_json("s", {}, {}).at("peak_memory_bytes"), block) << int(touched.back());
}

TEST(SummaryJson, SaysNullWhereThereIsNoRatioAndWhereANumberIsNone) {
  SimulationSummary summary;
  summary.force_imbalance = std::numeric_limits<double>::quiet_NaN();
  const nlohmann::json json = nlohmann::json::parse(summary_json("s", {}, summary).dump());
  EXPECT_TRUE(json.at("alpha").is_null());
  EXPECT_TRUE(json.at("force_imbalance").is_null());
}

TEST(SummaryJson, NamesEveryStatus) {
  using Status = SimulationSummary::Status;
  EXPECT_EQ(status_text(Status::done), "done");
  EXPECT_EQ(status_text(Status::interrupted), "interrupted");
  EXPECT_EQ(status_text(Status::gave_up), "gave_up");
}

}  // namespace
}  // namespace trame::workflows
