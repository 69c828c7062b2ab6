/// \file
/// What a periodic weave lays out, and what is refused in its scene.

#include <fmt/format.h>

#include "micro/weave/flat_start.h"
#include "tests/periodic/plain_cell.h"
#include "tests/support/messages.h"

namespace trame::micro {
namespace {

using test::CellText;
using test::plain_cell;
using trame::test::expect_mentions;
using trame::test::input_error;

std::string error_of(const std::string& toml) {
  return input_error([&] { (void)parse_scene(toml, "cell.toml"); });
}

TEST(PeriodicScenes, LayOutYarnsThatComeBack) {
  const Scene scene = parse_scene(plain_cell(), "cell.toml");
  const Assembly assembly = assemble_scene(scene);
  EXPECT_EQ(assembly.body_names, (std::vector<std::string>{"cell/warp", "cell/weft"}));
  EXPECT_TRUE(assembly.ties.empty());
  EXPECT_EQ(assembly.crossings.size(), 4u);
  for (Index f = 0; f < assembly.mesh.n_fibers(); ++f) {
    const Index first = assembly.mesh.first_node[f], last = assembly.mesh.first_node[f + 1] - 1;
    const FiberConfiguration& c = assembly.configuration;
    const Vec3 period = assembly.body_positions[assembly.mesh.period(f)];
    EXPECT_EQ(period, f < 6 ? Vec3(260e-6, 0, 0) : Vec3(0, 260e-6, 0));
    EXPECT_LT((c.r[last] - c.r[first] - period).norm(), 1e-18);
    EXPECT_EQ(c.g1[last], c.g1[first]);
  }
}

TEST(PeriodicScenes, OfOneSystemHaveEdges) {
  const Scene scene = parse_scene(plain_cell({.periodic = "\"warp\""}), "cell.toml");
  const Assembly assembly = assemble_scene(scene);
  EXPECT_EQ(assembly.body_names.front(), "cell/warp");
  EXPECT_EQ(assembly.body_names.size(), 1u + 4 + 2);
  EXPECT_EQ(assembly.mesh.period(0), 0);
  EXPECT_LT(assembly.mesh.period(6), 0);
}

TEST(PeriodicScenes, RefuseRepeatsThatDoNotClose) {
  expect_mentions(error_of(plain_cell({.warps = 3})), {"cell.toml", "weave.warp.yarns", "3", "multiple of 2"});
  expect_mentions(error_of(plain_cell({.wefts = 3})), {"weave.weft.yarns", "3", "multiple of 2"});
  EXPECT_EQ(error_of(plain_cell({.wefts = 4})), "");
  // Across a strip any number will do.
  EXPECT_EQ(error_of(plain_cell({.warps = 3, .periodic = "\"warp\""})), "");
  expect_mentions(error_of(plain_cell({.wefts = 3, .periodic = "\"warp\""})), {"weave.weft.yarns"});
  // What is written twice as large as it is closes all the same.
  EXPECT_EQ(error_of(plain_cell({.pattern = "picture = [\"X.X.\", \".X.X\", \"X.X.\", \".X.X\"]"})), "");
}

TEST(PeriodicScenes, RefuseWhatHasNoPlaceInACell) {
  expect_mentions(error_of(plain_cell({.of_warp = "margin = \"60 um\""})), {"weave.warp.margin", "periodic"});
  expect_mentions(error_of(plain_cell({.of_warp = "elements = 1"})), {"weave.warp.elements", "at least 2"});
  expect_mentions(error_of(plain_cell({.of_warp = "twist = \"5000 per m\"\ntwist_direction = \"Z\""})),
                  {"weave.warp.twist", "1.3 turns", "whole number"});
  expect_mentions(error_of(plain_cell({.periodic = "\"both\""})),
                  {"weave.periodic", "both", "true, false, \"warp\" or \"weft\""});
  expect_mentions(error_of(plain_cell({.more = "[solver]\npreconditioner = \"two_level\""})),
                  {"solver.preconditioner", "periodic"});
  expect_mentions(error_of(plain_cell({.more = "[[bundle]]\nname = \"b\"\nfiber_type = \"f\"\nfibers = 3\nelements = "
                                               "4\npoints = [[\"0 um\", \"0 um\", \"90 um\"], [\"99 um\", \"0 um\", "
                                               "\"90 um\"]]"})),
                  {"weave.periodic", "bundle"});
}

std::string error_of_drive(const std::string& drive) {
  return error_of(plain_cell({.more = "[[stage]]\nname = \"load\"\n[[stage.drive]]\n" + drive}));
}

TEST(PeriodicScenes, RefuseDrivesThatACellCannotMake) {
  EXPECT_EQ(error_of_drive("bodies = \"cell/weft\"\ndof = \"x\"\nstrain = 0.1"), "");
  EXPECT_EQ(error_of_drive("bodies = \"cell/weft\"\ndof = \"y\"\nforce_per_width = \"3 N/m\""), "");
  expect_mentions(error_of_drive("bodies = \"cell/warp\"\ndof = \"y\"\nstrain = 0.1"), {"cell/warp", "along x"});
  expect_mentions(error_of_drive("bodies = \"cell/*\"\ndof = \"z\"\ndisplacement = \"1 um\""), {"cell/warp", "plane"});
  expect_mentions(error_of_drive("bodies = \"cell/weft\"\ndof = \"rx\"\ndisplacement = \"1 deg\""), {"cell/weft"});
  expect_mentions(error_of_drive("bodies = \"cell/warp\"\ndof = \"x\"\nfollow = \"cell/weft\""), {"follow"});
  expect_mentions(error_of_drive("bodies = \"warp/1/end\"\ndof = \"x\"\nstrain = 0.1"), {"warp/1/end", "cell/warp"});
  expect_mentions(error_of(plain_cell({.more = "[test]\nkind = \"pull_out\"\nyarn = \"warp/1\"\ndistance = \"9 um\""})),
                  {"test.yarn", "ends"});
  expect_mentions(error_of(plain_cell({.periodic = "\"warp\"", .more = "[test]\nkind = \"shear\"\nstrain = 0.1"})),
                  {"test.kind", "periodic both ways"});
}

// The force per width is over what the yarns of the system take across.
TEST(PeriodicScenes, ForcePerWidthIsOverTheLaidOutCell) {
  const Scene scene =
      parse_scene(plain_cell({.warps = 4,
                              .more = "[[stage]]\nname = \"load\"\n[[stage.drive]]\nbodies = \"cell/warp\"\ndof = "
                                      "\"x\"\nforce_per_width = \"3 N/m\""}),
                  "cell.toml");
  EXPECT_DOUBLE_EQ(scene.stages.back().drives.front().value, 3 * 4 * 130e-6);
}

}  // namespace
}  // namespace trame::micro
