#include "micro/weave/flat_start.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

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

}  // namespace
}  // namespace trame::micro
