#include "meso/bands/orientation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "meso/bands/band_survey.h"
#include "tests/support/lattice_yarns.h"

namespace trame::meso {
namespace {

constexpr double pixels = 8;  // per fiber distance

/// A picture of 40 × 12 fiber distances.
template <class Value>
Picture picture(Value&& value) {
  Picture result(12 * int(pixels), 40 * int(pixels));
  for (Eigen::Index r = 0; r < result.rows(); ++r)
    for (Eigen::Index c = 0; c < result.cols(); ++c) result(r, c) = value(double(c) / pixels, double(r) / pixels);
  return result;
}

std::array<double, DirectionalCorrelation::n_directions> correlation(const Picture& values) {
  DirectionalCorrelation correlation;
  correlation.add(values, pixels);
  return correlation.values();
}

/// Stripes sin(2π s / 3), s: the distance across: cos(2π · 2 sin(difference of angles) / 3) a lag of 2 away.
TEST(DirectionalCorrelation, OfStripes) {
  for (const double stripe : {-60.0, 0.0, 45.0, 90.0}) {
    const double a = stripe * std::numbers::pi / 180;
    const auto found = correlation(picture(
        [&](double x, double y) { return std::sin(2 * std::numbers::pi / 3 * (y * std::cos(a) - x * std::sin(a))); }));
    for (std::size_t k = 0; k < found.size(); ++k) {
      const double difference = (DirectionalCorrelation::angle(k) - stripe) * std::numbers::pi / 180;
      const double across = DirectionalCorrelation::lag * std::sin(difference);
      // Lags are rounded to pixels: up to 0.09 in s, and the picture does not hold whole stripes.
      EXPECT_NEAR(found[k], std::cos(2 * std::numbers::pi / 3 * across), 0.2) << stripe << " " << k;
    }
  }
}

/// Crossing stripes at ±60°: half the sum of the two, which is largest along both. 2 · sin 60° = √3 across at 0° and
/// from one to the other, 1 at 90°.
TEST(DirectionalCorrelation, OfCrossingStripes) {
  const double a = std::numbers::pi / 3, third = 2 * std::numbers::pi / 3;
  const auto found = correlation(picture([&](double x, double y) {
    const double s = y * std::cos(a), t = x * std::sin(a);
    return std::sin(third * (s - t)) + std::sin(third * (s + t));
  }));
  for (const std::size_t along : {1, 9})  // ∓60°
    EXPECT_NEAR(found[along], 0.5 * (1 + std::cos(third * std::sqrt(3.0))), 0.2);
  EXPECT_NEAR(found[5], std::cos(third * std::sqrt(3.0)), 0.2);  // 0°
  EXPECT_NEAR(found[11], std::cos(third), 0.2);                  // 90°
}

TEST(DirectionalCorrelation, NothingToCorrelate) {
  const auto none = correlation(Picture::Constant(5, 5, std::numeric_limits<double>::quiet_NaN()));
  for (const double x : none) EXPECT_TRUE(std::isnan(x));
}

/// Fibers each displaced at random strain all cells around them, but that does not reach as far as the lag: over the
/// cuts of a long yarn of 4 layers no direction stands out. The mean of each cut, of some 20 independent cells, is
/// taken off: that alone makes −1/20.
TEST(DirectionalCorrelation, DisorderHasNone) {
  const micro::test::LatticeYarns yarns{.n_rows = 4, .n_columns = 11, .n_elements = 40, .length = 80};
  const micro::FiberConfiguration a = yarns.configuration();
  micro::FiberConfiguration b = a;
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 0.03);
  for (Vec3& r : b.r) r += Vec3(0, normal(random), normal(random));
  const micro::FiberMesh fibers = yarns.mesh();
  const YarnMesh mesh = mesh_yarn(fibers, 0, a.r);
  const DeformationGradient gradient(mesh);
  const StrainField field = strain_between(mesh, gradient(a.r), gradient(b.r), a.tangent);
  DirectionalCorrelation correlation;
  for (const Section& section : YarnSections(fibers, fibers.yarns[0], a).series(40))
    correlation.add(sample(cut_yarn(mesh, a.r, section_plane(section)), field.gamma_max), 4);
  for (const double x : correlation.values()) {
    EXPECT_LT(x, 0.1);
    EXPECT_GT(x, -0.2);
  }
}

}  // namespace
}  // namespace trame::meso
