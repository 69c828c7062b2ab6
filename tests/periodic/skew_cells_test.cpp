/// \file
/// Weaves whose weft crosses the warp at other angles: what they lay out, the dofs of their bodies, runs.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "micro/solve/tangent_system.h"
#include "tests/periodic/periodic_fixture.h"
#include "tests/periodic/plain_cell.h"
#include "tests/support/finite_differences.h"
#include "tests/support/messages.h"

namespace trame::micro {
namespace {

using test::Cell;
using test::plain_cell;
using test::run_scene;
using test::RunResult;

constexpr double degree = std::numbers::pi / 180;

Scene plain_at(double degrees, const std::string& more = "", const std::string& periodic = "true") {
  return parse_scene(plain_cell({.fibers = 1,
                                 .periodic = periodic,
                                 .pattern = fmt::format("pattern = \"plain\"\nangle = \"{} deg\"", degrees),
                                 .more = more}),
                     "cell.toml");
}

// Spacings are across the yarns, whatever the angle; fibers stand across their yarn.
TEST(SkewWeaves, AreLaidOutByWhatIsAcrossTheYarns) {
  const Scene scene = parse_scene(plain_cell({.pattern = "pattern = \"plain\"\nangle = \"30 deg\""}), "cell.toml");
  const Assembly assembly = assemble_scene(scene);
  const Vec3 weft(std::cos(30 * degree), std::sin(30 * degree), 0);
  EXPECT_LT((assembly.body_positions[0] - Vec3(520e-6, 0, 0)).norm(), 1e-15);
  EXPECT_LT((assembly.body_positions[1] - 520e-6 * weft).norm(), 1e-15);
  const auto& r = assembly.configuration.r;
  const auto& first = assembly.mesh.first_node;
  // Three fibers a yarn, two yarns of each system.
  const Vec3 of_warp = r[first[3]] - r[first[0]], of_weft = r[first[9]] - r[first[6]];
  EXPECT_NEAR(of_warp.y(), 130e-6, 1e-15);
  EXPECT_NEAR(of_weft.cross(weft).norm(), 130e-6, 1e-15);
  EXPECT_NEAR((r[first[1]] - r[first[0]]).x(), 0, 1e-15);
  EXPECT_NEAR((r[first[7]] - r[first[6]]).dot(weft), 0, 1e-15);
}

TEST(SkewWeaves, RefuseAnglesAtWhichYarnsHardlyCross) {
  for (const char* angle : {"14 deg", "166 deg", "-60 deg"})
    trame::test::expect_mentions(
        trame::test::input_error([&] {
          (void)parse_scene(plain_cell({.pattern = fmt::format("pattern = \"plain\"\nangle = \"{}\"", angle)}),
                            "c.toml");
        }),
        {"c.toml", "weave.angle", angle, "15 to 165 deg"});
  const std::string drive =
      "[[stage]]\nname = \"load\"\n[[stage.drive]]\nbodies = \"side/weft/end\"\nalong = [1, 1, 0]\nforce = \"1 mN\"";
  trame::test::expect_mentions(trame::test::input_error([&] { (void)plain_at(60, drive, "false"); }),
                               {"along", "side/weft/end", "dof"});
  EXPECT_NO_THROW((void)plain_at(90, drive, "false"));
}

// The system's forces and tangent are by dofs that count along warp and weft: the energy's slopes and theirs.
TEST(SkewWeaves, ForcesAndTangentAreByTheDofsOfPeriods) {
  const Cell cell({.model = FiberModel::rod, .n_weft = 1, .angle = 60 * degree});
  const Layout& layout = cell.model->layout;
  const State state = test::perturbed(layout, cell.state, 0.003, 4);
  Effects& effects = cell.model->effects;
  Timers timers;
  TangentSystem system(layout, 1, timers);
  const std::vector<Vec3> at_rest(layout.n_vectors(), Vec3::Zero());
  for (const auto& effect : effects) {
    effect->begin_step(cell.state, 1);
    effect->update(cell.state);
    (void)effect->follow(state, Effect::Follow::renewal, everywhere);
  }
  system.cover_sparsity(effects);
  system.assemble(effects, state, at_rest, Assembler::Tangent::exact);
  const Eigen::MatrixXd tangent = test::dense(layout, system.pattern(), system.values());
  const std::vector<double> force = system.force();
  constexpr double h = 1e-6;
  for (const Index dof : {0, 6, 7}) {  // of both periods: the components that are driven
    std::vector<double> step(layout.n_dofs(), 0.0);
    step[dof] = 1;
    State forward, backward;
    retract(layout, state, step, h, forward);
    retract(layout, state, step, -h, backward);
    double slope = 0;
    Eigen::VectorXd column = Eigen::VectorXd::Zero(layout.n_dofs());
    for (const auto& [at, sign] : {std::pair{&forward, 1.0}, {&backward, -1.0}}) {
      for (const auto& effect : effects) {
        (void)effect->follow(*at, Effect::Follow::trial, everywhere);
        slope += sign * effect->energy(*at) / (2 * h);
      }
      system.assemble(effects, *at, at_rest, Assembler::Tangent::none);
      column += sign / (2 * h) * Eigen::Map<const Eigen::VectorXd>(system.force().data(), layout.n_dofs());
    }
    EXPECT_NEAR(slope, force[dof], 1e-6 * (1 + std::abs(force[dof]))) << dof;
    EXPECT_GT(std::abs(force[dof]), 1e-4);
    EXPECT_LT((column - tangent.col(dof)).norm(), 1e-4 * tangent.col(dof).norm()) << dof;
  }
}

// Bars along the weft: the force per width is by the strain along them, at any angle.
TEST(SkewWeaves, StraightFibersPullAlongThemselves) {
  Scene scene = test::cell_scene({.model = FiberModel::rod, .n_warp = 3, .n_weft = 2, .angle = 50 * degree});
  scene.contact.scope = ContactScope::none;
  scene.stages[0].drives = {{"cell/weft", BodyDof::y, DriveMode::strain, 0.02, ""}};
  const RunResult result = run_scene(scene);
  ASSERT_TRUE(result.done()) << result.summary.message;
  const CurvePoint& end = result.summary.curve.back();
  const double stretch = 1.02, pull = std::numbers::pi * 0.5 * (stretch * stretch - 1) * stretch;
  EXPECT_NEAR(end.side_strain[1], 0.02, 1e-12);
  EXPECT_NEAR(end.side_force[1], 2 * pull, 1e-7 * pull);
  EXPECT_NEAR(end.side_force[0], 0, 1e-7 * pull);
  const Vec3 weft = result.last().bodies.position[1];
  EXPECT_NEAR(std::atan2(weft.y(), weft.x()), 50 * degree, 1e-12);
}

/// Cells are woven without friction, which would keep what differs on the way; a patch of so few fibers would fall
/// apart.
RunResult woven_and_pulled(double degrees, const std::string& periodic, const std::string& test) {
  Scene scene = plain_at(
      degrees, "[effects]\nadapt_penalty = false\n[solver]\nforce_tolerance = 1e-8\n[test]\nincrements = 3\n" + test,
      periodic);
  for (Stage& stage : scene.stages) stage.friction = periodic == "false" || &stage == &scene.stages.back();
  RunResult result = run_scene(scene);
  EXPECT_TRUE(result.done()) << result.summary.message;
  EXPECT_EQ(result.summary.n_crossings_ok, 4);
  EXPECT_LT(std::abs(result.summary.energy.imbalance), 0.02 * result.summary.energy.external_work);
  return result;
}

// In a mirror a plain weave that leans one way leans the other way: cells and patches, woven, pulled both ways, and
// along the weft alone.
TEST(SkewWeaves, LeanBothWaysAlike) {
  const auto expect_alike = [](const std::string& periodic, const std::string& test, double tolerance) {
    const auto force = woven_and_pulled(60, periodic, test).summary.curve.back().side_force,
               mirrored = woven_and_pulled(120, periodic, test).summary.curve.back().side_force;
    EXPECT_GT(force[1], 0) << test;
    for (int d = 0; d < 2; ++d) EXPECT_NEAR(mirrored[d], force[d], tolerance * force[1]) << periodic << ", " << test;
  };
  expect_alike("true", "kind = \"biaxial\"\nwarp_strain = 0.01\nweft_strain = 0.005", 1e-4);
  expect_alike("false", "kind = \"biaxial\"\nwarp_strain = 0.01\nweft_strain = 0.005", 1e-3);
  expect_alike("true", "kind = \"uniaxial\"\ndirection = \"weft\"\nstrain = 0.01", 1e-4);
}

}  // namespace
}  // namespace trame::micro
