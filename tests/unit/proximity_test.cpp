/// \file
/// The search for proximities against a slow oracle without a grid: the curves are scanned densely for the conditions
/// that define a proximity.

#include "micro/contact/proximity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "micro/weave/flat_start.h"

namespace trame::micro {
namespace {

/// `n_elements` and `radii` are used in turn.
struct Fibers {
  Fibers(FiberModel model, const std::vector<std::vector<Vec3>>& curves, const std::vector<Index>& n_elements,
         const std::vector<double>& radii = {1.0})
      : assembly(make_assembly(model, curves, n_elements, radii)),
        field(assembly.mesh, std::vector(curves.size(), model), layout) {
    state.q.assign(layout.n_vectors(), Vec3::Zero());
    field.read_configuration(assembly.configuration, state);
  }
  static Assembly make_assembly(FiberModel model, const std::vector<std::vector<Vec3>>& curves,
                                const std::vector<Index>& n_elements, const std::vector<double>& radii) {
    Scene scene;
    scene.materials = {{"m", 1, 1, 0.4, 0.25, 0.25}};
    for (const double radius : radii)
      scene.fiber_types.push_back({"f" + std::to_string(scene.fiber_types.size()), 0, radius, model});
    for (std::size_t i = 0; i < curves.size(); ++i)
      scene.fibers.push_back(
          {std::to_string(i), static_cast<Index>(i % radii.size()), curves[i], n_elements[i % n_elements.size()], {}});
    return assemble_scene(scene);
  }
  Assembly assembly;
  Layout layout;
  FiberField field;
  State state;
};

/// Places where two fibers touch, found by scanning both densely: pairs of samples that are nearer than touching and
/// nearer than all around them. None of them may be without a proximity of the pair beside it.
int count_missed(const Fibers& f, const std::vector<Proximity>& found) {
  constexpr double step = 0.1, clearly = 0.01;
  const FiberMesh& mesh = f.field.mesh();
  std::vector<std::vector<Vec3>> curves(mesh.n_fibers());
  for (Index i = 0; i < mesh.n_fibers(); ++i)
    for (double s = 0; s <= mesh.length(i); s += step * mesh.radius[i])
      curves[i].push_back(f.field.curve(f.state, i, s).r);
  int missed = 0;
  for (Index a = 0; a < mesh.n_fibers(); ++a)
    for (Index b = a + 1; b < mesh.n_fibers(); ++b) {
      const double touching = mesh.radius[a] + mesh.radius[b] - clearly * std::min(mesh.radius[a], mesh.radius[b]);
      const double beside_a = f.field.element_length(a), beside_b = f.field.element_length(b);
      for (std::size_t i = 0; i < curves[a].size(); ++i)
        for (std::size_t j = 0; j < curves[b].size(); ++j) {
          if ((curves[b][j] - curves[a][i]).squaredNorm() > touching * touching) continue;
          const double s_a = step * mesh.radius[a] * static_cast<double>(i),
                       s_b = step * mesh.radius[b] * static_cast<double>(j);
          missed += std::none_of(found.begin(), found.end(), [&](const Proximity& p) {
            return p.fiber_a() == a && p.fiber_b() == b && std::abs(p.s_a() - s_a) <= beside_a + touching &&
                   std::abs(p.s_b() - s_b) <= beside_b + touching;
          });
        }
    }
  return missed;
}

/// Every proximity is what it says: a chord that is normal to what it must be, in reach.
void expect_true_chords(const Fibers& f, const ProximitySearch& search, const std::vector<Proximity>& found) {
  const FiberMesh& mesh = f.field.mesh();
  for (const Proximity& p : found) {
    const Chord& c = p.chord;
    const double sum = mesh.radius[c.a.fiber] + mesh.radius[c.b.fiber];
    EXPECT_LE(c.c.norm(), sum * (1 + 0.5 * search.search_margin) * (1 + 1e-9));
    EXPECT_LT((f.field.curve(f.state, c.b.fiber, c.b.s).r - f.field.curve(f.state, c.a.fiber, c.a.s).r - c.c).norm(),
              1e-9 * sum);
    EXPECT_GT(p.length, 0);
    for (int i = 0; i < c.n_free; ++i) EXPECT_NEAR(c.slope().dot(c.free[i]), 0, 1e-6 * sum) << "point " << p.point;
    if (!p.point) {
      EXPECT_NEAR(0.5 * (c.a.s + p.hold.sense * c.b.s), p.hold.mean_arc_length, 1e-9 * sum);
    }
  }
}

void compare_with_oracle(const Fibers& f, const ProximitySearch& search) {
  const std::vector<Proximity> found = find_proximities(f.field, f.state, search);
  ASSERT_FALSE(found.empty());
  expect_true_chords(f, search, found);
  EXPECT_EQ(count_missed(f, found), 0);
}

/// Random curved fibers in a box: `spread` from the direction of x, to either side of it.
std::vector<std::vector<Vec3>> random_fibers(int n, double box, double spread, bool antiparallel, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto random_vector = [&] { return Vec3(uniform(generator), uniform(generator), uniform(generator)); };
  std::vector<std::vector<Vec3>> fibers;
  for (int i = 0; i < n; ++i) {
    const Vec3 centre = box * Vec3(0, uniform(generator), uniform(generator)) + random_vector();
    const Vec3 direction = (Vec3::UnitX() + spread * random_vector()).normalized();
    std::vector<Vec3> points;
    for (const double t : {-12.0, -4.0, 4.0, 12.0}) points.push_back(centre + t * direction + 0.3 * random_vector());
    if (antiparallel && i % 2 == 1) std::reverse(points.begin(), points.end());
    fibers.push_back(points);
  }
  return fibers;
}

TEST(Proximity, MeetsTheOracleForFibersSideBySide) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod})
    for (const bool antiparallel : {false, true})
      for (const std::uint32_t seed : {1u, 2u, 3u}) {
        const Fibers f(model, random_fibers(10, 4, 0.05, antiparallel, seed), {6});
        compare_with_oracle(f, {});
      }
}

