/// Places along a yarn that have a name.

#include "meso/sections/places.h"

#include <gtest/gtest.h>

#include <utility>

#include "tests/support/lattice_yarns.h"

namespace trame::meso {
namespace {

using micro::FiberConfiguration;
using micro::test::LatticeYarns;

/// Two yarns that cross at right angles; the second one, a weft, runs along y, `height` above the first.
FiberConfiguration crossing_yarns(const LatticeYarns& yarns, double height) {
  FiberConfiguration fibers = yarns.configuration();
  const std::size_t half = fibers.r.size() / 2;
  const double across = fibers.r[half].y();
  for (std::size_t n = half; n < fibers.r.size(); ++n) {
    const Vec3 x = fibers.r[n];
    // Its middle lands a quarter of the way along the first yarn.
    fibers.r[n] = {x.y() - across + 2.5, x.x() - 5, x.z() + height};
    fibers.tangent[n] = Vec3::UnitY();
    fibers.g1[n] = -Vec3::UnitX();
  }
  return fibers;
}

TEST(Places, AreWhereYarnsCrossAndSayWhichIsAbove) {
  const LatticeYarns yarns{.n_yarns = 2, .n_rows = 1, .n_columns = 1};
  for (const auto& [height, label] : {std::pair{3.0, "under weft/1"}, {-3.0, "over weft/1"}}) {
    const std::vector<Place> found = places(yarns.mesh(), crossing_yarns(yarns, height), 0, 7);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_NEAR(found[0].fraction, 0.25, 1e-9);
    EXPECT_EQ(found[0].label, label);
  }
}

TEST(Places, AreNoneOfAYarnThatCrossesNone) {
  const LatticeYarns yarns{.n_yarns = 2};
  EXPECT_TRUE(places(yarns.mesh(), yarns.configuration(), 0, 7).empty());
}

}  // namespace
}  // namespace trame::meso
