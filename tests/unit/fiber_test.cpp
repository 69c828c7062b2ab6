/// \file
/// Fibers as curves: shape functions, points on them, configurations in and out.

#include <gtest/gtest.h>

#include <cmath>

#include "micro/fiber/fiber_field.h"
#include "tests/support/finite_differences.h"

namespace trame::micro {
namespace {

using test::TwoFibers;

TEST(ShapeFunctions, Quadratic) {
  for (const double t : {-1.0, -0.3, 0.0, 0.7, 1.0}) {
    const auto n = quadratic_shape(t), d = quadratic_shape_derivative(t);
    // They reproduce 1, t and t² from the values at −1, 0, 1.
    EXPECT_NEAR(n[0] + n[1] + n[2], 1, 1e-15);
    EXPECT_NEAR(n[2] - n[0], t, 1e-15);
    EXPECT_NEAR(n[0] + n[2], t * t, 1e-15);
    EXPECT_NEAR(d[0] + d[1] + d[2], 0, 1e-15);
    EXPECT_NEAR(d[2] - d[0], 1, 1e-15);
    EXPECT_NEAR(d[0] + d[2], 2 * t, 1e-15);
  }
}

TEST(ShapeFunctions, HermiteReproducesCubics) {
  const double h = 3;
  const auto cubic = [](double s) { return 2 - s + 0.5 * s * s - 0.25 * s * s * s; };
  const auto slope = [](double s) { return -1 + s - 0.75 * s * s; };
  const auto curvature = [](double s) { return 1 - 1.5 * s; };
  const std::array<double, 4> dofs = {cubic(0), slope(0), cubic(h), slope(h)};
  const auto combine = [&](const std::array<double, 4>& c) {
    return c[0] * dofs[0] + c[1] * dofs[1] + c[2] * dofs[2] + c[3] * dofs[3];
  };
  for (const double t : {-1.0, -0.4, 0.1, 1.0}) {
    const double s = 0.5 * h * (t + 1);
    EXPECT_NEAR(combine(hermite_shape(t, h)), cubic(s), 1e-14);
    EXPECT_NEAR(combine(hermite_shape_derivative(t, h)), slope(s), 1e-14);
    EXPECT_NEAR(combine(hermite_shape_second_derivative(t, h)), curvature(s), 1e-14);
  }
}

TEST(FiberField, NodesOfBothModels) {
  const TwoFibers enriched(FiberModel::enriched), rod(FiberModel::rod);
  // Two bodies of two vectors, then two fibers of two elements.
  EXPECT_EQ(enriched.layout.n_dofs(), 2 * 6 + 2 * 5 * 9);
  EXPECT_EQ(rod.layout.n_dofs(), 2 * 6 + 2 * 3 * 6);
  EXPECT_EQ(enriched.field.element_node(1, 0), 2 + 5);
  EXPECT_EQ(enriched.field.element_node(1, 1), 2 + 5 + 2);
  EXPECT_EQ(rod.field.element_node(1, 1), 2 + 3 + 1);
  EXPECT_EQ(rod.field.last_node(0), 2 + 2);
}

TEST(FiberField, CurveTangentIsItsDerivative) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    const TwoFibers f(model);
    const double length = f.assembly.mesh.length(1), h = 1e-6;
    // Of both kinds of stretches of an enriched beam: at ends and between.
    for (const double s : {-0.1, 0.1, 0.3 * length, 0.51 * length, length - 0.1, length + 0.1}) {
      const CurveJet before = f.field.curve(f.state, 1, s - h), after = f.field.curve(f.state, 1, s + h),
                     at = f.field.curve(f.state, 1, s);
      EXPECT_LT((at.tangent - (after.r - before.r) / (2 * h)).norm(), 1e-8) << s;
      EXPECT_LT((at.curvature - (after.tangent - before.tangent) / (2 * h)).norm(), 1e-8) << s;
    }
    // Continuous from element to element, with its tangent.
    for (const double part : {0.25, 0.5, 0.75}) {
      const auto before = f.field.curve(f.state, 0, part * f.assembly.mesh.length(0) - 1e-9);
      const auto after = f.field.curve(f.state, 0, part * f.assembly.mesh.length(0) + 1e-9);
      EXPECT_LT((after.r - before.r).norm(), 1e-8);
      EXPECT_LT((after.tangent - before.tangent).norm(), 1e-7);
    }
  }
}

TEST(FiberField, CurvesRunThroughNodesAndReproduceParabolas) {
  TwoFibers f(FiberModel::enriched);
  const FiberMesh& mesh = f.assembly.mesh;
  const auto parabola = [](double s) { return Vec3(1 + 2 * s, 0.3 * s * s, 1 - 0.1 * s - 0.2 * s * s); };
  for (Index i = mesh.first_node[1]; i < mesh.first_node[2]; ++i) {
    const Index vector = f.layout.first_vector(f.field.element_node(1, 0) + i - mesh.first_node[1]);
    EXPECT_LT((f.field.curve(f.state, 1, mesh.arc_length[i]).r - f.state.q[vector]).norm(), 1e-14);
    f.state.q[vector] = parabola(mesh.arc_length[i]);
  }
  for (double s = 0; s < mesh.length(1); s += 0.21) {
    EXPECT_LT((f.field.curve(f.state, 1, s).r - parabola(s)).norm(), 1e-12) << s;
    EXPECT_LT((f.field.curve(f.state, 1, s).curvature - Vec3(0, 0.6, -0.4)).norm(), 1e-12) << s;
  }
}

TEST(FiberField, ParticlesAreLinearFormsOfTheUnknowns) {
  const TwoFibers enriched(FiberModel::enriched), rod(FiberModel::rod);
  const double s = 3.3;
  const Vec2 xi(0.6, -0.8);
  const CurveShape shape = enriched.field.shape(0, s);
  const auto [g1, g2] = enriched.field.section(enriched.state, shape);
  const Vec3 expected = enriched.field.curve(enriched.state, 0, s).r + xi[0] * g1 + xi[1] * g2;
  EXPECT_LT((enriched.field.particle(0, s, xi).evaluate(enriched.layout, enriched.state) - expected).norm(), 1e-14);
  EXPECT_LT((rod.field.particle(0, s, xi).evaluate(rod.layout, rod.state) - rod.field.curve(rod.state, 0, s).r).norm(),
            1e-14);
}

TEST(FiberField, ConfigurationsGoOutAndIn) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    const TwoFibers f(model);
    const State changed = test::perturbed(f.layout, f.state, 0.05, 3);
    FiberConfiguration configuration = f.configuration;
    f.field.write_configuration(changed, configuration);
    State again = f.state;
    f.field.read_configuration(configuration, again);
    for (Index v = f.layout.first_vector(2); v < f.layout.n_vectors(); ++v)
      EXPECT_LT((again.q[v] - changed.q[v]).norm(), 1e-13) << "vector " << v;
  }
}

TEST(FiberField, SectionsOfRodsAreCarriedAlong) {
  const TwoFibers f(FiberModel::rod);
  FiberConfiguration configuration = f.configuration;
  f.field.write_configuration(test::perturbed(f.layout, f.state, 0.1, 5), configuration);
  for (Index i = 0; i < f.assembly.mesh.n_nodes(); ++i) {
    const Vec3 t = configuration.tangent[i].normalized();
    EXPECT_NEAR(configuration.g1[i].norm(), 1, 1e-12);
    EXPECT_NEAR(configuration.g1[i].dot(t), 0, 1e-12);
    EXPECT_LT((configuration.g2[i] - t.cross(configuration.g1[i])).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace trame::micro
