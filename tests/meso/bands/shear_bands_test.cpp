#include "meso/bands/shear_bands.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "meso/bands/shear_zones.h"
#include "micro/core/error.h"
#include "tests/support/lattice_yarns.h"

namespace trame::meso {
namespace {

using micro::test::input_error;
using micro::test::LatticeYarns;

constexpr double distance = 2e-5;  // between fibers, m
constexpr double shear = 0.2;      // in a band
constexpr double offset = 0.05;    // everywhere, so that shares and contrasts have something to be compared with

/// γ_max of a simple shear k.
double gamma_of(double k) { return 2 * std::sqrt(k * k / 4 + k * k * k * k / 16); }

double angle_error(double angle, double expected) { return std::abs(std::remainder(angle - expected, 180)); }

struct Band {
  double angle = 0;            ///< degrees
  double width = 0;            ///< fiber distances
  Vec2 centre = Vec2::Zero();  ///< from the middle of the section, fiber distances
};

/// A yarn whose fibers lie on a lattice up to 2 % of their distance, as after any computation.
class ShearedYarn {
 public:
  ShearedYarn(Index n_rows, Index n_columns)
      : yarns_{.n_rows = n_rows, .n_columns = n_columns, .n_elements = 6, .spacing = distance, .length = 1.2e-3} {
    std::mt19937 random(5);
    std::normal_distribution<double> normal(0, 0.02 * distance);
    for (Vec3& r : reference_.r) r += Vec3(0, normal(random), normal(random));
    mesh_ = mesh_yarn(fibers_, 0, reference_.r);
    const Section section = YarnSections(fibers_, fibers_.yarns[0], reference_).at_fraction(0.47);
    middle_ = section.origin;
    cut_ = cut_yarn(mesh_, reference_.r, section_plane(section));
  }

  /// Simple shear confined to bands, along them: each adds a displacement that grows from one side to the other.
  [[nodiscard]] StrainField sheared(const std::vector<Band>& bands) const {
    auto r = reference_.r;
    for (std::size_t n = 0; n < r.size(); ++n)
      for (const Band& band : bands) {
        const double a = band.angle * std::numbers::pi / 180;
        const double s = across(band, reference_.r[n]);
        const double half = band.width * distance / 2;
        r[n] += shear * std::clamp(s, -half, half) * Vec3(0, std::cos(a), std::sin(a));
      }
    const DeformationGradient gradient(mesh_);
    return strain_between(mesh_, gradient(reference_.r), gradient(r), reference_.tangent);
  }

  /// γ_max of the bands on top of a constant, with noise of a share of the bands' shear in each tetrahedron.
  [[nodiscard]] std::vector<double> values(const std::vector<Band>& bands, double noise = 0, unsigned seed = 1) const {
    std::vector<double> values = sheared(bands).gamma_max;
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0, noise * shear);
    for (double& x : values) x += offset + (noise > 0 ? normal(random) : 0);
    return values;
  }

  /// Distance of a point across a band's middle, m.
  [[nodiscard]] double across(const Band& band, const Vec3& point) const {
    const double a = band.angle * std::numbers::pi / 180;
    const Vec3 centre = middle_ + distance * Vec3(0, band.centre.x(), band.centre.y());
    return Vec3(0, -std::sin(a), std::cos(a)).dot(point - centre);
  }

  /// Of a tetrahedron's centre: −1 at one side of the section, 1 at the other.
  [[nodiscard]] double position_over_width(std::size_t tet) const {
    double y = 0;
    for (const Index v : mesh_.tets[tet]) y += mesh_.reference[v].y() / 4;
    return (y - middle_.y()) / (0.5 * double(cut_.n_columns()) * cut_.pixel);
  }

  [[nodiscard]] const YarnMesh& mesh() const { return mesh_; }
  [[nodiscard]] const YarnCut& cut() const { return cut_; }
  [[nodiscard]] const std::vector<Vec3>& positions() const { return reference_.r; }

