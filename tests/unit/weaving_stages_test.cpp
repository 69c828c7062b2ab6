// Weaves that name no stages get them.

#include "micro/scene/weaving_stages.h"

#include <gtest/gtest.h>

namespace trame::micro {
namespace {

/// A whole scene.
const std::string short_scene = R"(title = "Plain weave of nylon monofilaments"
[material.nylon]
model = "isotropic"
young_modulus = "3 GPa"
poisson_ratio = 0.39
density = "1.14 g/cm3"
[fiber_type.filament]
material = "nylon"
diameter = "20 um"
[weave]
pattern = "plain"
[weave.warp]
fiber_type = "filament"
yarns = 4
fibers = 24
layers = 3
sett = "35 per cm"
[weave.weft]
fiber_type = "filament"
yarns = 4
fibers = 1
sett = "60 per cm"
)";

Scene read(std::string text, const std::string& what = "", const std::string& by = "") {
  if (!what.empty()) text.replace(text.find(what), what.size(), by);
  return parse_scene(text, "short.toml");
}

TEST(WeavingStages, AreChosenWhereThereAreNone) {
  const Scene scene = read(short_scene);
  EXPECT_TRUE(scene.stages_are_chosen);
  ASSERT_EQ(scene.stages.size(), 3u);
  const Stage &separate = scene.stages[0], &relax = scene.stages[1], &settle = scene.stages[2];
  EXPECT_TRUE(separate.separate_yarns);
  EXPECT_FALSE(separate.friction);
  // Half of 1 + 1.05 √3 diameters and of one, and a diameter, by thirds of a radius.
  EXPECT_EQ(separate.n_increments, 18);
  EXPECT_EQ(separate.fiber_model, FiberModel::rod);
  EXPECT_EQ(separate.proximal_end, 1e-2);
  EXPECT_EQ(relax.fiber_model, FiberModel::rod);
  EXPECT_TRUE(relax.friction);
  EXPECT_EQ(relax.proximal_end, 0);
  EXPECT_FALSE(settle.fiber_model);
  ASSERT_EQ(separate.drives.size(), 4u);
  EXPECT_NEAR(separate.drives[1].value, 1.1e-3, 1e-12);  // 5·10⁻⁵ · 24 · 3 GPa · 314 µm²
  EXPECT_NEAR(separate.drives[3].value, 4.7e-5, 1e-12);
  EXPECT_NEAR(relax.drives[1].value, 1.1e-4, 1e-12);
  EXPECT_EQ(separate.drives[0].value, -separate.drives[1].value);
}

TEST(WeavingStages, GoByTheScaleOfTheFabricOnly) {
  const Scene scene = read(short_scene);
  std::string text = short_scene;
  for (const auto& [what, by] : {std::pair{"20 um", "20 mm"}, {"35 per cm", "3.5 per m"}, {"60 per cm", "6 per m"}})
    text.replace(text.find(what), std::string(what).size(), by);
  const Scene large = read(text);
  EXPECT_EQ(large.stages[0].n_increments, scene.stages[0].n_increments);
  EXPECT_NEAR(large.stages[0].drives[1].value / scene.stages[0].drives[1].value, 1e6, 1);
}

TEST(WeavingStages, AreNotAddedToThoseThatThereAre) {
  const Scene own = read(short_scene + "[[stage]]\nname = \"mine\"\nseparate_yarns = true\n");
  EXPECT_FALSE(own.stages_are_chosen);
  EXPECT_EQ(own.stages.size(), 1u);
}

TEST(WeavingStages, NeedContactAndKnowFriction) {
  EXPECT_TRUE(read(short_scene + "[effects]\ncontact = \"none\"\n").stages.empty());
  EXPECT_FALSE(read(short_scene + "[effects]\nfriction = false\n").stages[1].friction);
}

}  // namespace
}  // namespace trame::micro