TEST(Proximity, MeetsTheOracleForElementsOfDifferentLengths) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod})
    compare_with_oracle(Fibers(model, random_fibers(10, 4, 0.05, true, 4), {3, 5, 16}), {});
}

TEST(Proximity, MeetsTheOracleForFibersThatCross) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    // Three layers, each at 60° to the one below, with waves: crossings only, but for neighbours within a layer.
    std::vector<std::vector<Vec3>> fibers;
    for (int layer = 0; layer < 3; ++layer)
      for (int i = 0; i < 4; ++i) {
        const double turn = layer * std::numbers::pi / 3;
        const Vec3 along(std::cos(turn), std::sin(turn), 0), side(-along.y(), along.x(), 0);
        std::vector<Vec3> points;
        for (const double t : {-12.0, -4.0, 4.0, 12.0})
          points.push_back(t * along + (5.0 * i - 7.5) * side + Vec3(0, 0, 2.0 * layer + 0.3 * uniform(generator)));
        fibers.push_back(points);
      }
    compare_with_oracle(Fibers(model, fibers, {6}), {});
  }
}

TEST(Proximity, SamplesKeepTheirPlaceAndSpacing) {
  const Fibers f(FiberModel::rod, {{{0, 0, 0}, {20, 0, 0}}, {{0, 2.1, 0}, {20, 2.1, 0}}}, {10});
  ProximitySearch search;
  search.spacing = 0.5;  // of elements of length 2
  const auto found = find_proximities(f.field, f.state, search);
  ASSERT_EQ(found.size(), 20u);
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(found[i].s_a(), std::floor(found[i].s_a()) + 0.5, 1e-9);
    EXPECT_NEAR(found[i].s_a(), found[i].s_b(), 1e-9);
    EXPECT_LT((found[i].chord.c - Vec3(0, 2.1, 0)).norm(), 1e-9);
    EXPECT_NEAR(found[i].length, 1, 1e-9);
    EXPECT_FALSE(found[i].point);
  }
}

TEST(Proximity, AKnownPointStaysOnLevelGroundAndLosesItsShareSlowly) {
  const Fibers f(FiberModel::rod, {{{0, 0, 0}, {20, 0, 0}}, {{0, 2.1, 0}, {20, 2.1, 0}}}, {10});
  ProximitySearch search;
  search.spacing = 0.5;  // of elements of length 2
  const double length = 0.5 * 2;  // a share of a half, of the sum of the radii
  const std::vector<KnownPoint> known{{0, 1, {}, 7.3, 7.3, length}};
  const auto found = find_proximities(f.field, f.state, search, known);
  const auto point = std::find_if(found.begin(), found.end(), [](const Proximity& p) { return p.point; });
  ASSERT_NE(point, found.end());
  EXPECT_EQ(found.size(), 21u);
  EXPECT_NEAR(point->s_a(), 7.3, 1e-6);
  EXPECT_NEAR(point->s_b(), 7.3, 1e-6);
  EXPECT_NEAR(point->length, 0.9 * length, 1e-9);
  const auto beside = std::find_if(found.begin(), found.end(), [](const Proximity& p) {
    return !p.point && std::abs(p.s_a() - 7.5) < 1e-6;
  });
  ASSERT_NE(beside, found.end());
  EXPECT_NEAR(beside->share, 1 - 0.45, 1e-6);
}

TEST(Proximity, RespectsTheMarginAndTheWantedPairs) {
  const auto fibers_at = [](double distance) {
    return Fibers(FiberModel::enriched, {{{0, 0, 0}, {20, 0, 0}}, {{0, distance, 0}, {20, distance, 0}}}, {5});
  };
  ProximitySearch search;
  search.search_margin = 0.5;
  const Fibers inside = fibers_at(2.49), outside = fibers_at(2.51);
  EXPECT_FALSE(find_proximities(inside.field, inside.state, search).empty());
  EXPECT_TRUE(find_proximities(outside.field, outside.state, search).empty());
  search.wanted = [](Index, Index) { return false; };
  EXPECT_TRUE(find_proximities(inside.field, inside.state, search).empty());
}

