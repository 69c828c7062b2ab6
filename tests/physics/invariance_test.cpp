/// \file
/// What must not change the result of a woven patch: the number of threads and the units of the scene.

#include <gtest/gtest.h>

#include "tests/support/run_scene.h"

namespace trame::micro {
namespace {

/// Two warp and two weft yarns of four fibers, plain weave, through separation and relaxation. `length` and `stress`
/// are the units of the scene: fiber radius 10 lengths, modulus 3·10⁹ stresses.
Scene small_patch(double length, double stress) {
  const double modulus = 3e9 * stress, radius = 1e-5 * length, force = 1e-3 * stress * length * length;
  Scene scene;
  scene.name = "small patch";
  scene.materials = {test::isotropic(modulus, 0.39)};
  scene.fiber_types = {{"f", 0, radius, FiberModel::enriched}};
  const YarnSystem yarns{
      {{.type = 0, .n_fibers = 4, .n_layers = 2, .lattice_spacing = 1.05}}, {0}, 2, 8, 12 * radius, 9 * radius};
  scene.weave = Weave{{{false, true}, {true, false}}, yarns, yarns};
  const auto pull = [&](double by) {
    std::vector<Drive> drives;
    for (const auto& [end, sign] : {std::pair{"start", -1.0}, std::pair{"end", 1.0}}) {
      drives.push_back({std::string("warp/*/") + end, BodyDof::x, DriveMode::force, sign * by, ""});
      drives.push_back({std::string("weft/*/") + end, BodyDof::y, DriveMode::force, sign * by, ""});
    }
    return drives;
  };
  Stage separate;
  separate.name = "separate";
  separate.n_increments = 6;
  separate.drives = pull(force);
  separate.separate_yarns = true;
  separate.friction = false;
  separate.proximal_start = separate.proximal_end = 1e-3;
  separate.fiber_model = FiberModel::rod;
  Stage relax = separate;
  relax.name = "relax";
  relax.n_increments = 4;
  relax.separate_yarns = false;
  relax.friction = true;
  relax.proximal_end = relax.proximal_start;  // without it loose fibers drift, and enlarge the last digit at will
  relax.drives = pull(0.1 * force);
  scene.stages = {separate, relax};
  scene.solver.geometry_tolerance = 1e-2;
  scene.solver.max_geometry_updates = 10;
  return scene;
}

double largest_difference(const std::vector<Vec3>& a, double unit_a, const std::vector<Vec3>& b, double unit_b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] / unit_a - b[i] / unit_b).norm());
  return largest;
}

TEST(Invariance, OfTheNumberOfThreads) {
  const Scene scene = small_patch(1, 1);
  const auto one = test::run_scene(scene, 1), two = test::run_scene(scene, 2);
  ASSERT_TRUE(one.done()) << one.summary.message;
  ASSERT_TRUE(two.done()) << two.summary.message;
  EXPECT_TRUE(one.summary.crossing_order_ok);
  EXPECT_EQ(one.summary.n_newton_iterations, two.summary.n_newton_iterations);
  ASSERT_EQ(one.increments.size(), two.increments.size());
  const double radius = scene.fiber_types[0].radius;
  for (std::size_t i = 0; i < one.increments.size(); ++i) {
    EXPECT_LT(largest_difference(one.increments[i].fibers.r, radius, two.increments[i].fibers.r, radius), 1e-9) << i;
    EXPECT_LT(largest_difference(one.increments[i].fibers.g1, 1, two.increments[i].fibers.g1, 1), 1e-9) << i;
    const auto &f = one.increments[i].contacts.normal_force, &g = two.increments[i].contacts.normal_force;
    ASSERT_EQ(f.size(), g.size()) << i;
    const double unit = scene.materials[0].young_modulus_axial * radius * radius;
    for (std::size_t c = 0; c < f.size(); ++c) EXPECT_NEAR(f[c] / unit, g[c] / unit, 1e-9) << i;
  }
}

// Known to fail: equal to 1e-7 only, as Newton ends at a residual of 1e-6.
TEST(InvarianceStudy, OfTheUnits) {
  // Micrometres and MPa. Scaling is not exact in binary, contacts that come and go enlarge the last digit, and where it
  // decides about an iteration of the linear solver the result changes by what the tolerance allows.
  const double length = 1e6, stress = 1e-6;
  const auto run = [](double length_unit, double stress_unit) {
    Scene scene = small_patch(length_unit, stress_unit);
    scene.solver.force_tolerance = 1e-10;
    return test::run_scene(scene);
  };
  const auto metres = run(1, 1), micrometres = run(length, stress);
  ASSERT_TRUE(metres.done()) << metres.summary.message;
  ASSERT_TRUE(micrometres.done()) << micrometres.summary.message;
  ASSERT_EQ(metres.increments.size(), micrometres.increments.size());
  const double radius = 1e-5;
  for (std::size_t i = 0; i < metres.increments.size(); ++i)
    EXPECT_LT(
        largest_difference(metres.increments[i].fibers.r, radius, micrometres.increments[i].fibers.r, radius * length),
        1e-8)
        << i;
  const double force = stress * length * length;
  const EnergyRecord &e = metres.summary.energy, &f = micrometres.summary.energy;
  ASSERT_GT(e.stored, 0);
  EXPECT_NEAR(f.stored / (force * length) / e.stored, 1, 1e-8);
  EXPECT_NEAR(f.external_work / (force * length) / e.external_work, 1, 1e-8);
}

}  // namespace
}  // namespace trame::micro