 private:
  LatticeYarns yarns_;
  micro::FiberMesh fibers_ = yarns_.mesh();
  micro::FiberConfiguration reference_ = yarns_.configuration();
  YarnMesh mesh_;
  YarnCut cut_;
  Vec3 middle_;
};

/// 12 × 20 fibers, 11.5 × 16.5 fiber distances; made once.
const ShearedYarn& large() {
  static const ShearedYarn yarn(20, 12);
  return yarn;
}

const ShearBandOptions no_shuffles{.n_shuffles = 0};

TEST(ShearBands, StrainInTheBandIsThatOfSimpleShear) {
  const Band band{.angle = 30, .width = 4};
  const StrainField field = large().sheared({band});
  Index n_in = 0, n_out = 0;
  for (std::size_t t = 0; t < large().mesh().tets.size(); ++t) {
    double nearest = 1e9, farthest = 0, low = 1e9, high = -1e9;
    for (const Index v : large().mesh().tets[t]) {
      const double s = large().across(band, large().mesh().reference[v]) / distance;
      nearest = std::min(nearest, std::abs(s));
      farthest = std::max(farthest, std::abs(s));
      low = std::min(low, s);
      high = std::max(high, s);
    }
    if (farthest <= 2) {
      EXPECT_NEAR(field.gamma_max[t], gamma_of(shear), 1e-9);
      ++n_in;
    } else if (nearest >= 2 && low * high > 0) {
      EXPECT_NEAR(field.gamma_max[t], 0, 1e-9);
      ++n_out;
    }
  }
  EXPECT_GT(n_in, 500);
  EXPECT_GT(n_out, 500);
}

class OneBand : public ::testing::TestWithParam<Band> {};

TEST_P(OneBand, IsMeasured) {
  const ShearBands found = find_shear_bands(large().cut(), large().values({GetParam()}));
  ASSERT_EQ(found.bands.size(), 1u);
  const ShearBand& band = found.bands[0];
  EXPECT_TRUE(band.significant);
  EXPECT_GE(band.p_value, 1.0 / 200);
  EXPECT_LT(angle_error(band.angle, GetParam().angle), 2);
  EXPECT_NEAR(band.thickness / GetParam().width, 1, 0.15);
  EXPECT_LT(band.centre.norm(), 0.5 * distance);
  EXPECT_GT(band.straightness, 0.85);
  EXPECT_DOUBLE_EQ(band.aspect, band.length / band.thickness);
}

/// Independent noise in each tetrahedron, of a share of the band's shear: rms of the angles' errors, mean of the
/// thicknesses.
TEST_P(OneBand, IsMeasuredInNoise) {
  constexpr int n_seeds = 4;
  for (const double noise : {0.1, 0.2, 0.3}) {
    double squares = 0, ratio = 0;
    for (unsigned seed = 1; seed <= n_seeds; ++seed) {
      const auto values = large().values({GetParam()}, noise, seed);
      const ShearBands found = find_shear_bands(large().cut(), values, no_shuffles);
      ASSERT_FALSE(found.bands.empty());
      squares += std::pow(angle_error(found.bands[0].angle, GetParam().angle), 2);
      ratio += found.bands[0].thickness / GetParam().width / n_seeds;
    }
    EXPECT_LT(std::sqrt(squares / n_seeds), 2) << "noise " << noise;
    EXPECT_NEAR(ratio, 1, 0.15) << "noise " << noise;
    EXPECT_TRUE(find_shear_bands(large().cut(), large().values({GetParam()}, noise)).bands[0].significant);
  }
}

INSTANTIATE_TEST_SUITE_P(Angles, OneBand,
                         ::testing::Values(Band{0, 2}, Band{20, 2}, Band{45, 2}, Band{70, 2}, Band{90, 2}, Band{-30, 2},
                                           Band{0, 3}, Band{20, 3}, Band{45, 3}, Band{70, 3}, Band{90, 3},
                                           Band{-30, 3}));

/// Below the size of a mesh cell a band is found, but looks as thick as the cell.
TEST(ShearBands, ThinBandLooksAsThickAsACell) {
  const ShearBands found = find_shear_bands(large().cut(), large().values({{45, 0.5}}));
  ASSERT_EQ(found.bands.size(), 1u);
  EXPECT_TRUE(found.bands[0].significant);
  EXPECT_LT(angle_error(found.bands[0].angle, 45), 2);
  EXPECT_GT(found.bands[0].thickness, 1);
  EXPECT_LT(found.bands[0].thickness, 1.5);
}

TEST(ShearBands, TwoParallelBands) {
  const Band low{.angle = 20, .width = 2, .centre = Vec2(0, -4.5)},
      high{.angle = 20, .width = 2, .centre = Vec2(0, 4.5)};
  const ShearBands found = find_shear_bands(large().cut(), large().values({low, high}));
  ASSERT_EQ(found.bands.size(), 2u);
  for (const ShearBand& band : found.bands) {
    EXPECT_TRUE(band.significant);
    EXPECT_LT(angle_error(band.angle, 20), 2);
    EXPECT_NEAR(std::abs(band.centre.y()) / distance, 4.5, 0.6);
    const Index k = &band == &found.bands[0] ? 1 : 2;
    EXPECT_NEAR(double((found.region == k).count()) / 16, band.area, 1e-9);
  }
  EXPECT_LT(found.bands[0].centre.y() * found.bands[1].centre.y(), 0);
  EXPECT_GE(found.bands[0].mass, found.bands[1].mass);
}

/// Excess: γ over the band's area; total: the same and the constant over the section. What is missing is in the feet of
/// the band, blurred over a mesh cell, that are below the threshold.
TEST(ShearBands, Shares) {
  const ShearBands found = find_shear_bands(large().cut(), large().values({{90, 3}}), no_shuffles);
  ASSERT_EQ(found.bands.size(), 1u);
  const double band_area = 3 * 16.5, area = 11.5 * 16.5;
  const double excess = gamma_of(shear) * band_area, total = excess + offset * area;
  EXPECT_LT(found.bands[0].share_of_excess, excess / total);
  EXPECT_GT(found.bands[0].share_of_excess, 0.75 * excess / total);
  EXPECT_GT(found.bands[0].share_of_total, found.bands[0].share_of_excess);
  EXPECT_LT(found.bands[0].share_of_total, 1);
  EXPECT_TRUE(std::isnan(found.bands[0].p_value)) << "nothing was shuffled";
  EXPECT_FALSE(found.bands[0].significant);
}

TEST(ShearBands, NoneInAHomogeneousField) {
  for (const double value : {0.0, 0.3}) {
    auto values = large().values({});
    for (double& x : values) x = value * (1 + 1e-9 * (x - offset));
    EXPECT_TRUE(find_shear_bands(large().cut(), values).bands.empty());
  }
}

/// From 0.05 to 0.25 over the width.
TEST(ShearBands, NoneInAGradient) {
  auto values = large().values({}, 0.1);
  for (std::size_t t = 0; t < values.size(); ++t) values[t] += 0.1 * (1 + large().position_over_width(t));
  for (const ShearBand& band : find_shear_bands(large().cut(), values).bands) EXPECT_FALSE(band.significant);
}

/// A crest over the whole width stands out from its surroundings, too; its thickness tells it from a band.
TEST(ShearBands, CrestOfASmoothFieldIsThick) {
  auto values = large().values({}, 0.1);
  for (std::size_t t = 0; t < values.size(); ++t) values[t] += 0.2 * (1 - std::pow(large().position_over_width(t), 2));
  const ShearBandOptions options;
  for (const ShearBand& band : find_shear_bands(large().cut(), values, options).bands)
    EXPECT_GT(band.thickness, options.background_scale);
}

/// At a level of 0.01, 0.4 of 40 are expected.
TEST(ShearBands, NoneInNoise) {
  const ShearedYarn yarn(10, 10);
  int n_alarms = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const auto found = find_shear_bands(yarn.cut(), yarn.values({}, 0.2, seed));
    n_alarms += std::any_of(found.bands.begin(), found.bands.end(), [](const ShearBand& b) { return b.significant; });
  }
  EXPECT_LE(n_alarms, 2);
}

