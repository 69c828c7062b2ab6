/// \file
/// Unknowns, pattern, assembly by owned nodes, Cholesky and Newton's method on small systems.

#include "micro/solve/system.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "micro/solve/linear_solver.h"
#include "micro/solve/newton.h"
#include "micro/solve/threads.h"
#include "tests/support/finite_differences.h"

namespace trame::micro {
namespace {

TEST(Layout, CountsVectorsAndDofs) {
  Layout layout;
  EXPECT_EQ(layout.add_node(2), 0);
  EXPECT_EQ(layout.add_node(3), 1);
  EXPECT_EQ(layout.add_node(1), 2);
  EXPECT_EQ(layout.n_nodes(), 3);
  EXPECT_EQ(layout.n_vectors(), 6);
  EXPECT_EQ(layout.n_dofs(), 18);
  EXPECT_EQ(layout.first_vector(2), 5);
  EXPECT_EQ(layout.first_dof(1), 6);
  EXPECT_EQ(layout.n_vectors(1), 3);
}

TEST(Rotation, MatrixOfAVector) {
  const Mat3 quarter = rotation_matrix({0, 0, std::numbers::pi / 2});
  EXPECT_LT((quarter * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-15);
  const Vec3 v(0.3, -2.0, 1.1);
  const Mat3 r = rotation_matrix(v);
  EXPECT_LT((r * r.transpose() - Mat3::Identity()).norm(), 1e-14);
  EXPECT_NEAR(r.determinant(), 1, 1e-14);
  EXPECT_LT((r * v - v).norm(), 1e-14);
  EXPECT_NEAR(r.trace(), 1 + 2 * std::cos(v.norm()), 1e-14);
  // The series for small angles joins the closed form.
  for (const double angle : {0.0, 1e-9, 0.99e-4, 1.01e-4})
    EXPECT_LT((rotation_matrix({angle, 0, 0}) * Vec3::UnitY() - Vec3(0, std::cos(angle), std::sin(angle))).norm(),
              1e-16 + 1e-12 * angle);
}

TEST(Rotation, Retraction) {
  Layout layout;
  const Index node = layout.add_node(2);
  layout.add_rotation(layout.first_vector(node) + 1);
  const State state{{Vec3(1, 2, 3), Vec3::Zero()}, {rotation_matrix({0, 0, std::numbers::pi / 2})}};
  State moved;
  const std::vector<double> step = {2, 0, -2, std::numbers::pi, 0, 0};
  retract(layout, state, step, 0.5, moved);
  EXPECT_LT((moved.q[0] - Vec3(2, 2, 2)).norm(), 1e-15);
  // First the old rotation (x → y), then the increment about the fixed x axis (y → z).
  EXPECT_LT((moved.rotations[0] * Vec3::UnitX() - Vec3::UnitZ()).norm(), 1e-15);
}

TEST(Pattern, HoldsTheLowerTriangleOfItsCliques) {
  Layout layout;
  for (const int n_vectors : {2, 3, 1, 3}) layout.add_node(n_vectors);
  Pattern::Builder builder;
  builder.add_clique(std::array<Index, 3>{3, 0, 2});
  builder.add_clique(std::array<Index, 2>{2, 3});
  const Pattern pattern(layout, builder);
  ASSERT_EQ(pattern.n_nodes(), 4);
  const auto rows = [&](Index j) { return std::vector<Index>(pattern.rows(j).begin(), pattern.rows(j).end()); };
  EXPECT_EQ(rows(0), (std::vector<Index>{0, 2, 3}));
  EXPECT_EQ(rows(1), (std::vector<Index>{1}));
  EXPECT_EQ(rows(2), (std::vector<Index>{2, 3}));
  EXPECT_EQ(rows(3), (std::vector<Index>{3}));
  EXPECT_EQ(pattern.column_height(0), 6 + 3 + 9);
  EXPECT_EQ(pattern.row_offset(3, 0), 9);
  EXPECT_EQ(pattern.value_start(1), 6u * 18);
  EXPECT_EQ(pattern.n_values(), 6u * 18 + 9u * 9 + 3u * 12 + 9u * 9);
}

TEST(Pattern, CoversWhatItHolds) {
  Layout layout;
  for (int i = 0; i < 4; ++i) layout.add_node(1);
  Pattern::Builder chain, shorter, other;
  for (Index i = 0; i < 3; ++i) chain.add_clique(std::array<Index, 2>{i, i + 1});
  shorter.add_clique(std::array<Index, 2>{2, 1});
  other.add_clique(std::array<Index, 2>{0, 3});
  const Pattern pattern(layout, chain);
  EXPECT_TRUE(pattern.covers(shorter));
  EXPECT_FALSE(pattern.covers(other));
  EXPECT_FALSE(Pattern().covers(shorter));
}

/// ½ k |q_i − q_{i+1}|² between neighbours of a chain of one-vector nodes, and ½ k |q₀ − anchor|².
class Springs final : public Effect {
 public:
  Springs(const Layout& layout, double stiffness) : layout_(layout), k_(stiffness) {}
  [[nodiscard]] std::string_view name() const override { return "springs"; }
  void add_sparsity(Pattern::Builder& builder) const override {
    for (Index i = 0; i + 1 < layout_.n_nodes(); ++i) builder.add_clique(std::array<Index, 2>{i, i + 1});
  }
  void add(const State& state, Assembler& assembler) const override {
    for (Index i = 0; i + 1 < layout_.n_nodes(); ++i) {
      const Vec3 f = k_ * (state.q[i + 1] - state.q[i]);
      assembler.add_force(i, 0, -f);
      assembler.add_force(i + 1, 0, f);
      if (!assembler.wants_tangent()) continue;
      add_diagonal(assembler, i, i, k_);
      add_diagonal(assembler, i + 1, i + 1, k_);
      add_diagonal(assembler, i + 1, i, -k_);
    }
  }
  [[nodiscard]] double energy(const State& state) const override {
    double sum = 0;
    for (Index i = 0; i + 1 < layout_.n_nodes(); ++i) sum += 0.5 * k_ * (state.q[i + 1] - state.q[i]).squaredNorm();
    return sum;
  }

 private:
  static void add_diagonal(Assembler& assembler, Index i, Index j, double value) {
    if (!assembler.owns(j)) return;
    const auto block = assembler.block(i, j);
    for (int c = 0; c < 3; ++c) block.data[static_cast<std::size_t>(c) * block.stride + c] += value;
  }
  const Layout& layout_;
  double k_;
};

struct Chain {
  explicit Chain(Index n_nodes) {
    for (Index i = 0; i < n_nodes; ++i) layout.add_node(1);
    for (Index i = 0; i < n_nodes; ++i) state.q.emplace_back(std::cos(i), std::sin(3 * i), 0.1 * i * i);
  }
  Layout layout;
  State state;
};

TEST(Assembler, OwnersTogetherGiveTheWhole) {
  Chain chain(7);
  const Springs springs(chain.layout, 2.5);
  Pattern::Builder builder;
  springs.add_sparsity(builder);
  const Pattern pattern(chain.layout, builder);
  const auto assemble = [&](const std::vector<Index>& limits) {
    std::vector<double> values(pattern.n_values(), 0.0), force(21, 0.0), magnitude(7, 0.0);
    for (std::size_t t = 0; t + 1 < limits.size(); ++t) {
      Assembler assembler(chain.layout, &pattern, limits[t], limits[t + 1], force.data(), magnitude.data(),
                          values.data(), Assembler::Tangent::exact);
      springs.add(chain.state, assembler);
    }
    force.insert(force.end(), values.begin(), values.end());
    force.insert(force.end(), magnitude.begin(), magnitude.end());
    return force;
  };
  EXPECT_EQ(assemble({0, 7}), assemble({0, 3, 7}));  // to the last bit
  EXPECT_EQ(assemble({0, 7}), assemble({0, 1, 2, 3, 4, 5, 6, 7}));
  const auto whole = assemble({0, 7});
  EXPECT_GT(*std::max_element(whole.begin(), whole.end()), 1);
}

/// A cube of n³ nodes of one to three vectors, each tied to its neighbours and to the ground; the matrix is a Laplacian
/// that couples all components a little.
struct Lattice {
  explicit Lattice(Index n) {
    for (Index i = 0; i < n * n * n; ++i) layout.add_node(1 + i % 3);
    Pattern::Builder builder;
    for (Index z = 0; z < n; ++z)
      for (Index y = 0; y < n; ++y)
        for (Index x = 0; x < n; ++x) {
          const Index i = x + n * (y + n * z);
          if (x + 1 < n) builder.add_clique(std::array{i, i + 1});
          if (y + 1 < n) builder.add_clique(std::array{i, i + n});
          if (z + 1 < n) builder.add_clique(std::array{i, i + n * n});
        }
    pattern = Pattern(layout, builder);
  }
  /// Every coupling of a pair of dofs has the strength `coupling`/10, pairs of even sum `coupling` as a whole; each dof
  /// is held with stiffness `ground`.
  [[nodiscard]] std::vector<double> values(double coupling, double ground = 1e-2) const {
    std::vector<double> v(pattern.n_values()), row_sum(layout.n_dofs(), 0.0);
    const auto each = [&](const auto& visit) {
      for (Index j = 0; j < pattern.n_nodes(); ++j)
        for (Index c = layout.first_dof(j); c < layout.first_dof(j + 1); ++c)
          for (const Index i : pattern.rows(j))
            for (Index r = layout.first_dof(i); r < layout.first_dof(i + 1); ++r)
              visit(r, c,
                    pattern.value_start(j) +
                        static_cast<std::size_t>(c - layout.first_dof(j)) * pattern.column_height(j) +
                        pattern.row_offset(i, j) + (r - layout.first_dof(i)));
    };
    each([&](Index r, Index c, std::size_t at) {
      if (r <= c) return;
      v[at] = -coupling * ((r + c) % 2 == 0 ? 1 : 0.1) * (1 + 0.5 * std::sin(r + 2 * c));
      row_sum[r] -= v[at];
      row_sum[c] -= v[at];
    });
    each([&](Index r, Index c, std::size_t at) {
      if (r == c) v[at] = row_sum[r] + ground;
    });
    return v;
  }
  [[nodiscard]] std::vector<double> product(const std::vector<double>& v, const std::vector<double>& x) const {
    std::vector<double> y(x.size(), 0.0);
    for (Index j = 0; j < pattern.n_nodes(); ++j)
      for (Index c = layout.first_dof(j); c < layout.first_dof(j + 1); ++c)
        for (const Index i : pattern.rows(j))
          for (Index r = std::max(c, layout.first_dof(i)); r < layout.first_dof(i + 1); ++r) {
            const double a = v[pattern.value_start(j) +
                               static_cast<std::size_t>(c - layout.first_dof(j)) * pattern.column_height(j) +
                               pattern.row_offset(i, j) + (r - layout.first_dof(i))];
            y[r] += a * x[c];
            if (r != c) y[c] += a * x[r];
          }
    return y;
  }
  Layout layout;
  Pattern pattern;
};

/// A solver with the factor of `values(1)`.
std::unique_ptr<LinearSolver> factorized(const Lattice& lattice, FactorPrecision precision) {
  auto solver = std::make_unique<LinearSolver>(lattice.layout, precision, 2);
  solver->set_pattern(lattice.pattern);
  solver->analyze(lattice.values(1));
  EXPECT_TRUE(solver->factorize(lattice.values(1)));
  return solver;
}

class LinearSolverTest : public testing::TestWithParam<FactorPrecision> {};
INSTANTIATE_TEST_SUITE_P(Precision, LinearSolverTest,
                         testing::Values(FactorPrecision::single_precision, FactorPrecision::double_precision));

TEST_P(LinearSolverTest, SolvesAndTellsIndefiniteMatrices) {
  Chain chain(9);
  Springs springs(chain.layout, 2);
  Pattern::Builder builder;
  springs.add_sparsity(builder);
  const Pattern pattern(chain.layout, builder);
  const auto dense = test::assemble(springs, chain.layout, chain.state).tangent;
  std::vector<double> values(pattern.n_values(), 0.0), force(27, 0.0), magnitude(9, 0.0);
  Assembler assembler(chain.layout, &pattern, 0, 9, force.data(), magnitude.data(), values.data(),
                      Assembler::Tangent::exact);
  springs.add(chain.state, assembler);
  const auto shift_diagonal = [&](double by) {
    for (Index j = 0; j < 9; ++j)
      for (int c = 0; c < 3; ++c)
        values[pattern.value_start(j) + static_cast<std::size_t>(c) * pattern.column_height(j) + c] += by;
  };
  const Threads threads(2);
  LinearSolver solver(chain.layout, GetParam(), 2);
  solver.set_pattern(pattern);
  shift_diagonal(0.1);
  solver.analyze(values);
  ASSERT_TRUE(solver.factorize(values));
  Eigen::VectorXd x(27);
  for (int i = 0; i < 27; ++i) x[i] = std::sin(i + 1);
  const Eigen::VectorXd b = dense * x + 0.1 * x;
  std::vector<double> solution(b.data(), b.data() + 27);
  ASSERT_TRUE(solver.solve(values, solution, 1e-13, 10));
  EXPECT_LT((Eigen::Map<Eigen::VectorXd>(solution.data(), 27) - x).norm(), 1e-12 * x.norm());
  shift_diagonal(-0.2);  // now −0.1 against the zero eigenvalue of the free chain
  EXPECT_FALSE(solver.factorize(values));
  shift_diagonal(0.2);
  EXPECT_TRUE(solver.factorize(values)) << "a failure must not spoil the next factorisation";
}

TEST_P(LinearSolverTest, AnOldFactorServesAChangedMatrix) {
  const Lattice lattice(6);
  const Threads threads(2);
  const auto solver = factorized(lattice, GetParam());
  std::vector<double> x(lattice.layout.n_dofs());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = std::sin(1.7 * static_cast<double>(i));
  const std::vector<double> changed = lattice.values(1.3), b = lattice.product(changed, x);
  std::vector<double> solution = b;
  ASSERT_FALSE(solver->solve(changed, solution, 1e-12, 1)) << "one iteration cannot do with another matrix's factor";
  EXPECT_EQ(solution, b) << "what could not be solved must stay as it was";
  const auto n_iterations = solver->solve(changed, solution, 1e-12, 40);
  ASSERT_TRUE(n_iterations);
  EXPECT_GT(*n_iterations, 3);
  for (std::size_t i = 0; i < x.size(); ++i) ASSERT_NEAR(solution[i], x[i], 1e-9);
}

TEST_P(LinearSolverTest, SolvesWithTermsThatAreNotSymmetric) {
  const Lattice lattice(5);
  const std::vector<double> values = lattice.values(1);
  const Threads threads(2);
  LinearSolver solver(lattice.layout, GetParam(), 2);
  solver.set_pattern(lattice.pattern);
  solver.analyze(values);
  ASSERT_TRUE(solver.factorize(values));
  UnsymmetricTerms terms;
  const Index n_vectors = lattice.layout.n_vectors();
  for (Index t = 0; t < 7; ++t) {
    terms.begin_term();
    terms.add_left((5 * t) % n_vectors, Vec3(1, -0.5, 0.2 * t));
    terms.add_left((5 * t + 1) % n_vectors, Vec3(-1, 0.5, 0.1));
    terms.add_right((5 * t + 2) % n_vectors, Vec3(0.3, t, -0.4));
  }
  std::vector<double> x(lattice.layout.n_dofs());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = std::sin(1.7 * static_cast<double>(i));
  std::vector<double> b = lattice.product(values, x);
  terms.add_product(x, b);
  std::vector<double> solution = b;
  ASSERT_FALSE(solver.solve(values, terms, solution, 1e-12, 2));
  EXPECT_EQ(solution, b) << "what could not be solved must stay as it was";
  const auto n_iterations = solver.solve(values, terms, solution, 1e-12, 40);
  ASSERT_TRUE(n_iterations);
  EXPECT_LE(*n_iterations, 2 * 7 + 2) << "as many as there are terms, but for round-off";
  for (std::size_t i = 0; i < x.size(); ++i) ASSERT_NEAR(solution[i], x[i], 1e-9);

  // K alone tells whether it is positive definite.
  const std::vector<double> negative = lattice.values(-1);
  ASSERT_FALSE(solver.solve(negative, terms, solution, 1e-12, 40));
  EXPECT_TRUE(solver.met_negative_curvature());
}

TEST_P(LinearSolverTest, FindsNegativeCurvatureBehindTheFactorOfAnotherMatrix) {
  const Lattice lattice(6);
  const Threads threads(2);
  const auto solver = factorized(lattice, GetParam());
  // All dofs together are held by nothing but the ground.
  for (const double ground : {-1e-3, -1e-6, 1e-6, 1e-3}) {
    std::minstd_rand random(1);
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::vector<double> load(lattice.layout.n_dofs());
    for (double& b : load) b = uniform(random);
    EXPECT_EQ(solver->finds_negative_curvature(lattice.values(1.5, ground), load, 12), ground < 0) << ground;
  }
}

TEST(LinearSolver, AutomaticPrecisionIsSingleWhereThatDoesAndDoubleWhereNot) {
  const Lattice lattice(13);
  const Threads threads(2);
  const auto single = factorized(lattice, FactorPrecision::single_precision),
             in_double = factorized(lattice, FactorPrecision::double_precision),
             automatic = factorized(lattice, FactorPrecision::automatic);
  std::vector<double> x(lattice.layout.n_dofs());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = std::sin(1.7 * static_cast<double>(i));
  const auto solution_of = [&](LinearSolver& solver, const std::vector<double>& values) {
    std::vector<double> solution = lattice.product(values, x);
    EXPECT_TRUE(solver.solve(values, solution, 1e-6, 20));
    return solution;
  };
  const std::vector<double> good = lattice.values(1), nearly_singular = lattice.values(1, 1e-9),
                            indefinite = lattice.values(1, -1e-3);
  ASSERT_TRUE(is_in_single_precision(FactorPrecision::automatic, automatic->n_factor_entries()));
  EXPECT_EQ(solution_of(*automatic, good), solution_of(*single, good));
  EXPECT_NE(solution_of(*automatic, good), solution_of(*in_double, good));

  ASSERT_FALSE(single->factorize(nearly_singular));
  ASSERT_TRUE(in_double->factorize(nearly_singular));
  ASSERT_TRUE(automatic->factorize(nearly_singular));
  EXPECT_EQ(solution_of(*automatic, nearly_singular), solution_of(*in_double, nearly_singular));
  EXPECT_FALSE(automatic->factorize(indefinite));
}

/// Fronts of this lattice are large enough to be cut in tiles and tasks.
TEST_P(LinearSolverTest, LargeFrontsAreExactAndDoNotDependOnTheNumberOfThreads) {
  const Lattice lattice(11);
  std::vector<double> x(lattice.layout.n_dofs());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = std::sin(1.7 * static_cast<double>(i));
  const std::vector<double> values = lattice.values(1), b = lattice.product(values, x);
  std::vector<std::vector<double>> solutions;
  for (const int n_threads : {1, 2, 5}) {
    const Threads threads(n_threads);
    LinearSolver solver(lattice.layout, GetParam(), n_threads);
    solver.set_pattern(lattice.pattern);
    solver.analyze(values);
    ASSERT_TRUE(solver.factorize(values));
    EXPECT_GT(solver.n_factor_flops(), 1e9);
    solutions.push_back(b);
    ASSERT_TRUE(solver.solve(values, solutions.back(), 1e-12, 20));
  }
  for (std::size_t i = 0; i < x.size(); ++i) ASSERT_NEAR(solutions[0][i], x[i], 1e-9);
  EXPECT_EQ(solutions[0], solutions[1]);  // to the last bit
  EXPECT_EQ(solutions[0], solutions[2]);
}

TEST(Newton, PrescribedMotionPullsAChainStraight) {
  Chain chain(5);
  Effects effects;
  effects.push_back(std::make_unique<Springs>(chain.layout, 3.0));
  Timers timers;
  NewtonSolver newton(
      chain.layout, {.force_tolerance = 1e-10, .max_iterations = 20, .step_cap = 1e9, .force_floor = 1e-14}, 1, timers);
  newton.cover_sparsity(effects);
  PrescribedMotion prescribed;
  prescribed.fixed.assign(15, 0);
  prescribed.motion.assign(15, 0);
  const Vec3 first = chain.state.q[0], target(8, -4, 2), motion = target - chain.state.q[4];
  for (int c = 0; c < 3; ++c) {
    prescribed.fixed[c] = prescribed.fixed[12 + c] = 1;
    prescribed.motion[12 + c] = motion[c];
  }
  const NewtonOutcome outcome = newton.solve(effects, prescribed, 1, chain.state, {});
  ASSERT_TRUE(outcome.converged());
  EXPECT_EQ(outcome.n_iterations, 1);  // it is linear
  for (Index i = 0; i < 5; ++i) EXPECT_LT((chain.state.q[i] - (first + i * 0.25 * (target - first))).norm(), 1e-12);
  // The reaction holds the end: spring constant times the stretch of one link.
  newton.evaluate(effects, prescribed, chain.state, true);
  const Vec3 reaction(newton.force()[12], newton.force()[13], newton.force()[14]);
  EXPECT_LT((reaction - 3.0 * 0.25 * (target - first)).norm(), 1e-12);
}

}  // namespace
}  // namespace trame::micro
