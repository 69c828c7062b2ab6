/// \file
/// A cell between two plates that close in and open again.

#include <fmt/format.h>

#include "tests/periodic/periodic_fixture.h"
#include "tests/periodic/plain_cell.h"

namespace trame::micro {
namespace {

using test::run_scene;
using test::RunResult;

// What no edge carries, plates bear against each other; the thinner, the more.
TEST(CellCompaction, PlatesBearAgainstEachOther) {
  const std::string text = test::plain_cell(
      {.of_warp = "", .more = "[test]\nkind = \"compaction\"\nstrain = \"6 %\"\nincrements = 8\ncycles = 1\n"});
  Scene scene = parse_scene(text, "s.toml");
  for (FiberType& type : scene.fiber_types) type.model = FiberModel::rod;
  const RunResult result = run_scene(scene, 2);
  ASSERT_TRUE(result.done()) << result.summary.message;
  const auto body = [&](const std::string& name) {
    const auto& names = result.header.body_names;
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  const std::size_t upper = body("plate/upper"), lower = body("plate/lower");
  double last_height = 0, last_force = 0, most = 0, begins_at = 0;
  for (const Increment& i : result.increments) {
    if (i.stage != "compaction") continue;
    const double height = i.bodies.position[upper].z() - i.bodies.position[lower].z(),
                 force = -i.bodies.force[upper].z();
    EXPECT_NEAR(i.bodies.force[lower].z(), force, 1e-4 * force + 1e-9);
    EXPECT_GE(force, 0);
    if (last_height == 0) begins_at = height / (1 - 0.06 * i.stage_time * 2);
    if (height < last_height) {
      EXPECT_GT(force, last_force);
    }
    last_height = height;
    last_force = force;
    most = std::max(most, force);
  }
  EXPECT_NEAR(last_height / begins_at, 1, 1e-9) << "back where it was";
  EXPECT_LT(last_force, 0.01 * most);
  EXPECT_LT(result.last().solver.max_penetration_over_radius, 0.005);
  const EnergyRecord& energy = result.last().solver.energy;
  EXPECT_GT(energy.friction, 0);
  EXPECT_LT(std::abs(energy.imbalance), 0.005 * energy.external_work);
}

}  // namespace
}  // namespace trame::micro
