#include "meso/continuum/continuum.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "meso/comparison.h"
#include "tests/support/lattice_yarns.h"

namespace trame::meso {
namespace {

using micro::FiberConfiguration;
using micro::FiberMesh;
using micro::test::input_error;
using micro::test::LatticeYarns;
using micro::test::mapped;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Node k of the fiber at a row and column of a lattice yarn.
Index node(const LatticeYarns& yarns, Index row, Index column, Index k) {
  return (row * yarns.n_columns + column) * yarns.n_nodes_per_fiber() + k;
}

FiberConfiguration shaken(FiberConfiguration fibers, double deviation, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, deviation);
  for (Vec3& r : fibers.r)
    for (double& x : r) x += normal(random);
  return fibers;
}

/// States in memory: the reference, A and B.
class ThreeStates : public FiberStates {
 public:
  ThreeStates(const FiberMesh& mesh, const FiberConfiguration& reference, const FiberConfiguration& a,
              const FiberConfiguration& b)
      : states_{reference, a, b} {
    header_.mesh = mesh;
  }
  [[nodiscard]] std::string name() const override { return "states"; }
  [[nodiscard]] const micro::SnapshotHeader& header() const override { return header_; }
  [[nodiscard]] Index n_increments() const override { return 3; }
  [[nodiscard]] micro::Increment read(Index i) const override {
    micro::Increment increment;
    increment.fibers = states_.at(i);
    return increment;
  }

