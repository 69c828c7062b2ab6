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

constexpr double crossing_angle = std::numbers::pi / 6;

/// Fibers of radius 1; `n_elements` is used in turn.
struct Fibers {
  Fibers(FiberModel model, const std::vector<std::vector<Vec3>>& curves, const std::vector<Index>& n_elements)
      : assembly(make_assembly(model, curves, n_elements)),
        field(assembly.mesh, std::vector(curves.size(), model), layout) {
    state.q.assign(layout.n_vectors(), Vec3::Zero());
    field.read_configuration(assembly.configuration, state);
  }
  static Assembly make_assembly(FiberModel model, const std::vector<std::vector<Vec3>>& curves,
                                const std::vector<Index>& n_elements) {
    Scene scene;
    scene.materials = {{"m", 1, 1, 0.4, 0.25, 0.25}};
    scene.fiber_types = {{"f", 0, 1.0, model}};
    for (std::size_t i = 0; i < curves.size(); ++i)
      scene.fibers.push_back({std::to_string(i), 0, curves[i], n_elements[i % n_elements.size()], {}});
    return assemble_scene(scene);
  }
  Assembly assembly;
  Layout layout;
  FiberField field;
  State state;
};

double angle(const Vec3& a, const Vec3& b) {
  return std::acos(std::clamp(std::abs(a.dot(b)) / (a.norm() * b.norm()), 0.0, 1.0));
}

/// Samples of the intermediate geometries of two fibers: for each sense and each mean arc length τ = k·spacing the
/// half-differences u at which c(u) = chord · mean tangent changes sign, refined by bisection.
std::vector<Proximity> side_by_side(const Fibers& f, Index a, Index b, const ProximitySearch& search) {
  const double length_a = f.assembly.mesh.length(a), length_b = f.assembly.mesh.length(b);
  const double spacing = search.spacing * 0.5 * (f.field.element_length(a) + f.field.element_length(b));
  const double reach = 2 + search.search_margin;
  std::vector<Proximity> found;
  for (const int sense : {1, -1}) {
    const auto evaluate = [&](double tau, double u, Proximity& p) {
      p.s_a = tau + u;
      p.s_b = sense * (tau - u);
      const auto ca = f.field.curve(f.state, a, p.s_a), cb = f.field.curve(f.state, b, p.s_b);
      p.chord = cb.r - ca.r;
      return p.chord.dot(ca.tangent + sense * cb.tangent);
    };
    for (auto k = static_cast<int>(std::floor(-length_b / spacing)); k * spacing <= length_a + length_b; ++k) {
      const double tau = k * spacing;
      // 0 ≤ s_a ≤ length_a and 0 ≤ s_b ≤ length_b.
      const double first = std::max(-tau, sense > 0 ? tau - length_b : tau);
      const double last = std::min(length_a - tau, sense > 0 ? tau : tau + length_b);
      const int n_cells = first < last ? static_cast<int>(std::ceil((last - first) / 0.1)) : 0;
      for (int cell = 0; cell < n_cells; ++cell) {
        Proximity p{a, b, 0, 0, Vec3::Zero(), spacing, false};
        double low = first + (last - first) * cell / n_cells, high = first + (last - first) * (cell + 1) / n_cells;
        const double c_low = evaluate(tau, low, p), c_high = evaluate(tau, high, p);
        if (c_low * c_high > 0) continue;
        for (int i = 0; i < 60; ++i) {
          const double middle = 0.5 * (low + high);
          (evaluate(tau, middle, p) * c_low > 0 ? low : high) = middle;
        }
        evaluate(tau, 0.5 * (low + high), p);
        const Vec3 t_a = f.field.curve(f.state, a, p.s_a).tangent, t_b = f.field.curve(f.state, b, p.s_b).tangent;
        if (p.chord.norm() <= reach && sense * t_a.dot(t_b) > 0 && angle(t_a, t_b) < crossing_angle) found.push_back(p);
      }
    }
  }
  return found;
}

