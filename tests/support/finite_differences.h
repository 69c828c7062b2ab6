#pragma once
/// \file
/// The finite-difference harness that every effect passes through, and a small scene to pass with.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "micro/fiber/fiber_field.h"
#include "micro/rigid/rigid_body.h"
#include "micro/solve/effect.h"
#include "micro/weave/flat_start.h"

namespace trame::micro::test {

/// Two bodies and two slightly curved fibers of radius 1, touching side by side or crossed.
struct TwoFibers {
  enum class Arrangement { side_by_side, crossed };

  explicit TwoFibers(FiberModel model, Arrangement arrangement = Arrangement::side_by_side)
      : assembly(make_assembly(model, arrangement)), bodies(2, layout), field(assembly.mesh, {model, model}, layout),
        configuration(assembly.configuration) {
    state.q.assign(layout.n_vectors(), Vec3::Zero());
    state.rotations.assign(2, Mat3::Identity());
    field.read_configuration(configuration, state);
    bodies.set_pose(state, 0, {Vec3(0.3, -0.2, 0.1), rotation_matrix({0.2, 0.5, -0.3})});
    bodies.set_pose(state, 1, {Vec3(9, 0.1, 0.4), rotation_matrix({-0.1, 0.3, 0.8})});
  }

  static Assembly make_assembly(FiberModel model, Arrangement arrangement) {
    Scene scene;
    scene.materials = {{"m", 1, 1, 0.4, 0.25, 0.25}};
    scene.fiber_types = {{"f", 0, 1.0, model}};
    const bool crossed = arrangement == Arrangement::crossed;
    scene.fibers = {{"a", 0, {{0, 0, 0}, {5, 0.4, 0.2}, {10, 0.1, 0}}, 2, {}},
                    crossed ? FiberSpec{"b", 0, {{5, -5, -1.6}, {5, 5, -1.5}}, 2, {}}
                            : FiberSpec{"b", 0, {{0, 0.1, 1.93}, {5, 0.3, 2.2}, {10, 0.3, 1.95}}, 2, {}}};
    return assemble_scene(scene);
  }

  Assembly assembly;
  Layout layout;
  RigidBodies bodies;
  FiberField field;
  FiberConfiguration configuration;
  State state;
};

inline std::vector<double> random_step(const Layout& layout, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<double> step(layout.n_dofs());
  for (double& s : step) s = uniform(generator);
  return step;
}

inline State perturbed(const Layout& layout, const State& state, double amplitude, std::uint32_t seed) {
  State result;
  retract(layout, state, random_step(layout, seed), amplitude, result);
  return result;
}

struct Assembled {
  Eigen::VectorXd force;
  Eigen::MatrixXd tangent;
};

/// The symmetric matrix whose lower triangle is stored.
inline Eigen::MatrixXd dense(const Layout& layout, const Pattern& pattern, const std::vector<double>& values) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(layout.n_dofs(), layout.n_dofs());
  for (Index j = 0; j < layout.n_nodes(); ++j)
    for (Index c = 0; c < 3 * layout.n_vectors(j); ++c)
      for (const Index i : pattern.rows(j))
        for (Index r = 0; r < 3 * layout.n_vectors(i); ++r) {
          const Index row = layout.first_dof(i) + r, column = layout.first_dof(j) + c;
          if (row < column) continue;
          matrix(row, column) = matrix(column, row) =
              values[pattern.value_start(j) + static_cast<std::size_t>(c) * pattern.column_height(j) +
                     pattern.row_offset(i, j) + r];
        }
  return matrix;
}

/// Gradient and dense symmetric tangent of one effect, both at expected stresses where there is a last step.
inline Assembled assemble(const Effect& effect, const Layout& layout, const State& state,
                          Assembler::Tangent kind = Assembler::Tangent::exact, const Vec3* last_step = nullptr) {
  Pattern::Builder builder;
  effect.add_sparsity(builder);
  const Pattern pattern(layout, builder);
  std::vector<double> values(pattern.n_values(), 0.0), force(layout.n_dofs(), 0.0), magnitude(layout.n_vectors(), 0.0);
  Assembler assembler(layout, &pattern, 0, layout.n_nodes(), force.data(), magnitude.data(), values.data(), kind);
  assembler.set_last_step(last_step, Assembler::Stress::expected);
  effect.add(state, assembler);
  return {Eigen::Map<Eigen::VectorXd>(force.data(), layout.n_dofs()), dense(layout, pattern, values)};
}

/// Along random directions v: E(q ⊕ hv) has slope f·v and curvature v·K v, both against central differences whose error
/// falls with h². `left_out`: what an effect's force and tangent leave out of these, relative to their size.
struct LeftOut {
  double of_force = 0, of_tangent = 0;
};
inline void expect_consistent_derivatives(Effect& effect, const Layout& layout, const State& state,
                                          const LeftOut& left_out = {}) {
  (void)effect.follow(state, Effect::Follow::renewal, everywhere);
  const Assembled exact = assemble(effect, layout, state);
  ASSERT_GT(exact.force.norm() + exact.tangent.norm(), 0) << "the effect does nothing here";
  for (std::uint32_t seed = 100; seed < 106; ++seed) {
    const std::vector<double> step = random_step(layout, seed);
    const Eigen::Map<const Eigen::VectorXd> v(step.data(), layout.n_dofs());
    const auto shifted = [&](double h) {
      State s;
      retract(layout, state, step, h, s);
      return s;
    };
    const double h = 1e-5;
    const double slope = (effect.energy(shifted(h)) - effect.energy(shifted(-h))) / (2 * h);
    EXPECT_NEAR(exact.force.dot(v), slope, (1e-7 + left_out.of_force) * (exact.force.norm() * v.norm() + 1e-3))
        << effect.name();
    // Slopes of the energy at shifted states, taken along the same rotation path, so that the curvature of SO(3) takes
    // part.
    const auto slope_at = [&](double at) {
      return (effect.energy(shifted(at + h)) - effect.energy(shifted(at - h))) / (2 * h);
    };
    const double curvature = (slope_at(1e-4) - slope_at(-1e-4)) / 2e-4;
    EXPECT_NEAR(v.dot(exact.tangent * v), curvature,
                (2e-4 + left_out.of_tangent) * exact.tangent.norm() * v.squaredNorm() + 1e-7)
        << effect.name();
  }
  // Force differences see every entry of K where no rotation is involved.
  std::vector<char> is_rotation(layout.n_dofs(), 0);
  for (const Index vector : layout.rotation_vectors())
    for (int c = 0; c < 3; ++c) is_rotation[3 * vector + c] = 1;
  const double h = 1e-5;
  for (Index d = 0; d < layout.n_dofs(); ++d) {
    if (is_rotation[d]) continue;
    std::vector<double> unit(layout.n_dofs(), 0.0);
    unit[d] = 1;
    State forward, backward;
    retract(layout, state, unit, h, forward);
    retract(layout, state, unit, -h, backward);
    const auto force_at = [&](const State& s) {
      (void)effect.follow(s, Effect::Follow::trial, everywhere);
      return assemble(effect, layout, s).force;
    };
    const Eigen::VectorXd column = (force_at(forward) - force_at(backward)) / (2 * h);
    EXPECT_LT((column - exact.tangent.col(d)).norm(), (1e-6 + left_out.of_tangent) * (exact.tangent.norm() + 1e-3))
        << effect.name() << " dof " << d;
  }
}

}  // namespace trame::micro::test