/// A yarn of the paper's size, four layers thick: the band is found and measured, its angle less well.
TEST(ShearBands, FortyFourFibers) {
  const ShearedYarn yarn(4, 11);
  for (const double angle : {70.0, 90.0}) {
    const ShearBands found = find_shear_bands(yarn.cut(), yarn.values({{angle, 2}}));
    ASSERT_EQ(found.bands.size(), 1u);
    EXPECT_TRUE(found.bands[0].significant);
    EXPECT_LT(angle_error(found.bands[0].angle, angle), 5);
    EXPECT_NEAR(found.bands[0].thickness / 2, 1, 0.15);
  }
}

TEST(ShearBands, FlaggedTetrahedraAreNoHindrance) {
  auto values = large().values({{45, 2}});
  std::mt19937 random(1);
  for (double& x : values)
    if (random() % 20 == 0) x = std::numeric_limits<double>::quiet_NaN();
  const ShearBands found = find_shear_bands(large().cut(), values);
  ASSERT_FALSE(found.bands.empty());
  EXPECT_TRUE(found.bands[0].significant);
  EXPECT_LT(angle_error(found.bands[0].angle, 45), 2);
  EXPECT_NEAR(found.bands[0].thickness / 2, 1, 0.15);
  EXPECT_EQ(found.contrast.isNaN().count(), sample(large().cut(), values).isNaN().count());
}