 private:
  micro::SnapshotHeader header_;
  std::vector<FiberConfiguration> states_;
};

std::vector<YarnContinuum> all_rows(const FiberMesh& mesh, const FiberConfiguration& reference,
                                    const FiberConfiguration& a, const FiberConfiguration& b,
                                    const ContinuumOptions& options = {}) {
  const ThreeStates states(mesh, reference, a, b);
  const YarnComparer comparer(states, {.n_stations = 20, .bands_of = std::vector<Index>(), .continuum = options});
  std::vector<YarnContinuum> rows;
  for (const YarnComparison& yarn : comparer.compare({1, 2}).yarns) rows.push_back(yarn.continuum);
  return rows;
}

YarnContinuum only_row(const FiberMesh& mesh, const FiberConfiguration& reference, const FiberConfiguration& a,
                       const FiberConfiguration& b) {
  return all_rows(mesh, reference, a, b).at(0);
}

Mat3 some_map() {
  Mat3 F;
  F << 1.02, 0.03, -0.01, 0.05, 0.95, 0.1, -0.04, 0.05, 1.1;
  return Eigen::AngleAxisd(0.8, Vec3(1, 2, -1).normalized()) * F;
}

TEST(NonAffine, AffineMapsLeaveNothing) {
  const LatticeYarns yarns{.n_rows = 4, .n_columns = 5, .spacing = 2e-5, .length = 1e-3};
  const auto straight = yarns.configuration();
  // A yarn that is bent in A: affine is affine wherever one starts from.
  auto bent = straight;
  for (Vec3& r : bent.r) r.z() += 2e-4 * std::sin(r.x() * 5e3);
  for (const auto& a : {straight, bent})
    for (const double D2 : non_affine_residual(yarns.mesh(), yarns.mesh().yarns[0], a.r, mapped(a, some_map()).r))
      EXPECT_TRUE(std::isnan(D2) || D2 < 1e-20) << D2;
}

/// The upper half of a hexagonal packing slips by b. Of the 20 neighbours of a node just below the plane (6 fibers × 3
/// nodes + 2 of its own) 6 move, all at the height √3/2. The best F takes their mean: of |b|² · 6 it explains
/// |b|² (6 · √3/2)² / (12 · 3/4) = 3 |b|², and 3 |b|² / 20 remain. Nodes farther from the plane see nothing.
TEST(NonAffine, SlipPlane) {
  const LatticeYarns yarns{.n_rows = 8, .n_columns = 8, .n_elements = 5, .length = 10};
  const auto a = yarns.configuration();
  for (const Vec3& slip : {Vec3(0.3, 0, 0), Vec3(0.1, 0.2, 0), Vec3(0, 0, 0.4)}) {
    auto b = a;
    for (Vec3& r : b.r)
      if (r.z() > 3.5 * std::sqrt(3.0) / 2) r += slip;
    const auto D2 = non_affine_residual(yarns.mesh(), yarns.mesh().yarns[0], a.r, b.r);
    for (Index k = 1; k < 10; ++k) {
      for (const Index row : {3, 4})
        EXPECT_NEAR(D2[node(yarns, row, 4, k)], 3.0 / 20 * slip.squaredNorm(), 1e-12) << row;
      for (const Index row : {1, 2, 5, 6}) EXPECT_NEAR(D2[node(yarns, row, 4, k)], 0, 1e-12) << row;
    }
  }
}

/// Displacements of variance σ² in each component: relative to the node's own, those of its n neighbours have the
/// covariance σ²(I + 1 1ᵀ). A map with 3 unknowns a component takes 3 from the trace of I and nothing from 1 1ᵀ, since
/// arms of a symmetric neighbourhood add up to zero: 3 σ² (2n − 3) / n is left, n = 20.
TEST(NonAffine, RandomDisplacements) {
  const LatticeYarns yarns{.n_rows = 12, .n_columns = 12, .n_elements = 40, .spacing = 2e-5, .length = 1e-2};
  const double deviation = 0.02;
  const auto a = yarns.configuration();
  const auto D2 = non_affine_residual(yarns.mesh(), yarns.mesh().yarns[0], a.r, shaken(a, deviation * 2e-5, 7).r);
  double sum = 0;
  Index n = 0;
  for (Index row = 1; row < 11; ++row)
    for (Index column = 1; column < 11; ++column)
      for (Index k = 1; k < 80; ++k, ++n) sum += D2[node(yarns, row, column, k)];
  // 7900 nodes, each correlated with some 20 others, each with a scatter of 0.35: 0.02 of the mean.
  EXPECT_NEAR(sum / n / (deviation * deviation), 3.0 * 37 / 20, 0.06 * 5.55);
}

TEST(NonAffine, TooFewNeighboursSayNothing) {
  const LatticeYarns yarns{.n_rows = 1, .n_columns = 2};
  const auto fibers = yarns.configuration();
  auto mesh = yarns.mesh();
  for (const double D2 : non_affine_residual(mesh, mesh.yarns[0], fibers.r, fibers.r)) EXPECT_TRUE(std::isnan(D2));
  mesh.yarns[0].n_fibers = 1;
  EXPECT_TRUE(non_affine_residual(mesh, mesh.yarns[0], fibers.r, fibers.r).empty());
}

TEST(Continuum, HoldsForAffineMotion) {
  const LatticeYarns yarns{
      .n_yarns = 2, .n_rows = 5, .n_columns = 6, .n_elements = 10, .spacing = 2e-5, .length = 2e-3};
  const auto reference = yarns.configuration();
  const auto mesh = yarns.mesh();
  const auto rows = all_rows(mesh, reference, mapped(reference, some_map()), mapped(reference, Mat3(1.1 * some_map())));
  ASSERT_EQ(rows.size(), 2u);
  for (Index y = 0; y < 2; ++y) {
    EXPECT_EQ(rows[y].yarn, y);
    EXPECT_EQ(rows[y].mesh_status, MeshStatus::ok);
    EXPECT_GT(rows[y].n_nodes, 30 * 19);
    EXPECT_LT(rows[y].D2_95, 1e-12);
    EXPECT_LT(rows[y].non_affine_95, 1e-9);
    EXPECT_EQ(rows[y].exchanged, 0);
    EXPECT_EQ(rows[y].flagged, 0);
    EXPECT_NEAR(rows[y].typical_strain, std::sqrt(3.0) * 0.5 * (1.21 - 1), 1e-9);
    EXPECT_LT(rows[y].mesh_difference, 1e-9);
    EXPECT_EQ(rows[y].verdict, ContinuumVerdict::holds);
  }
}

TEST(Continuum, StateAgainstItself) {
  const LatticeYarns yarns{.n_rows = 3, .n_columns = 4};
  const auto a = mapped(yarns.configuration(), some_map());
  const YarnContinuum row = only_row(yarns.mesh(), yarns.configuration(), a, a);
  EXPECT_EQ(row.verdict, ContinuumVerdict::holds);
  EXPECT_LT(row.non_affine_share, 1e-3);
  EXPECT_LT(row.mesh_difference, 1e-3);
}

/// Two neighbours in the middle of a hexagonal packing change places. Each had six neighbours: the other one and two in
/// common stay so, three are lost. Bonds in all: 4 in each of 5 rows, 9 between rows.
TEST(Continuum, SwappedFibersAreExchangedNeighbours) {
  const LatticeYarns yarns{.n_rows = 5, .n_columns = 5, .n_elements = 10, .length = 20};
  const auto a = yarns.configuration();
  auto b = a;
  for (Index k = 0; k < yarns.n_nodes_per_fiber(); ++k) std::swap(b.r[node(yarns, 2, 1, k)], b.r[node(yarns, 2, 2, k)]);
  const YarnContinuum row = only_row(yarns.mesh(), a, a, b);
  EXPECT_DOUBLE_EQ(row.exchanged, 6.0 / (5 * 4 + 4 * 9));
  EXPECT_GT(row.flagged, 0);
  EXPECT_NE(row.verdict, ContinuumVerdict::holds);
}

/// In half of the yarn only: half as many.
TEST(Continuum, ExchangesAreAveragedOverStations) {
  const LatticeYarns yarns{.n_rows = 5, .n_columns = 5, .n_elements = 10, .length = 20};
  const auto a = yarns.configuration();
  auto b = a;
  for (Index k = 11; k < 21; ++k) std::swap(b.r[node(yarns, 2, 1, k)], b.r[node(yarns, 2, 2, k)]);
  EXPECT_DOUBLE_EQ(only_row(yarns.mesh(), a, a, b).exchanged, 0.5 * 6 / (5 * 4 + 4 * 9));
}

/// What `fiber_by_fiber` says about its limit of the share of disorder; and small disorder exchanges no neighbours.
TEST(Continuum, DisorderIsNoStrain) {
  const LatticeYarns yarns{.n_rows = 6, .n_columns = 8, .n_elements = 20, .length = 40};
  const auto a = yarns.configuration();
  for (const double deviation : {1e-4, 0.02}) {
    const YarnContinuum row = only_row(yarns.mesh(), a, a, shaken(a, deviation, 3));
    EXPECT_NEAR(row.non_affine_share, 0.6, 0.06);
    EXPECT_EQ(row.exchanged, 0);
    EXPECT_NE(row.verdict, ContinuumVerdict::holds);
  }
}

TEST(Continuum, FewFibers) {
  for (const Index n_fibers : {1, 2}) {
    const LatticeYarns yarns{.n_rows = 1, .n_columns = n_fibers};
    const auto a = yarns.configuration();
    const YarnContinuum row = only_row(yarns.mesh(), a, a, mapped(a, some_map()));
    EXPECT_EQ(row.verdict, ContinuumVerdict::too_few_fibers);
    EXPECT_EQ(row.mesh_status, MeshStatus::too_few_fibers);
    EXPECT_TRUE(std::isnan(row.D2_mean) && std::isnan(row.exchanged) && std::isnan(row.flagged));
  }
  const LatticeYarns yarns{.n_rows = 2, .n_columns = 2};
  auto mesh = yarns.mesh();
  mesh.yarns[0].n_fibers = 3;
  const auto a = yarns.configuration();
  const YarnContinuum three = only_row(mesh, a, a, mapped(a, some_map()));
  EXPECT_EQ(three.verdict, ContinuumVerdict::holds);
  EXPECT_EQ(three.exchanged, 0);
}

/// Fibers in one layer enclose no volume: what fibers do can still be told, but not of a continuum.
TEST(Continuum, OneLayer) {
  const LatticeYarns yarns{.n_rows = 1, .n_columns = 6};
  const auto a = yarns.configuration();
  const YarnContinuum row = only_row(yarns.mesh(), a, a, mapped(a, some_map()));
  EXPECT_EQ(row.mesh_status, MeshStatus::flat_section);
  EXPECT_LT(row.D2_95, 1e-12);
  EXPECT_TRUE(std::isnan(row.exchanged) && std::isnan(row.flagged) && std::isnan(row.mesh_difference));
  EXPECT_EQ(row.verdict, ContinuumVerdict::nothing_to_judge);
}

TEST(Continuum, DoesNotDependOnThreads) {
  const LatticeYarns yarns{.n_yarns = 3, .n_rows = 4, .n_columns = 5};
  const auto a = yarns.configuration(), b = shaken(a, 0.05, 11);
  const auto mesh = yarns.mesh();
  const int n_threads = omp_get_max_threads();
  std::vector<YarnContinuum> rows[2];
  for (const int n : {1, 4}) {
    omp_set_num_threads(n);
    rows[n == 4] = all_rows(mesh, a, a, b);
  }
  omp_set_num_threads(n_threads);
  for (int y = 0; y < 3; ++y) {
    EXPECT_EQ(rows[0][y].D2_mean, rows[1][y].D2_mean);
    EXPECT_EQ(rows[0][y].exchanged, rows[1][y].exchanged);
    EXPECT_EQ(rows[0][y].typical_strain, rows[1][y].typical_strain);
    EXPECT_EQ(rows[0][y].mesh_difference, rows[1][y].mesh_difference);
  }
}

/// E on one mesh, 1.1 E on the other: 0.1 of E over the mean 1.05 E, however wild a few tetrahedra are.
TEST(MeshDifference, OfUniformFields) {
  const LatticeYarns yarns{.n_rows = 5, .n_columns = 6, .n_elements = 20, .length = 40};
  const auto fibers = yarns.mesh();
  const auto r = yarns.configuration().r;
  YarnMesh mesh[2];
  StrainField field[2];
  for (const int i : {0, 1}) {
    mesh[i] = mesh_yarn(fibers, 0, r, {.kind = i == 0 ? MeshKind::delaunay : MeshKind::swept});
    field[i].E.assign(mesh[i].tets.size(), (1 + 0.1 * i) * 0.02 * Mat3::Identity());
    field[i].flagged.assign(mesh[i].tets.size(), 0);
  }
  field[0].E[7] = Mat3::Constant(1e9);
  field[1].E[20] = Mat3::Constant(nan);
  field[1].flagged[20] = 1;
  EXPECT_NEAR(mesh_difference(fibers, mesh[0], field[0], mesh[1], field[1], 20), 0.1 / 1.05, 1e-12);
  field[1].flagged.assign(mesh[1].tets.size(), 1);
  EXPECT_TRUE(std::isnan(mesh_difference(fibers, mesh[0], field[0], mesh[1], field[1], 20)));
}

TEST(Verdict, EveryLimitCounts) {
  const auto row = [](const ContinuumLimits& at) {
    YarnContinuum row;
    row.n_nodes = 1;
    row.non_affine_95 = at.non_affine_95;
    row.non_affine_share = at.non_affine_share;
    row.exchanged = at.exchanged;
    row.flagged = at.flagged;
    row.mesh_difference = at.mesh_difference;
    return row;
  };
  EXPECT_EQ(verdict(row(fiber_by_fiber)), ContinuumVerdict::holds);
  EXPECT_EQ(verdict(row(on_average)), ContinuumVerdict::holds_on_average);
  EXPECT_EQ(verdict(row({nan, nan, nan, nan, nan})), ContinuumVerdict::holds);
  EXPECT_EQ(verdict(YarnContinuum()), ContinuumVerdict::too_few_fibers);
  YarnContinuum unmeshed;
  unmeshed.n_nodes = 100;
  unmeshed.mesh_status = MeshStatus::flat_section;
  unmeshed.verdict = verdict(unmeshed);
  EXPECT_EQ(unmeshed.verdict, ContinuumVerdict::nothing_to_judge);
  EXPECT_EQ(explanation(unmeshed), "nothing to judge: no mesh, because all fibers lie in one surface");
  const auto beyond = [&](const ContinuumLimits& limits, double YarnContinuum::*member) {
    YarnContinuum changed = row(limits);
    changed.*member *= 1.01;
    return verdict(changed);
  };
  for (const auto member : {&YarnContinuum::non_affine_95, &YarnContinuum::exchanged, &YarnContinuum::flagged,
                            &YarnContinuum::mesh_difference}) {
    EXPECT_EQ(beyond(fiber_by_fiber, member), ContinuumVerdict::holds_on_average);
    EXPECT_EQ(beyond(on_average, member), ContinuumVerdict::does_not_hold);
  }
  EXPECT_EQ(beyond(fiber_by_fiber, &YarnContinuum::non_affine_share), ContinuumVerdict::holds_on_average);
  EXPECT_EQ(text(ContinuumVerdict::holds_on_average), "holds on average, not fiber by fiber");
}

/// Names the measures that stand against the next stronger verdict, and no others.
TEST(Verdict, IsExplained) {
  YarnContinuum row;
  row.verdict = verdict(row);
  EXPECT_EQ(explanation(row), "too few fibers to say");
  row.n_nodes = 1;
  row.non_affine_95 = 0.2;
  row.verdict = verdict(row);
  EXPECT_EQ(explanation(row), "continuum holds");
  row.non_affine_95 = 0.5;
  row.exchanged = 0.12;
  row.verdict = verdict(row);
  EXPECT_EQ(explanation(row),
            "holds on average, not fiber by fiber: fibers stray by 0.5 of their distance (limit 0.25); 12 % of the "
            "neighbours are new (limit 5 %)");
  row.flagged = 0.11;
  row.verdict = verdict(row);
  EXPECT_EQ(explanation(row), "does not hold: 11 % of the mesh is inside out (limit 10 %)");
}

TEST(Continuum, OptionsOutOfRangeAreNamed) {
  const LatticeYarns yarns;
  const auto mesh = yarns.mesh();
  const auto r = yarns.configuration();
  const auto error = [&](const ContinuumOptions& options) {
    return input_error([&] { (void)all_rows(mesh, r, r, r, options); });
  };
  EXPECT_EQ(error({.n_slabs = 0}), "continuum: n_slabs is 0; it must be above 0");
  EXPECT_EQ(input_error([&] { (void)YarnComparer(ThreeStates(mesh, r, r, r), {.n_stations = 0}); }),
            "comparison: n_stations is 0; it must be above 0");
  EXPECT_NE(error({.neighbourhood = {.section_radius = -1}}).find("section_radius is -1"), std::string::npos);
}

}  // namespace
}  // namespace trame::meso
