/// \file
/// Two levels against the factor, on the matrix of a bundle.

#include "micro/solve/two_level.h"

#include <gtest/gtest.h>

#include <cmath>

#include "micro/fiber/rod_space.h"
#include "micro/solve/threads.h"
#include "tests/bench/bundle.h"

namespace trame::micro {
namespace {

/// Seven fibers that touch each other all along and next to nothing else holds: many soft modes.
struct System {
  System() : bundle(7, FiberModel::enriched, 20) {
    bundle.assemble_matrix(1e-3);
    for (Index d = 0; d < bundle.layout.n_dofs(); ++d) load.push_back(std::sin(1.0 * d * d));
  }
  /// The stiffness against a motion of dof d of a node, all by itself.
  double& diagonal(Index node, Index d) {
    return bundle.values[bundle.pattern.value_start(node) +
                         static_cast<std::size_t>(d) * (bundle.pattern.column_height(node) + 1)];
  }
  void analyze(LinearSolver& solver) const {
    solver.set_pattern(bundle.pattern);
    solver.analyze(bundle.values, [&] { return rod_space(bundle.field, bundle.state); });
  }
  bench::Bundle bundle;
  std::vector<double> load;
};

class TwoLevelTest : public testing::TestWithParam<FactorPrecision> {};
INSTANTIATE_TEST_SUITE_P(Precision, TwoLevelTest,
                         testing::Values(FactorPrecision::single_precision, FactorPrecision::double_precision));

TEST_P(TwoLevelTest, GivesTheSolutionOfTheFactor) {
  const System system;
  const auto solve = [&](Preconditioner preconditioner, int n_threads, int max_iterations, double tolerance) {
    const Threads threads(n_threads);
    LinearSolver solver(system.bundle.layout, GetParam(), n_threads, preconditioner);
    system.analyze(solver);
    EXPECT_EQ(solver.has_two_levels(), preconditioner == Preconditioner::two_level);
    std::vector<double> x = system.load;
    EXPECT_TRUE(solver.factorize(system.bundle.values));
    EXPECT_TRUE(solver.solve(system.bundle.values, x, tolerance, max_iterations));
    return x;
  };
  const std::vector<double> reference = solve(Preconditioner::factor, 1, 30, 1e-13),
                            x = solve(Preconditioner::two_level, 1, 60, 1e-13);
  double error = 0, size = 0;
  for (std::size_t d = 0; d < x.size(); ++d) {
    error += (x[d] - reference[d]) * (x[d] - reference[d]);
    size += reference[d] * reference[d];
  }
  EXPECT_LT(std::sqrt(error / size), 1e-8);
  solve(Preconditioner::two_level, 1, 9, 1e-3);
  EXPECT_EQ(x, solve(Preconditioner::two_level, 3, 60, 1e-13)) << "threads";
}

TEST_P(TwoLevelTest, TellsAnIndefiniteMatrix) {
  const auto is_solved = [&](const System& system) {
    const Threads threads(2);
    LinearSolver solver(system.bundle.layout, GetParam(), 2, Preconditioner::two_level);
    system.analyze(solver);
    std::vector<double> x = system.load;
    return solver.factorize(system.bundle.values) && solver.solve(system.bundle.values, x, 1e-10, 100);
  };
  EXPECT_TRUE(is_solved(System()));
  System within;
  within.diagonal(5, 0) -= 1;
  EXPECT_FALSE(is_solved(within)) << "one fiber";
  // Fibers that are stable by themselves, but not with each other.
  System between;
  const Pattern& pattern = between.bundle.pattern;
  const Index j = 20, i = pattern.rows(j).back();
  ASSERT_GT(i, 41) << "a node of another fiber";
  between.bundle.values[pattern.value_start(j) + pattern.row_offset(i, j)] +=
      3 * std::sqrt(between.diagonal(i, 0) * between.diagonal(j, 0));
  EXPECT_FALSE(is_solved(between)) << "two fibers";
}

/// Motions that rods have and beams follow exactly: of a straight fiber all that are rigid, stretch and twist.
TEST(RodSpace, HoldsWhatRodsDo) {
  const bench::Bundle bundle(1, FiberModel::enriched, 6);
  const CoarseSpace space = rod_space(bundle.field, bundle.state);
  ASSERT_EQ(space.n_coarse_nodes(), 7);
  const double length = 60;
  const auto follow = [&](auto position, auto turn, auto beam) {
    std::vector<Vec3> moved(bundle.layout.n_vectors(), Vec3::Zero());
    for (Index j = 0; j < bundle.layout.n_nodes(); ++j)
      for (const CoarseSpace::Link& link : space.links_of(j)) {
        const Vec3 r = bundle.state.q[bundle.layout.first_vector(2 * link.node)];
        Eigen::Vector<double, 6> coarse;
        coarse << position(r), turn(r);
        const Eigen::Vector<double, 9> q =
            Eigen::Map<const Eigen::Matrix<double, 9, 6>>(space.weights.data() + link.weight) * coarse;
        for (int v = 0; v < 3; ++v) moved[bundle.layout.first_vector(j) + v] += q.segment<3>(3 * v);
      }
    for (Index j = 0; j < bundle.layout.n_nodes(); ++j)
      for (int v = 0; v < 3; ++v) {
        const Index at = bundle.layout.first_vector(j);
        EXPECT_LT((moved[at + v] - beam(bundle.state.q[at], bundle.state.q[at + v], v)).norm(), 1e-12)
            << "node " << j << " vector " << v;
      }
  };
  const Vec3 omega(0.3, -0.2, 0.5), shift(1, 2, 3), zero = Vec3::Zero();
  follow([&](const Vec3& r) -> Vec3 { return shift + omega.cross(r); }, [&](const Vec3&) { return omega; },
         [&](const Vec3& r, const Vec3& q, int v) -> Vec3 {
           return v == 0 ? Vec3(shift + omega.cross(r)) : omega.cross(q);
         });
  follow([&](const Vec3& r) { return Vec3(0.01 * r.x(), 0, 0); }, [&](const Vec3&) { return zero; },
         [&](const Vec3& r, const Vec3&, int v) { return v == 0 ? Vec3(0.01 * r.x(), 0, 0) : zero; });
  follow([&](const Vec3&) { return zero; }, [&](const Vec3& r) { return Vec3(r.x() / length, 0, 0); },
         [&](const Vec3& r, const Vec3& q, int v) { return v == 0 ? zero : Vec3(r.x() / length, 0, 0).cross(q); });
}

}  // namespace
}  // namespace trame::micro
