#include "micro/scene/yarn_section.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace trame::micro {
namespace {

double smallest_distance(const std::vector<Vec2>& points) {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) smallest = std::min(smallest, (points[i] - points[j]).norm());
  return smallest;
}

TEST(HexagonalSection, KeepsNeighboursOneSpacingApart) {
  for (const Index layers : {0, 1, 2, 3, 4})
    for (Index n = 2; n <= 50; ++n) {
      if (n < layers) continue;
      const auto points = hexagonal_section(n, layers, 2.1);
      ASSERT_EQ(points.size(), static_cast<std::size_t>(n));
      EXPECT_NEAR(smallest_distance(points), 2.1, 1e-12) << n << " fibers in " << layers << " layers";
    }
}

TEST(HexagonalSection, IsCentred) {
  for (const Index layers : {0, 2, 3}) {
    Vec2 sum = Vec2::Zero();
    for (const Vec2& p : hexagonal_section(7, layers, 1)) sum += p;
    EXPECT_LT(sum.norm(), 1e-13);
  }
}

TEST(RandomSection, FillsItsOutlineWithFibersThatDoNotOverlap) {
  for (const double fraction : {0.3, 0.5, 0.65})
    for (const Index n : {7, 19, 40, 150}) {
      const auto points = random_section(n, 0, fraction, 1);
      ASSERT_TRUE(points) << n << " fibers, " << fraction;
      ASSERT_EQ(points->size(), static_cast<std::size_t>(n));
      EXPECT_GE(smallest_distance(*points), 2);
      double farthest = 0;
      for (const Vec2& p : *points) farthest = std::max(farthest, p.norm());
      EXPECT_LE(n / (farthest + 1) / (farthest + 1), fraction * 1.7);  // in use, not a knot in its middle
      EXPECT_GE(n / (farthest + 1) / (farthest + 1), fraction * (1 - 1e-9));
    }
}

TEST(RandomSection, OfLayersIsFlat) {
  const auto points = random_section(44, 4, 0.6, 3);
  ASSERT_TRUE(points);
  EXPECT_GE(smallest_distance(*points), 2);
  Vec2 most = Vec2::Zero();
  for (const Vec2& p : *points) most = most.cwiseMax(p.cwiseAbs());
  most += Vec2::Ones();
  EXPECT_GT(most[0], 2.5 * most[1]);
  EXPECT_LE(std::numbers::pi * 44 / 0.6, 4 * most[0] * most[1] * 1.1);
  EXPECT_GE(std::numbers::pi * 44 / 0.6, 4 * most[0] * most[1] * (1 - 1e-9));
}

TEST(RandomSection, IsTheSameForTheSameSeedAndScales) {
  YarnKind kind{.n_fibers = 12, .volume_fraction = 0.6, .seed = 5};
  const auto here = yarn_section(kind, 1, 2), there = yarn_section(kind, 9.5e-6, 2), other = yarn_section(kind, 1, 3);
  for (std::size_t i = 0; i < here.size(); ++i) EXPECT_LT((here[i] * 9.5e-6 - there[i]).norm(), 1e-18);
  EXPECT_GT((here[0] - other[0]).norm(), 1e-3);
}

TEST(RandomSection, ThatIsTooFullIsNotFound) {
  EXPECT_FALSE(random_section(2, 0, 0.6, 1));  // two circles fill half of the one around them
  EXPECT_FALSE(random_section(40, 0, 0.88, 1));
}

/// By trying: the smallest distance of fibers of two yarns whose axes are this far apart.
double gap(const YarnKind& a, double radius_a, const YarnKind& b, double radius_b, double spacing) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vec2& p : yarn_section(a, radius_a, 0))
    for (const Vec2& q : yarn_section(b, radius_b, 0))
      least = std::min(least, (p - q - Vec2(spacing, 0)).norm() - radius_a - radius_b);
  return least;
}

TEST(LeastYarnSpacing, IsWhereFibersTouch) {
  for (const Index n : {1, 7, 8, 23, 24})
    for (const Index layers : {0, 1, 2, 3})
      for (const double other : {1.0, 0.6}) {
        if (layers > n) continue;
        const YarnKind a{.n_fibers = n, .n_layers = layers}, b{.n_fibers = 7};
        const double spacing = least_yarn_spacing(a, 1, b, other);
        EXPECT_NEAR(gap(a, 1, b, other, spacing), 0, 1e-9) << n << " " << layers << " " << other;
        for (const double wider : {1.01, 1.3}) EXPECT_GT(gap(a, 1, b, other, wider * spacing), 0);
      }
}

TEST(LeastYarnSpacing, OfTwistedAndRandomYarnsIsThatOfTheirOutlines) {
  const YarnKind twisted{.n_fibers = 7, .twist = 1}, random{.n_fibers = 12, .volume_fraction = 0.5};
  EXPECT_NEAR(least_yarn_spacing(twisted, 1, twisted, 1), 2 * (2.1 + 1), 1e-9);
  EXPECT_NEAR(least_yarn_spacing(twisted, 1, random, 1), 3.1 + std::sqrt(12 / 0.5), 1e-9);
}

}  // namespace
}  // namespace trame::micro
