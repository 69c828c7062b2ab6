#include "workflows/report.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "support/process.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"
#include "workflows/report/curves_plot.h"

namespace trame::workflows {
namespace {

using micro::CurvePoint;
using micro::SimulationSummary;

TEST(CurvesCsv, WritesALineForEachIncrementUnderAHeaderWithUnits) {
  const std::vector<CurvePoint> curve = {{"relax", 1, {0, 0}, {0.25, 0.5}},
                                         {"load", 0.05, {0.001, -0.0005}, {1.5, 2e-7}}};
  EXPECT_EQ(curves_csv(curve),
            "stage,stage_time,warp_strain,weft_strain,warp_force_N,weft_force_N\n"
            "relax,1,0,0,0.25,0.5\n"
            "load,0.05,0.001,-0.0005,1.5,2e-07\n");
}

TEST(CurvesCsv, QuotesStageNamesThatWouldBreakTheTable) {
  EXPECT_NE(curves_csv({{"pull, then \"hold\"", 1, {}, {}}}).find("\n\"pull, then \"\"hold\"\"\",1,0,"),
            std::string::npos);
}

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
                    .work = {1, 2, 3, 4, 5, 6, -16}};
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
                                                 {"stages", -16.0}}}}));
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

TEST(CurvesPlot, ShowsTheLastStageThatIsStrained) {
  const CurvePoint relax{"relax", 1, {0, 0}, {1, 1}}, load{"load", 1, {0.02, 0.01}, {1, 1}},
      shear{"shear", 1, {0, 0}, {}};
  const auto stage = strained_stage({relax, load, shear});
  ASSERT_TRUE(stage);
  EXPECT_EQ(stage->first, 1U);
  EXPECT_EQ(stage->end, 2U);
  EXPECT_EQ(stage->side, "warp");
  EXPECT_FALSE(strained_stage({relax, shear}));
  EXPECT_FALSE(strained_stage({}));
}

TEST(CurvesPlot, FallsBackToTheWeftStrain) {
  const CurvePoint load{"load", 1, {0, 0.01}, {1, 1}};
  ASSERT_TRUE(strained_stage({load}));
  EXPECT_EQ(strained_stage({load})->side, "weft");
}

TEST(CurvesPlot, HoldsTheRowsOfItsStageAlone) {
  const std::vector<CurvePoint> curve = {{"relax", 1, {0, 0}, {1, 1}},
                                         {"load", 0.5, {0.01, 0}, {2, 3}},
                                         {"load", 1, {0.02, 0}, {4, 5}},
                                         {"hold", 1, {0, 0}, {6, 7}}};
  const auto stage = strained_stage(curve);
  ASSERT_TRUE(stage);
  EXPECT_NE(plot_script(curve, *stage, "").find("<< EOD\n1 2 3\n2 4 5\nEOD\n"), std::string::npos);
}

TEST(CurvesPlot, TakesNoTextOfAUserIntoItsScript) {
  if (trame::test::run(".", {"gnuplot", "--version"}).exit_code != 0) GTEST_SKIP() << "gnuplot is not installed";
  const trame::test::TemporaryFolder folder;
  const OutputDirectory out(folder / "out", OutputDirectory::Earlier::refused);
  for (const std::string attack : {"x\n!touch pwned\n#", "x'\n!touch pwned\n'", "x\"\n!touch pwned\n", "`touch pwned`",
                                   "'.system('touch pwned').'", "\".system(\"touch pwned\").\"", "x\\",
                                   "@pwned $0 {/x ^2}", "x\r!touch pwned\r", "EOD\n!touch pwned\n$curve << EOD\n"}) {
    const std::vector<CurvePoint> curve = {{attack, 0.5, {0.01, 0}, {2, 3}}, {attack, 1, {0.02, 0}, {4, 5}}};
    EXPECT_TRUE(plot_curves(out, curve, attack)) << attack;
    EXPECT_FALSE(std::filesystem::exists(out.root() / "pwned")) << attack;
    EXPECT_NE(trame::test::read_text(out.root() / "curves.svg").find("</svg>"), std::string::npos) << attack;
  }
}

}  // namespace
}  // namespace trame::workflows
