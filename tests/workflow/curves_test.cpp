/// curves.csv and branches.csv: what is written and what is read off, and that programs agree about it.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "micro/core/error.h"
#include "support/messages.h"
#include "support/process.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"
#include "workflows/curves/curves_plot.h"
#include "workflows/curves/test_curve.h"
#include "workflows/report.h"

namespace trame::workflows {
namespace {

using trame::test::Outcome;
using trame::test::read_text;
using trame::test::TemporaryFolder;
using trame::test::write_text;

/// Points of one stage, 0.001 apart in motion, from a law.
template <class Law>
void append(Curve& curve, const std::string& stage, double from, double to, Law law) {
  const int n = static_cast<int>(std::round(std::abs(to - from) / 0.001));
  for (int i = 0; i <= n; ++i) {
    const double u = from + (to - from) * i / n;
    curve.points.push_back({stage, 1.0 * i / n, u, law(u)});
  }
  curve.stages.insert(stage);
}

Curve curve_of_a_body() { return {"tip, x", "m", "N", {}, {}, true}; }

TEST(Branches, OfAnElasticSpringWithFrictionHaveItsStiffnessAndTheWorkThatItLoses) {
  // F = 5 u ± 0.1 N, there to 20 mm and back to 0.
  Curve curve = curve_of_a_body();
  append(curve, "load", 0, 0.02, [](double u) { return 5 * u + 0.1; });
  append(curve, "unload", 0.02, 0, [](double u) { return 5 * u - 0.1; });
  const std::vector<Branch> branches = branches_of(curve);
  ASSERT_EQ(branches.size(), 2U);
  for (const Branch& branch : branches) {
    EXPECT_NEAR(branch.initial_stiffness, 5, 1e-9);
    EXPECT_NEAR(branch.tangent_stiffness, 5, 1e-9);
  }
  EXPECT_NEAR(branches[0].work, 0.5 * 5 * 0.02 * 0.02 + 0.1 * 0.02, 1e-12);
  EXPECT_NEAR(branches[1].work, -0.5 * 5 * 0.02 * 0.02 + 0.1 * 0.02, 1e-12);
  EXPECT_FALSE(branches[0].loop);
  EXPECT_NEAR(branches[1].loop.value(), 2 * 0.1 * 0.02, 1e-12);
  EXPECT_EQ(branches[0].kind, Branch::Kind::loading);
  EXPECT_EQ(branches[1].kind, Branch::Kind::loading) << "friction takes more than the spring gives back";
}

TEST(Branches, ThatReturnOnlyPartOfTheWayLoseWhatLiesBetween) {
  Curve curve = curve_of_a_body();
  append(curve, "load", 0, 0.02, [](double u) { return 50 * u * u; });
  append(curve, "unload", 0.02, 0.0155, [](double u) { return 50 * u * u - 0.001; });
  const std::vector<Branch> branches = branches_of(curve);
  ASSERT_EQ(branches.size(), 2U);
  // Trapezoids of a parabola are off by f'' h²/12 over their length: 4·10⁻⁸.
  EXPECT_NEAR(branches[1].loop.value(), 0.001 * 0.0045, 4e-8) << "over 15.5 to 20 mm, which are no points of the first";
  EXPECT_EQ(branches[1].kind, Branch::Kind::unloading);
  EXPECT_NEAR(branches[0].initial_stiffness, 50 * 0.001, 1e-9);
  EXPECT_NEAR(branches[0].tangent_stiffness, 50 * (0.02 + 0.019), 1e-9);
}

TEST(Branches, OfACycleWithinAStageTurnWhereMotionDoes) {
  Curve curve = curve_of_a_body();
  const auto spring = [](double u) { return 5 * u; };
  append(curve, "cycle", 0, 0.01, spring);
  append(curve, "cycle", 0.01, -0.01, spring);
  append(curve, "cycle", -0.01, 0, spring);
  const std::vector<Branch> branches = branches_of(curve);
  ASSERT_EQ(branches.size(), 3U);
  EXPECT_EQ(branches[0].kind, Branch::Kind::loading);
  EXPECT_EQ(branches[1].kind, Branch::Kind::reversal);
  EXPECT_EQ(branches[2].kind, Branch::Kind::unloading);
  EXPECT_NEAR(branches[1].loop.value(), 0, 1e-12) << "a spring loses nothing";
  EXPECT_NEAR(branches[2].loop.value(), 0, 1e-12);
}

TEST(Branches, AreNotMadeByNoise) {
  Curve curve = curve_of_a_body();
  append(curve, "pull", 0, 0.02, [](double u) { return u; });
  curve.points[7].motion = curve.points[6].motion - 1e-6;  // less than a thousandth of 20 mm
  append(curve, "hold", 0.02, 0.021, [](double) { return 1.0; });
  curve.stages.erase("hold");
  EXPECT_EQ(branches_of(curve).size(), 1U);
  EXPECT_TRUE(branches_of(curve_of_a_body()).empty());
}

micro::Scene pulled() {
  micro::Scene scene;
  scene.bodies = {{"a, \"b\"", {0, 0, 0}, {}}, {"held", {0, 0, 0}, {}}};
  for (const char* name : {"pull, then", "turn"}) {
    micro::Stage& stage = scene.stages.emplace_back();
    stage.name = name;
    const bool turns = stage.name == "turn";
    stage.drives = {{"a*", turns ? micro::BodyDof::rz : micro::BodyDof::x,
                     turns ? micro::DriveMode::force : micro::DriveMode::displacement, 1, ""}};
  }
  return scene;
}

micro::SimulationSummary summary_of_pulled() {
  micro::SimulationSummary summary;
  summary.body_names = {"a, \"b\"", "held"};
  const auto point = [](const std::string& stage, double time, double x) {
    micro::CurvePoint p{stage, time, {}, {}, {}, std::vector<double>(12, 0.0), std::vector<double>(12, 0.0)};
    p.motion[0] = x, p.reaction[0] = 3 * x, p.motion[5] = 4 * x, p.reaction[5] = 5 * x;
    return p;
  };
  summary.stage_starts = {point("pull, then", 0, 0), point("turn", 0, 2)};
  summary.curve = {point("pull, then", 0.5, 1), point("pull, then", 1, 2)};
  return summary;
}

std::string branches_csv(const std::vector<Curve>& curves) {
  const TemporaryFolder folder;
  write_branches_csv(folder / "branches.csv", curves);
  return read_text(folder / "branches.csv");
}

TEST(CurvesCsv, HoldsWhatIsDrivenUnderNamesWithUnits) {
  const TemporaryFolder folder;
  write_curves_csv(folder / "curves.csv", curves_table(pulled(), summary_of_pulled()));
  EXPECT_EQ(
      read_text(folder / "curves.csv"),
      "stage,stage_time,\"a, \"\"b\"\".x_m\",\"a, \"\"b\"\".x_N\",\"a, \"\"b\"\".rz_rad\",\"a, \"\"b\"\".rz_Nm\"\n"
      "\"pull, then\",0,0,0,0,0\n"
      "\"pull, then\",0.5,1,3,4,5\n"
      "\"pull, then\",1,2,6,8,10\n")
      << "the held body is not driven, and the second stage has not begun";
}

TEST(CurvesCsv, IsReadAsItWasWritten) {
  const TemporaryFolder folder;
  const CurvesTable table = curves_table(pulled(), summary_of_pulled());
  write_curves_csv(folder / "curves.csv", table);
  const CurvesTable again = read_curves(folder / "curves.csv");
  EXPECT_EQ(again.columns, table.columns);
  ASSERT_EQ(again.rows.size(), table.rows.size());
  for (std::size_t i = 0; i < again.rows.size(); ++i) {
    EXPECT_EQ(again.rows[i].stage, table.rows[i].stage);
    EXPECT_EQ(again.rows[i].values, table.rows[i].values);
  }
  const std::vector<Curve> curves = curves_of(again, pulled());
  ASSERT_EQ(curves.size(), 2U);
  EXPECT_EQ(curves[0].name, "a, \"b\", x");
  EXPECT_EQ(curves[1].reaction_unit, "N m");
  EXPECT_EQ(curves[0].stages, std::set<std::string>{"pull, then"});
  EXPECT_NEAR(branches_of(curves[0]).at(0).initial_stiffness, 3, 1e-12);
}

TEST(CurvesCsv, SaysWhereItIsWrong) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& text) -> std::string {
    write_text(folder / "c.csv", text);
    try {
      (void)read_curves(folder / "c.csv");
    } catch (const InputError& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_NE(error("time,x\n").find("c.csv: not curves of a run"), std::string::npos);
  EXPECT_NE(error("stage,stage_time,x\npull,1\n").find("c.csv, line 2"), std::string::npos);
  EXPECT_NE(error("stage,stage_time,x\npull,1,2\npull,1,two\n").find("c.csv, line 3"), std::string::npos);
}

CurvesTable table_of_sides(const std::vector<std::pair<double, double>>& strain_and_force) {
  CurvesTable table{{side_columns.begin(), side_columns.end()}, {}};
  for (const auto& [strain, force] : strain_and_force)
    table.rows.push_back({"load", strain / 0.02, {strain, 0, force, 0.5 * force}});
  return table;
}

TEST(SideCurves, AreForcesPerWidthAndTheHeldSidesGoOverTheStrainOfTheOthers) {
  micro::Scene scene;
  scene.weave.emplace();
  scene.weave->warp.n_yarns = 4, scene.weave->warp.yarn_spacing = 0.5e-3;  // 2 mm wide
  scene.weave->weft.n_yarns = 2, scene.weave->weft.yarn_spacing = 0.5e-3;  // 1 mm
  const std::vector<Curve> curves = curves_of(table_of_sides({{0, 0}, {0.01, 0.2}, {0.02, 0.6}}), scene);
  ASSERT_EQ(curves.size(), 2U);
  EXPECT_EQ(curves[0].reaction_unit, "N/m");
  EXPECT_DOUBLE_EQ(curves[0].points[2].reaction, 300);
  EXPECT_EQ(curves[1].name, "weft sides, over the warp strain");
  EXPECT_DOUBLE_EQ(curves[1].points[2].motion, 0.02);
  EXPECT_DOUBLE_EQ(curves[1].points[2].reaction, 300);
  EXPECT_FALSE(curves[1].works);
  const std::string csv = branches_csv(curves);
  EXPECT_NE(csv.find("warp sides,load,loading,1,N/m,0,0.02,0,300,10000,20000,2.5,\n"
                     "\"weft sides, over the warp strain\",load,loading,1,N/m,0,0.02,0,300,10000,20000,,\n"),
            std::string::npos)
      << csv;
}

TEST(TestCurves, AreAPressureOverHowFarPlatesHaveClosedIn) {
  micro::Scene scene;
  scene.weave.emplace();
  using Dof = micro::BodyDof;
  const double area = 2e-6;
  scene.test_curve = micro::TestCurve{"plates", "m", "Pa", "compaction", {}};
  scene.test_curve->terms = {{.body = "plate/upper", .dof = Dof::z, .motion = -1, .reaction = -0.5 / area},
                             {.body = "plate/lower", .dof = Dof::z, .motion = 1, .reaction = 0.5 / area}};
  for (const char* name : {"plate/upper", "plate/lower"}) scene.bodies.push_back({name, Vec3::Zero(), {}});
  micro::Stage press;
  press.name = "compaction";
  press.drives = {{"plate/*", Dof::z, micro::DriveMode::strain, -0.1, ""}};
  scene.stages = {press};
  CurvesTable table{{"plate/upper.z_m", "plate/upper.z_N", "plate/lower.z_m", "plate/lower.z_N"},
                    {{"compaction", 0, {0, 0, 0, 0}}, {"compaction", 1, {-2e-6, -3e-3, 1e-6, 3e-3}}}};
  const std::vector<Curve> curves = curves_of(table, scene);
  ASSERT_EQ(curves.size(), 3U);
  EXPECT_TRUE(curves[0].is_of_fabric());
  EXPECT_DOUBLE_EQ(curves[0].points[1].motion, 3e-6);
  EXPECT_DOUBLE_EQ(curves[0].points[1].reaction, 3e-3 / 2e-6);
  EXPECT_TRUE(curves[0].parts.contains(curves[1].name));
  EXPECT_NE(plot_commands({curves[0]}).find("set ylabel 'pressure (kPa)'"), std::string::npos);
  const std::string csv = branches_csv(curves);
  EXPECT_NE(csv.find("plates,compaction,loading,m,Pa,0,3e-06,0,1500,"), std::string::npos) << csv;
  add_columns(curves[0], table);
  EXPECT_EQ(table.columns.back(), "plates.reaction_Pa");
  EXPECT_DOUBLE_EQ(table.rows[1].values.back(), 1500);
}

TEST(TestCurves, CountMotionsOverALengthAsItIsWhenTheTestBegins) {
  const micro::TestCurve bending{.name = "bending",
                                 .motion_unit = "1/m",
                                 .reaction_unit = "N",
                                 .stage = "bending",
                                 .terms = {{.body = "end", .dof = micro::BodyDof::ry, .motion = -1, .reaction = -2},
                                           {.body = "end", .dof = micro::BodyDof::x, .length = 1}},
                                 .length = 1e-3};
  const CurvesTable table{
      {"end.x_m", "end.x_N", "end.ry_rad", "end.ry_Nm"},
      {{"settle", 1, {-2e-4, 0, 0, 0}}, {"bending", 0, {-2e-4, 0, 0, 0}}, {"bending", 1, {-3e-4, 0, -0.4, -5}}}};
  const std::optional<Curve> curve = measured(bending, table);
  ASSERT_TRUE(curve);
  EXPECT_DOUBLE_EQ(curve->points.back().motion, 0.4 / 8e-4);
  EXPECT_DOUBLE_EQ(curve->points.back().reaction, 10);
  EXPECT_FALSE(measured(bending, CurvesTable{{"end.x_m", "end.x_N"}, {}})) << "columns that are missing";
}

TEST(CurvesPlot, DrawsUnloadingDashedAndBackToWhereItBegan) {
  Curve curve = curve_of_a_body();
  append(curve, "load", 0, 0.002, [](double u) { return 5 * u; });
  append(curve, "unload", 0.002, 0, [](double u) { return 4 * u; });
  const std::string commands = plot_commands({curve});
  EXPECT_NE(commands.find("$curve0_0 << EOD\n0 0\n1000 5\n2000 10\nEOD\n"), std::string::npos) << commands;
  EXPECT_NE(commands.find("$curve0_1 << EOD\n2000 8\n1000 4\n0 0\nEOD\n"), std::string::npos);
  EXPECT_NE(commands.find("$curve0_1 with linespoints pt 7 ps 0.4 lw 2 dt 2"), std::string::npos);
  EXPECT_TRUE(plot_commands({}).empty());
}

TEST(CurvesPlot, TakesNoTextOfAUserIntoItsScript) {
  if (trame::test::run(".", {"gnuplot", "--version"}).exit_code != 0) GTEST_SKIP() << "gnuplot is not installed";
  const TemporaryFolder folder;
  for (const std::string attack : {"x\n!touch pwned\n#", "x'\n!touch pwned\n'", "x\"\n!touch pwned\n", "`touch pwned`",
                                   "'.system('touch pwned').'", "\".system(\"touch pwned\").\"", "x\\",
                                   "@pwned $0 {/x ^2}", "x\r!touch pwned\r", "EOD\n!touch pwned\n$curve << EOD\n"}) {
    Curve curve{attack, "m", "N", {}, {}, true};
    append(curve, attack, 0, 0.002, [](double u) { return u; });
    EXPECT_TRUE(plot_curves(folder.path(), {curve}, attack)) << attack;
    EXPECT_FALSE(std::filesystem::exists(folder / "pwned")) << attack;
    EXPECT_NE(read_text(folder / "curves.svg").find("</svg>"), std::string::npos) << attack;
  }
}

/// A woven patch without contact: four straight fibers, E A = 1 N each, pulled along the warp, held, let go.
const std::string patch = R"(title = "patch"
[material.m]
model = "isotropic"
young_modulus = "1 GPa"
poisson_ratio = 0
[fiber_type.f]
material = "m"
diameter = "35.6825 um"
model = "rod"
[weave]
pattern = "plain"
[weave.warp]
fiber_type = "f"
yarns = 2
fibers = 1
elements = 10
yarn_spacing = "1 mm"
margin = "1 mm"
[weave.weft]
fiber_type = "f"
yarns = 2
fibers = 1
elements = 10
yarn_spacing = "1 mm"
margin = "1 mm"
[effects]
contact = "none"
)";
std::string stage(const std::string& name, const std::string& strain) {
  std::string text = fmt::format("[[stage]]\nname = \"{}\"\nincrements = 2\n", name);
  if (strain.empty()) return text;
  for (const std::string end : {"start", "end"})
    text += fmt::format(
        "[[stage.drive]]\nbodies = \"side/warp/{0}\"\ndof = \"x\"\nstrain = {1}\n"
        "[[stage.drive]]\nbodies = \"warp/*/{0}\"\ndof = \"x\"\nfollow = \"side/warp/{0}\"\n",
        end, strain);
  return text;
}

/// Of a fiber with E A = 1 N, linear in Green-Lagrange strain, N. Ties let the ends give way by 10⁻³ of an element's
/// stretch.
double force_at(double strain) { return 0.5 * (std::pow(1 + strain, 2) - 1) * (1 + strain); }

class PatchRun : public testing::Test {
 protected:
  Outcome simulate(const std::string& text, const std::vector<std::string>& more = {}) {
    write_text(folder_ / "patch.toml", text);
    std::vector<std::string> command = {TRAME_SIMULATE_FIBERS, "patch.toml", "--out", "out", "--overwrite"};
    command.insert(command.end(), more.begin(), more.end());
    return trame::test::run(folder_.path(), command);
  }
  TemporaryFolder folder_;
};

TEST_F(PatchRun, StrainGoesOnThroughStagesAndComesBack) {
  const Outcome outcome =
      simulate(patch + stage("load", "0.02") + stage("hold", "") + stage("unload", "-0.0196078431372549"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const CurvesTable table = read_curves(folder_ / "out/curves.csv");
  ASSERT_EQ(table.rows.size(), 9U) << "two increments and a start of three stages";
  const std::size_t strain = *table.find("warp_strain"), force = *table.find("warp_force_N");
  const std::vector<double> expected = {0, 0.01, 0.02, 0.02, 0.02, 0.02, 0.02, 0.01, 0};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(table.rows[i].values[strain], expected[i], 1e-9) << i;
    EXPECT_NEAR(table.rows[i].values[force], 2 * force_at(expected[i]), 2e-4) << "two fibers, row " << i;
  }
  // The side bodies pull from the start of each stage on, and do the work.
  const std::size_t reaction = *table.find("side/warp/end.x_N"), motion = *table.find("side/warp/end.x_m");
  EXPECT_NEAR(table.rows[6].values[reaction], 2 * force_at(0.02), 2e-4)
      << "taken over from the yarns' ends, which were held";
  EXPECT_NEAR(table.rows[2].values[motion], 0.02 * 1.5e-3, 1e-9);
  EXPECT_NEAR(table.rows[8].values[motion], 0, 1e-3 * 0.02 * 1.5e-3) << "leaders give way by what their springs do";
  const std::string branches = read_text(folder_ / "out/branches.csv");
  trame::test::expect_mentions(branches, {"warp sides,load,loading,1,N/m,0,0.02,", "warp sides,unload,unloading,1,N/m,",
                                          "\"side/warp/end, x\",load,loading,m,N"});
}

TEST_F(PatchRun, SavedStatesListWhatCurvesHold) {
  ASSERT_EQ(simulate(patch + stage("load", "0.02")).exit_code, 0);
  const CurvesTable table = read_curves(folder_ / "out/curves.csv");
  const Outcome list = trame::test::run(folder_.path(), {TRAME_STRAIN_POST, "out/states.h5", "--list"});
  ASSERT_EQ(list.exit_code, 0) << list.err;
  std::istringstream lines(list.out);
  std::string line;
  std::getline(lines, line);
  trame::test::expect_mentions(line, {"warp_strain", "weft_strain", "warp_force_N", "weft_force_N"});
  std::getline(lines, line);  // the reference
  for (std::size_t row : {1, 2}) {
    std::getline(lines, line);
    std::string expected;
    for (std::size_t c = 0; c < 4; ++c) expected += fmt::format("  {:>12.5e}", table.rows[row].values[c]);
    EXPECT_NE(line.find(expected), std::string::npos) << line << "\nexpected " << expected;
  }
}

TEST_F(PatchRun, WorkOfTheCurvesIsThatOfTheEnergyBooks) {
  ASSERT_EQ(simulate(patch + stage("load", "0.02")).exit_code, 0);
  const std::vector<Curve> curves =
      curves_of(read_curves(folder_ / "out/curves.csv"), micro::parse_scene(patch + stage("load", "0.02"), "patch"));
  double work = 0;
  for (const Curve& curve : curves)
    for (const Branch& branch : branches_of(curve))
      if (curve.motion_unit == "m") work += branch.work;
  const auto summary = nlohmann::json::parse(read_text(folder_ / "out/summary.json"));
  // Of two fibers of 3 mm by the trapezoidal rule with two increments. The yarn ends follow: their work is inside.
  const double expected = 2 * 3e-3 * 0.01 * (force_at(0.01) + 0.5 * force_at(0.02));
  EXPECT_NEAR(work, expected, 5e-3 * expected);
  EXPECT_NEAR(work, summary.at("energy").at("work").at("bodies").get<double>(), 1e-12);
}

}  // namespace
}  // namespace trame::workflows