/// Local minima of the distance of two fibers that cross there at more than 30°.
std::vector<Proximity> crossings(const Fibers& f, Index a, Index b, const ProximitySearch& search) {
  const double step = 0.1;
  const auto n_a = static_cast<int>(f.assembly.mesh.length(a) / step),
             n_b = static_cast<int>(f.assembly.mesh.length(b) / step);
  std::vector<Vec3> r_a, r_b;
  for (int i = 0; i <= n_a; ++i) r_a.push_back(f.field.curve(f.state, a, i * step).r);
  for (int j = 0; j <= n_b; ++j) r_b.push_back(f.field.curve(f.state, b, j * step).r);
  const auto d = [&](int i, int j) { return (r_b[j] - r_a[i]).norm(); };
  std::vector<Proximity> found;
  for (int i = 1; i < n_a; ++i)
    for (int j = 1; j < n_b; ++j) {
      const double here = d(i, j);
      if (here > 2 + search.search_margin) continue;
      bool smallest = true;
      for (int di = -1; di <= 1; ++di)
        for (int dj = -1; dj <= 1; ++dj) smallest = smallest && here <= d(i + di, j + dj);
      const Vec3 t_a = f.field.curve(f.state, a, i * step).tangent, t_b = f.field.curve(f.state, b, j * step).tangent;
      if (smallest && angle(t_a, t_b) > crossing_angle)
        found.push_back({a, b, i * step, j * step, r_b[j] - r_a[i], 2, true});
    }
  return found;
}

/// Every proximity of the oracle is found, and nothing else: with a tolerance in s that is the oracle's own.
void expect_same(const std::vector<Proximity>& fast, const std::vector<Proximity>& oracle, bool crossing,
                 double tolerance) {
  std::size_t n_fast = 0;
  const auto near = [&](const Proximity& p, const Proximity& q) {
    return p.fiber_a == q.fiber_a && p.fiber_b == q.fiber_b && std::abs(p.s_a - q.s_a) < tolerance &&
           std::abs(p.s_b - q.s_b) < tolerance;
  };
  for (const Proximity& p : fast) {
    if (p.crossing != crossing) continue;
    ++n_fast;
    EXPECT_TRUE(std::any_of(oracle.begin(), oracle.end(), [&](const Proximity& q) { return near(p, q); }))
        << "made up: fibers " << p.fiber_a << " " << p.fiber_b << " at " << p.s_a << " " << p.s_b << " distance "
        << p.chord.norm();
  }
  for (const Proximity& q : oracle)
    EXPECT_TRUE(
        std::any_of(fast.begin(), fast.end(), [&](const Proximity& p) { return p.crossing == crossing && near(p, q); }))
        << "missed: fibers " << q.fiber_a << " " << q.fiber_b << " at " << q.s_a << " " << q.s_b << " distance "
        << q.chord.norm();
  EXPECT_EQ(n_fast, oracle.size());
}

void compare_with_oracle(const Fibers& f, const ProximitySearch& search) {
  const std::vector<Proximity> fast = find_proximities(f.field, f.state, search);
  std::vector<Proximity> beside, across;
  for (Index a = 0; a < f.assembly.mesh.n_fibers(); ++a)
    for (Index b = a + 1; b < f.assembly.mesh.n_fibers(); ++b) {
      for (const Proximity& p : side_by_side(f, a, b, search)) beside.push_back(p);
      for (const Proximity& p : crossings(f, a, b, search)) across.push_back(p);
    }
  ASSERT_FALSE(beside.empty() && across.empty());
  expect_same(fast, beside, false, 1e-6);
  expect_same(fast, across, true, 0.15);
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
  ASSERT_GE(found.size(), 19u);
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(found[i].s_a, std::round(found[i].s_a), 1e-9);
    EXPECT_NEAR(found[i].s_a, found[i].s_b, 1e-9);
    EXPECT_LT((found[i].chord - Vec3(0, 2.1, 0)).norm(), 1e-9);
    EXPECT_DOUBLE_EQ(found[i].length, 1);
    EXPECT_FALSE(found[i].crossing);
  }
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
    EXPECT_LT(p.s_a, p.s_b);
    EXPECT_NEAR(p.chord.norm(), 2.2, 0.3);
  }
}

TEST(Proximity, TwoPlacesOfOnePairAreBothFound) {
  // A wave that comes near a straight fiber at both of its ends, but not in the middle.
  const Fibers f(FiberModel::rod,
                 {{{0, 0, 0}, {40, 0, 0}}, {{0, 2.1, 0}, {8, 2.3, 0}, {20, 5, 0}, {32, 2.3, 0}, {40, 2.1, 0}}}, {16});
  compare_with_oracle(f, {});
  const auto found = find_proximities(f.field, f.state, {});
  EXPECT_LT(found.front().s_a, 2);
  EXPECT_GT(found.back().s_a, 38);
}

}  // namespace
}  // namespace trame::micro
