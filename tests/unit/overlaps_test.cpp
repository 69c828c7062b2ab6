#include "micro/weave/overlaps.h"

#include <gtest/gtest.h>

namespace trame::micro {
namespace {

/// Two strands of seven fibers side by side, their axes this far apart, and a fiber across above them.
Scene strands(double apart, double height) {
  Scene scene;
  scene.materials = {{"m", 1, 1, 0.4, 0.25, 0.25, 0}};
  scene.fiber_types = {{"f", 0, 1, FiberModel::rod}};
  for (const double y : {0.0, apart}) {
    BundleSpec& strand = scene.bundles.emplace_back();
    strand.name = std::string(1, y == 0 ? 'a' : 'b');
    strand.points = {{0, y, 0}, {100, y, 0}};
    strand.n_elements = 5;
    strand.n_fibers = 7;
  }
  FiberSpec& fiber = scene.fibers.emplace_back();
  fiber.name = "c";
  fiber.points = {{52, -50, height}, {52, 50, height}};
  fiber.n_elements = 4;
  return scene;
}

/// A hexagon with a side of 2.1, two of whose corners stand on y: fibers touch at 2 · 2.1 + 2, or nearer by rows.
constexpr double wide = 6.2, high = 2.1 * 0.8660254037844386 + 2;

TEST(Overlaps, AreNoneWhereNothingTouches) {
  EXPECT_FALSE(deepest_overlap(assemble_scene(strands(1.001 * wide, 1.001 * high))));
}

TEST(Overlaps, AreToldWithTheirDepthAndPlace) {
  const auto beside = deepest_overlap(assemble_scene(strands(wide - 0.4, 1.001 * high)));
  ASSERT_TRUE(beside);
  EXPECT_NEAR(beside->depth, 0.4, 1e-9);
  EXPECT_NEAR(beside->place.y(), wide / 2 - 0.2, 1e-9);
  const auto across = deepest_overlap(assemble_scene(strands(1.001 * wide, high - 0.7)));
  ASSERT_TRUE(across);
  EXPECT_NEAR(across->depth, 0.7, 1e-9);
  EXPECT_NEAR(across->place.x(), 52, 1e-9);
}

TEST(Overlaps, OfYarnsThatCrossAreMeant) {
  Scene scene;
  scene.materials = {{"m", 1, 1, 0.4, 0.25, 0.25, 0}};
  scene.fiber_types = {{"f", 0, 1, FiberModel::rod}};
  const YarnSystem yarns{{{.type = 0, .n_fibers = 3, .n_layers = 1}}, {0}, 2, 9, 14, 10};
  scene.weave = Weave{{{true, false}, {false, true}}, yarns, yarns};
  EXPECT_FALSE(deepest_overlap(assemble_scene(scene)));
  FiberSpec& fiber = scene.fibers.emplace_back();
  fiber.points = {{-20, 0, 0}, {20, 0, 0}};
  fiber.n_elements = 4;
  EXPECT_TRUE(deepest_overlap(assemble_scene(scene)));
}

}  // namespace
}  // namespace trame::micro