TEST(Proximity, AFiberMeetsItselfOnlyWhereAsked) {
  // A hairpin: two straight legs, 2.2 apart, and a bend.
  std::vector<Vec3> hairpin;
  for (int i = 0; i <= 10; ++i) hairpin.emplace_back(2.0 * i, 0, 0);
  for (int i = 1; i <= 5; ++i)
    hairpin.emplace_back(20 + 1.1 * std::sin(i * std::numbers::pi / 6), 1.1 - 1.1 * std::cos(i * std::numbers::pi / 6),
                         0);
  for (int i = 10; i >= 0; --i) hairpin.emplace_back(2.0 * i, 2.2, 0);
  const Fibers f(FiberModel::rod, {hairpin}, {24});
  ProximitySearch search;
  EXPECT_TRUE(find_proximities(f.field, f.state, search).empty());
  search.self_contact = true;
  const auto found = find_proximities(f.field, f.state, search);
  ASSERT_GT(found.size(), 10u);
  for (const Proximity& p : found) {
    EXPECT_LT(p.s_a(), p.s_b());
    EXPECT_NEAR(p.chord.c.norm(), 2.2, 0.3);
  }
}

/// An arc of curvature κ that turns toward +z or −z, at an angle to x in plan view; a straight line for κ = 0.
std::vector<Vec3> arc(double kappa, double half_length, double angle, double z, double toward) {
  std::vector<Vec3> points;
  for (int i = -12; i <= 12; ++i) {
    const double s = half_length * i / 12;
    const double along = kappa > 0 ? std::sin(kappa * s) / kappa : s;
    const double up = kappa > 0 ? (1 - std::cos(kappa * s)) / kappa : 0;
    points.emplace_back(along * std::cos(angle), along * std::sin(angle), z + toward * up);
  }
  return points;
}

TEST(Proximity, NoContactOfCurvedFibersIsMissed) {
  // Hooked into each other, or back to back, at all angles; thin ones around thick ones.
  std::mt19937 generator(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod})
    for (int n = 0; n < 60; ++n) {
      const double thick = std::pow(100, uniform(generator)), kappa_a = 0.5 * uniform(generator),
                   kappa_b = 0.5 * uniform(generator) / thick, angle = 0.5 * std::numbers::pi * uniform(generator);
      const double distance = (1 + thick) * (1 - 0.02 * uniform(generator)) - 0.02;
      const bool hooked = n % 2 == 0;
      const double half_a = std::min(12.0, 2.0 / kappa_a), half_b = std::min(12.0 * thick, 2.0 / kappa_b);
      const Fibers f(
          model, {arc(kappa_a, half_a, 0, distance, hooked ? -1 : 1), arc(kappa_b, half_b, angle, 0, hooked ? 1 : -1)},
          {12, 16}, {1, thick});
      SCOPED_TRACE(testing::Message() << "scene " << n << ": kappa " << kappa_a << ", " << kappa_b << ", angle "
                                      << angle << ", radius " << thick);
      compare_with_oracle(f, {});
    }
}

TEST(Proximity, FibersThatWindAroundOthersTouchThemAlongALineAtAnyAngle) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod})
    for (const double core : {1.0, 5.0})
      for (const double lay : {5.0, 15.0, 29.0, 31.0, 45.0, 60.0, 75.0, 85.0}) {
        const double beta = lay * std::numbers::pi / 180, radius = core + 0.99,
                     pitch = 2 * std::numbers::pi * radius / std::tan(beta);
        constexpr int n_points = 64;
        const double turns = 1.5;
        std::vector<Vec3> helix;
        for (int i = 0; i <= n_points; ++i) {
          const double t = 2 * std::numbers::pi * turns * i / n_points;
          helix.emplace_back(pitch * turns * i / n_points, radius * std::cos(t), radius * std::sin(t));
        }
        const Fibers f(model, {{{-0.1, 0, 0}, {pitch * turns + 0.1, 0, 0}}, helix}, {16, 32}, {core, 1});
        SCOPED_TRACE(testing::Message() << "lay angle " << lay << ", core " << core);
        compare_with_oracle(f, {});
        double length = 0;
        for (const Proximity& p : find_proximities(f.field, f.state, {})) length += p.point ? 0 : p.length;
        // Mean arc length of the whole stretch.
        EXPECT_NEAR(length, 0.5 * (pitch * turns + pitch * turns / std::cos(beta)), 0.05 * length);
      }
}

TEST(Proximity, TwoPlacesOfOnePairAreBothFound) {
  // A wave that comes near a straight fiber at both of its ends, but not in the middle.
  const Fibers f(FiberModel::rod,
                 {{{0, 0, 0}, {40, 0, 0}}, {{0, 2.1, 0}, {8, 2.3, 0}, {20, 5, 0}, {32, 2.3, 0}, {40, 2.1, 0}}}, {16});
  compare_with_oracle(f, {});
  const auto found = find_proximities(f.field, f.state, {});
  EXPECT_LT(found.front().s_a(), 2);
  EXPECT_GT(found.back().s_a(), 38);
}

}  // namespace
}  // namespace trame::micro