TEST(ShearBands, NothingToLookAt) {
  const std::vector<double> none(large().mesh().tets.size(), std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(find_shear_bands(large().cut(), none).bands.empty());
  const YarnCut beside = cut_yarn(large().mesh(), large().positions(), {.origin = Vec3(1, 0, 0)});
  EXPECT_TRUE(find_shear_bands(beside, none).bands.empty());
}

TEST(ShearBands, SameOnAnyNumberOfThreads) {
  const auto values = large().values({{20, 2}}, 0.3);
  const int n_before = omp_get_max_threads();
  omp_set_num_threads(1);
  const ShearBands one = find_shear_bands(large().cut(), values);
  omp_set_num_threads(3);
  const ShearBands three = find_shear_bands(large().cut(), values);
  omp_set_num_threads(n_before);
  ASSERT_EQ(one.bands.size(), three.bands.size());
  for (std::size_t k = 0; k < one.bands.size(); ++k) {
    EXPECT_EQ(one.bands[k].p_value, three.bands[k].p_value);
    EXPECT_EQ(one.bands[k].angle, three.bands[k].angle);
    EXPECT_EQ(one.bands[k].mass, three.bands[k].mass);
  }
}

TEST(ShearBands, OptionsOutOfRangeAreRefused) {
  const auto message = [](const ShearBandOptions& options) {
    return input_error([&] { (void)find_shear_bands(large().cut(), large().values({}), options); });
  };
  EXPECT_NE(message({.local_scale = 0}).find("local_scale = 0"), std::string::npos);
  EXPECT_NE(message({.background_scale = 0.5}).find("background_scale"), std::string::npos);
  EXPECT_NE(message({.threshold = -1}).find("threshold"), std::string::npos);
  EXPECT_NE(message({.n_shuffles = -1}).find("n_shuffles"), std::string::npos);
  EXPECT_NE(message({.significance = 2}).find("significance"), std::string::npos);
}

/// A band through the whole yarn is a plate along it: its volume is that of its section, its plane holds the yarn's
/// axis.
TEST(ShearZones, OneBandIsOnePlate) {
  for (const double angle : {0.0, 45.0, 90.0}) {
    const ShearZones found = find_shear_zones(large().mesh(), large().positions(), large().values({{angle, 3}}));
    ASSERT_EQ(found.zones.size(), 1u);
    const ShearZone& zone = found.zones[0];
    const double a = angle * std::numbers::pi / 180;
    const double cosine = std::abs(zone.normal.dot(Vec3(0, -std::sin(a), std::cos(a))));
    EXPECT_LT(std::acos(std::min(cosine, 1.0)) * 180 / std::numbers::pi, 5) << "angle " << angle;
    EXPECT_NEAR(zone.extent[0], 1.2e-3, 0.05 * 1.2e-3);
    EXPECT_NEAR(zone.extent[2] / distance, 3, 1) << "a mesh cell";
    EXPECT_EQ(zone.n_tets, std::count(found.zone.begin(), found.zone.end(), 1));
    EXPECT_DOUBLE_EQ(found.volume_fraction, zone.volume_fraction);
    EXPECT_DOUBLE_EQ(zone.volume_fraction, zone.volume / large().mesh().quality.volume);
  }
}

TEST(ShearZones, VolumeOfAPlate) {
  const ShearZones found = find_shear_zones(large().mesh(), large().positions(), large().values({{90, 3}}));
  ASSERT_EQ(found.zones.size(), 1u);
  EXPECT_NEAR(found.volume_fraction, 3.0 / 11, 1.0 / 11) << "half a mesh cell on either side";
  EXPECT_GT(found.zones[0].share_of_total, found.volume_fraction);
}

TEST(ShearZones, TwoBandsAreTwo) {
  const Band low{.angle = 0, .width = 2, .centre = Vec2(0, -4.5)}, high{.angle = 0, .width = 3, .centre = Vec2(0, 4.5)};
  const ShearZones found = find_shear_zones(large().mesh(), large().positions(), large().values({low, high}));
  ASSERT_EQ(found.zones.size(), 2u);
  EXPECT_GT(found.zones[0].volume, found.zones[1].volume);
  EXPECT_GT(found.zones[0].centre.z(), found.zones[1].centre.z());
}

TEST(ShearZones, NoneInAHomogeneousField) {
  EXPECT_TRUE(find_shear_zones(large().mesh(), large().positions(), large().values({})).zones.empty());
  const std::vector<double> none(large().mesh().tets.size(), std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(find_shear_zones(large().mesh(), large().positions(), none).zones.empty());
}

TEST(ShearZones, OptionsOutOfRangeAreRefused) {
  const auto message = [](const ShearZoneOptions& options) {
    return input_error(
        [&] { (void)find_shear_zones(large().mesh(), large().positions(), large().values({}), options); });
  };
  EXPECT_NE(message({.local_sweeps = -1}).find("local_sweeps = -1"), std::string::npos);
  EXPECT_NE(message({.background_sweeps = 1}).find("background_sweeps"), std::string::npos);
  EXPECT_NE(message({.threshold = 0}).find("threshold"), std::string::npos);
}

}  // namespace
}  // namespace trame::meso
