/// \file
/// Weaves of several layers of weft: what levels mean, where yarns start, what is refused, a run.

#include <filesystem>

#include "micro/scene/pattern.h"
#include "micro/scene/yarn_section.h"
#include "micro/weave/flat_start.h"
#include "tests/periodic/plain_cell.h"
#include "tests/support/messages.h"
#include "tests/support/run_scene.h"

namespace trame::micro {
namespace {

using test::CellText;
using test::plain_cell;
using trame::test::expect_mentions;
using trame::test::input_error;

/// Two binders with a stuffer after each, through two layers.
const std::string orthogonal = "weft_layers = 2\nlevels = [[0, 2], [1, 1], [2, 0], [1, 1]]";

Scene layered(const CellText& cell) { return parse_scene(plain_cell(cell), "layers.toml"); }

std::string error_of(const CellText& cell) {
  return input_error([&] { (void)layered(cell); });
}

TEST(Layers, WarpsAreAboveAsManyAsTheirLevel) {
  const WeavePattern pattern = layered_pattern({{0, 2}, {1, 1}}, 2);
  const WeavePattern expected = {{false, true}, {false, false}, {true, true}, {true, false}};
  EXPECT_EQ(pattern, expected);
}

// A column is as wide as a yarn of one layer; what is above starts higher, a warp fits between, and warps start at
// their mean level.
TEST(Layers, StartAboveEachOther) {
  const Scene scene = layered({.warps = 4, .wefts = 4, .fibers = 1, .pattern = orthogonal});
  const Assembly assembly = assemble_scene(scene);
  EXPECT_LT((assembly.body_positions[0] - Vec3(260e-6, 0, 0)).norm(), 1e-15);
  EXPECT_LT((assembly.body_positions[1] - Vec3(0, 520e-6, 0)).norm(), 1e-15);
  const auto start = [&](Index fiber) { return assembly.configuration.r[assembly.mesh.first_node[fiber]]; };
  for (Index warp = 0; warp < 4; ++warp) EXPECT_NEAR(start(warp).z(), 0, 1e-15);
  const Vec3 up = start(5) - start(4), on = start(6) - start(4);
  EXPECT_LT((up - Vec3(0, 0, 40e-6)).norm(), 1e-15);
  EXPECT_LT((on - Vec3(130e-6, 0, 0)).norm(), 1e-15);
  // A binder has to pass a weft whose axis is 20 µm farther on, and the heights of both.
  EXPECT_NEAR(assembly.flat_height, 40e-6, 1e-15);
  const Scene below = layered({.warps = 1, .wefts = 4, .fibers = 1, .pattern = "weft_layers = 2\nlevels = [[0]]"});
  EXPECT_NEAR(start_heights(below).warp[0], -40e-6, 1e-15);
  EXPECT_NEAR(start_heights(below).deepest, 0, 1e-15);
}

TEST(Layers, RefuseWhatDoesNotFitTogether) {
  expect_mentions(error_of({.warps = 4, .wefts = 3, .pattern = orthogonal}),
                  {"weave.weft.yarns", "3", "multiple of 2"});
  expect_mentions(error_of({.warps = 4, .wefts = 6, .pattern = orthogonal}),
                  {"weave.weft.yarns", "6", "multiple of 4"});
  expect_mentions(error_of({.warps = 3, .wefts = 4, .pattern = orthogonal}),
                  {"weave.warp.yarns", "3", "multiple of 4"});
  expect_mentions(error_of({.pattern = "pattern = \"plain\"\nweft_layers = 2"}), {"weave.weft_layers", "levels"});
  expect_mentions(error_of({.pattern = "weft_layers = 2\nlevels = [[0, 3], [1, 1]]"}),
                  {"weave.levels[1][2]", "3", "at most 2"});
  expect_mentions(error_of({.pattern = "weft_layers = 2\nlevels = [[0, 2], [1]]"}), {"weave.levels[2]", "as long as"});
  expect_mentions(error_of({.pattern = "weft_layers = 2\nlevels = [0, 2]"}), {"weave.levels", "list"});
  expect_mentions(error_of({.pattern = orthogonal + "\npattern = \"plain\""}), {"weave", "exactly one of", "levels"});
}

// Binders go round both layers, stuffers between them: what is ordered is so, and what is not held by any order stays
// apart by contact.
TEST(Layers, AreWoven) {
  const test::RunResult result =
      test::run_scene(read_scene(std::filesystem::path(TRAME_DATA_DIR) / "fabrics/orthogonal.toml"));
  ASSERT_TRUE(result.done()) << result.summary.message;
  EXPECT_EQ(result.summary.n_crossings, 16);
  EXPECT_EQ(result.summary.n_crossings_ok, 16);
  EXPECT_LT(result.summary.max_penetration_over_radius, 0.05);
}

}  // namespace
}  // namespace trame::micro
