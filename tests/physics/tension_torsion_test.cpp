/// \file
/// Uniform states of a single enriched fiber: tension, torsion, and the coupling of strong twist with stretch.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "micro/fiber/enriched_beam.h"
#include "micro/fiber/rod.h"
#include "tests/support/finite_differences.h"
#include "tests/support/run_scene.h"

namespace trame::micro {
namespace {

constexpr double area = std::numbers::pi, torsion_inertia = std::numbers::pi / 2;  // of radius 1

Stage loading(Index n_increments, std::vector<Drive> drives) {
  Stage stage;
  stage.name = "load";
  stage.n_increments = n_increments;
  stage.drives = std::move(drives);
  return stage;
}

TEST(Tension, AxialStiffness) {
  // St. Venant–Kirchhoff in tension: F = EA E_ss λ with E_ss = ½(λ² − 1), transverse stress zero. The clamps hold the
  // sections of both ends and so stiffen the outermost of 30 elements: by no more than 1/(1 − 2ν²/(1 − ν)) = 2 in each.
  const double stretch = 1.02, strain = 0.5 * (stretch * stretch - 1), force = area * strain * stretch;
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    Scene scene = test::cantilever(model, 0.39, 300, 30);
    scene.stages = {loading(2, {{"tip", BodyDof::x, DriveMode::force, force, ""}})};
    const auto result = test::run_scene(scene);
    ASSERT_TRUE(result.done()) << result.summary.message;
    const Index middle = result.last_node(0) / 2;
    EXPECT_NEAR(result.last().fibers.tangent[middle].norm(), stretch, 1e-5);
    EXPECT_NEAR(result.tip().x() / 300, stretch, (stretch - 1) / 30);
    EXPECT_NEAR(result.last().bodies.force[0].x(), -force, 1e-6 * force);
  }
}

TEST(Tension, ClampsLeaveTheStretchOfARodFree) {
  // Uniform to the ends, whatever the number of elements: F = EA E_ss λ, with λ between the ends of the fiber itself
  // (ties give way by 10⁻³ of an element's stretch).
  for (const TieKind kind : {TieKind::clamped, TieKind::average})
    for (const Index n_elements : {1, 2, 5, 13}) {
      Scene scene = test::cantilever(FiberModel::rod, 0.3, 40, n_elements);
      for (BodySpec& body : scene.bodies) body.ties[0].kind = kind;
      scene.stages = {loading(1, {{"tip", BodyDof::x, DriveMode::displacement, 0.4, ""}})};
      const auto result = test::run_scene(scene);
      ASSERT_TRUE(result.done()) << result.summary.message;
      const std::vector<Vec3>& r = result.last().fibers.r;
      const double stretch = (r[result.last_node(0)] - r[0]).norm() / 40, strain = 0.5 * (stretch * stretch - 1);
      EXPECT_NEAR(result.last().bodies.force[1].x() / (area * strain * stretch), 1, 1e-6) << n_elements;
      for (const Vec3& tangent : result.last().fibers.tangent) EXPECT_NEAR(tangent.norm(), stretch, 1e-7);
    }
}

TEST(Tension, PoissonContraction) {
  // |g|² = 1 − 2νE_ss, isotropic and transversely isotropic alike (ν_LT). One homogeneous state, no clamps: no force.
  const Material carbon{"carbon", 1, 0.065, 0.12, 0.25, 0.4};
  for (const Material& material : {test::isotropic(1, 0.39), carbon}) {
    Scene scene = test::cantilever(FiberModel::enriched, 0.3, 40, 4);
    scene.bodies.clear();
    const Assembly assembly = assemble_scene(scene);
    Layout layout;
    const FiberField field(assembly.mesh, {FiberModel::enriched}, layout);
    State state;
    state.q.assign(layout.n_vectors(), Vec3::Zero());
    field.read_configuration(assembly.configuration, state);
    const double stretch = 1.03, strain = 0.5 * (stretch * stretch - 1);
    const double contraction = std::sqrt(1 - 2 * material.poisson_ratio_axial * strain);
    for (Index n = 0; n < layout.n_nodes(); ++n) {
      state.q[layout.first_vector(n)] *= stretch;
      for (int v : {1, 2}) state.q[layout.first_vector(n) + v] *= contraction;
    }
    const EnrichedBeams beams(field, {material}, assembly.configuration, false);
    const auto force = test::assemble(beams, layout, state).force;
    const double pull = area * strain * stretch;
    for (Index n = 0; n < layout.n_nodes(); ++n)
      for (int v = 0; v < 3; ++v) {
        const double axial = v > 0 ? 0 : n == 0 ? -pull : n == layout.n_nodes() - 1 ? pull : 0;
        EXPECT_LT((force.segment<3>(layout.first_dof(n) + 3 * v) - Vec3(axial, 0, 0)).norm(), 1e-12) << n << " " << v;
      }
    EXPECT_NEAR(beams.energy(state), 0.5 * area * strain * strain * 40, 1e-12);
  }
}

/// Uniform twist K of a fiber of radius 1 and modulus 1 whose axial end is free; sections keep round with stretch α.
/// W = A/2 E:C:E + GJ/2 α⁴K², E_ss = ½(λ² − 1) + c α²K²/4, and with the coupling EA α⁴K⁴/96 of the deviation from that
/// mean; c = 1 with it, 2ν/(1 + ν) without. No axial stress and ∂W/∂α = 0 give, with q = (GJ K² + EA K⁴/48)/EA,
///   α² = 1/(1 + 2(1 − ν) q),   λ² = 1 + 4ν q α² − c K²α²/2,   M = α⁴ (GJ K + EA K³/24),
/// the K³ and K⁴ being those of the coupling. Without it λ = 1: 4ν GJ/EA = c/2.
struct UniformTwist {
  double stretch, moment;
};
UniformTwist uniform_twist(double k, double nu, bool twist_stretch) {
  const double gj = torsion_inertia / (2 * (1 + nu)), on = twist_stretch ? 1 : 0,
               share = twist_stretch ? 1 : 2 * nu / (1 + nu);
  const double q = gj * k * k / area + on * std::pow(k, 4) / 48, alpha_squared = 1 / (1 + 2 * (1 - nu) * q);
  return {std::sqrt(1 + 4 * nu * q * alpha_squared - share * k * k * alpha_squared / 2),
          alpha_squared * alpha_squared * (gj * k + on * area * k * k * k / 24)};
}

TEST(Torsion, TwistUnderAnEndMoment) {
  // φ = M L / (G J), J = 2I. At 1/20 rad an element interpolates the turn of sections to (1/20)⁴.
  const double nu = 0.3, shear_modulus = 1 / (2 * (1 + nu)), length = 100, angle = 1;
  Scene scene = test::cantilever(FiberModel::enriched, nu, length, 20);
  scene.stages = {
      loading(5, {{"tip", BodyDof::rx, DriveMode::force, shear_modulus * torsion_inertia * angle / length, ""},
                  {"tip", BodyDof::x, DriveMode::force, 0, ""}})};
  const auto result = test::run_scene(scene);
  ASSERT_TRUE(result.done()) << result.summary.message;
  // Sections turn; ties (10³ EA/h) add h/L · GJ/EA/10³ at either end, 1e-5.
  const FiberConfiguration& c = result.last().fibers;
  const Vec3 g = c.g1[result.last_node(0)], start = result.increments[0].fibers.g1[result.last_node(0)];
  EXPECT_NEAR(std::atan2(start.cross(g).x(), start.dot(g)), angle, 1e-4);
  const Vec3 half = c.g1[result.last_node(0) / 2];
  EXPECT_NEAR(std::atan2(start.cross(half).x(), start.dot(half)), 0.5 * angle, 1e-4);
  EXPECT_NEAR(result.tip().x() / length, uniform_twist(angle / length, nu, true).stretch, 1e-6);
}

TEST(Torsion, AxialForceOfAFiberTwistedAtHeldLength) {
  // A cylinder of St. Venant–Kirchhoff's law, to second order in the twist K: the outer layers are stretched by K²ρ²/2,
  // on average E A K²/4 R², and torsion narrows the section by 2ν GJ/EA K² in the length: N = E I K² (1 − ν)/(1 + ν).
  // Without the coupling there is none of both.
  const double length = 100, angle = std::numbers::pi, k = angle / length;
  for (const double nu : {-0.3, 0.0, 0.3, 0.45})
    for (const bool twist_stretch : {true, false}) {
      Scene scene = test::cantilever(FiberModel::enriched, nu, length, 40);
      scene.twist_stretch = twist_stretch;
      scene.stages = {loading(4, {{"tip", BodyDof::rx, DriveMode::displacement, angle, ""}})};
      const auto result = test::run_scene(scene);
      ASSERT_TRUE(result.done()) << result.summary.message;
      const double unit = 0.25 * area * k * k, force = result.last().bodies.force[1].x();
      // Clamps hold the outermost sections round: 2 of 40 elements lack up to all of the second part. Fourth order: K².
      EXPECT_NEAR(force / unit, twist_stretch ? (1 - nu) / (1 + nu) : 0, 0.05 * std::abs(2 * nu / (1 + nu)) + 2e-3)
          << "nu " << nu << ", coupling " << twist_stretch;
    }
}

TEST(Torsion, TheCouplingIsWhatAFiberHasWithoutAWord) { EXPECT_TRUE(Scene().twist_stretch); }

TEST(Torsion, StrongTwistShortensAFreeFiber) {
  const double nu = 0.3, length = 30, twist = 0.2;
  for (const bool twist_stretch : {false, true}) {
    Scene scene = test::cantilever(FiberModel::enriched, nu, length, 30);
    scene.twist_stretch = twist_stretch;
    scene.stages = {loading(30, {{"tip", BodyDof::rx, DriveMode::displacement, twist * length, ""},
                                 {"tip", BodyDof::x, DriveMode::force, 0, ""}})};
    const auto result = test::run_scene(scene);
    ASSERT_TRUE(result.done()) << result.summary.message;
    const UniformTwist expected = uniform_twist(twist, nu, twist_stretch);
    // The clamps keep the outermost two of 30 sections at α = 1, which α² − 1 = 1 % feels by 1/15 of itself at most; an
    // element interpolates the turn of Kh = 0.2 to (Kh)⁴ = 2e-3.
    EXPECT_NEAR(result.tip().x() / length - 1, expected.stretch - 1, 2e-3 * std::abs(expected.stretch - 1) + 1e-4);
    EXPECT_NEAR(result.last().bodies.moment[1].x() / expected.moment, 1, 3e-3);
    EXPECT_NEAR(result.last().bodies.moment[0].x() / expected.moment, -1, 3e-3);
    EXPECT_EQ(result.tip().x() < (1 - 1e-3) * length, twist_stretch);
  }
}

}  // namespace
}  // namespace trame::micro
