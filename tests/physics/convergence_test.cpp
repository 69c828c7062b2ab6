/// \file
/// Order of convergence of both fiber models for a slender cantilever in large bending, against shooting.
/// Newton's method works on the fiber alone (no bodies, no ties), so that nothing but the discretisation is seen.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "micro/fiber/enriched_beam.h"
#include "micro/fiber/rod.h"
#include "micro/solve/newton.h"
#include "micro/weave/flat_start.h"
#include "tests/support/run_scene.h"
#include "tests/support/shooting.h"

namespace trame::micro {
namespace {

constexpr double length = 100, poisson_ratio = 0.3;
constexpr double bending = std::numbers::pi / 4;               // E I of radius 1, modulus 1
constexpr double end_force = 2 * bending / (length * length);  // P L²/EI = 2

/// A dead force on the last node of the layout that grows with the stage time.
class TipForce final : public Effect {
 public:
  TipForce(const Layout& layout, const Vec3& force) : layout_(layout), force_(force) {}
  [[nodiscard]] std::string_view name() const override { return "tip force"; }
  void begin_step(const State&, double stage_time) override { time_ = stage_time; }
  void add_sparsity(Pattern::Builder&) const override {}
  void add(const State&, Assembler& assembler) const override {
    assembler.add_force(layout_.n_nodes() - 1, 0, -time_ * force_);
  }
  [[nodiscard]] double energy(const State& state) const override {
    return -time_ * force_.dot(state.q[layout_.first_vector(layout_.n_nodes() - 1)]);
  }

 private:
  const Layout& layout_;
  Vec3 force_;
  double time_ = 0;
};

/// Clamp at node 0: position and section, or position and direction of the tangent, whose length is free.
PrescribedMotion clamp(const Layout& layout, FiberModel model) {
  PrescribedMotion m;
  m.fixed.assign(layout.n_dofs(), 0);
  m.motion.assign(layout.n_dofs(), 0);
  for (Index d = 0; d < layout.first_dof(1); ++d) m.fixed[d] = model == FiberModel::enriched || d != 3;
  return m;
}

Vec3 tip(FiberModel model, bool twist_stretch, Index n_elements) {
  Scene scene = test::cantilever(model, poisson_ratio, length, n_elements);
  scene.bodies.clear();
  const Assembly assembly = assemble_scene(scene);
  Layout layout;
  const FiberField field(assembly.mesh, {model}, layout);
  State state;
  state.q.assign(layout.n_vectors(), Vec3::Zero());
  field.read_configuration(assembly.configuration, state);

  Effects effects;
  if (model == FiberModel::enriched)
    effects.push_back(std::make_unique<EnrichedBeams>(field, scene.materials, assembly.configuration, twist_stretch));
  else
    effects.push_back(std::make_unique<Rods>(field, scene.materials));
  effects.push_back(std::make_unique<TipForce>(layout, Vec3(0, 0, end_force)));
  Timers timers;
  NewtonSolver newton(layout, {.force_tolerance = 1e-9, .max_iterations = 60, .step_cap = 1e9, .force_floor = 1e-13}, 1,
                      timers);
  newton.cover_sparsity(effects);
  constexpr int n_steps = 8;
  for (int step = 1; step <= n_steps; ++step) {
    for (const auto& effect : effects) effect->begin_step(state, static_cast<double>(step) / n_steps);
    const NewtonOutcome outcome = newton.solve(effects, clamp(layout, model), 1, state, {});
    EXPECT_TRUE(outcome.converged()) << describe(outcome.status) << ", residual " << outcome.residual;
  }
  return field.curve(state, 0, length).r;
}

Vec3 tip_by_shooting(FiberModel model, bool twist_stretch) {
  test::RodProblem rod;
  rod.section =
      model == FiberModel::rod ? test::rod_section(1, 1) : test::circular_section(1, poisson_ratio, 1, twist_stretch);
  rod.length = length;
  rod.end_force = Vec3(0, 0, end_force);
  rod.n_steps = 800;
  return test::shoot_rod(rod).r;
}

/// Theory gives 4 for both: h^(2k) of quadratic elements for what the load does work on, and the same of Hermite
/// cubics. Coarse meshes with slender elements are not in the asymptotic range yet, so the mean over three refinements
/// counts.
void expect_fourth_order(FiberModel model, bool twist_stretch = true) {
  const Vec3 exact = tip_by_shooting(model, twist_stretch);
  std::vector<double> errors;
  for (const Index n : {4, 8, 16, 32}) {
    errors.push_back((tip(model, twist_stretch, n) - exact).norm() / length);
    const double order = errors.size() > 1 ? std::log2(errors[errors.size() - 2] / errors.back()) : 0;
    fmt::print("{:2d} elements: error / length {:.2e}, order {:.2f}\n", n, errors.back(), order);
  }
  EXPECT_GT(std::log2(errors.front() / errors.back()) / 3, 3.5);
  EXPECT_LT(errors.back(), 1e-6);
}

TEST(Convergence, EnrichedBeam) { expect_fourth_order(FiberModel::enriched); }
TEST(Convergence, EnrichedBeamWithoutTwistStretch) { expect_fourth_order(FiberModel::enriched, false); }
TEST(Convergence, Rod) { expect_fourth_order(FiberModel::rod); }

}  // namespace
}  // namespace trame::micro
