#include "meso/bands/strain_cut.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "meso/bands/band_shape.h"
#include "meso/bands/contrast.h"
#include "meso/mesh/tetrahedron.h"
#include "micro/core/error.h"
#include "tests/support/lattice_yarns.h"

namespace trame::meso {
namespace {

using micro::test::input_error;
using micro::test::LatticeYarns;
using micro::test::mapped;

class StrainCut : public ::testing::Test {
 protected:
  [[nodiscard]] Section section(const micro::FiberConfiguration& state, double u) const {
    return YarnSections(fibers_, fibers_.yarns[0], state).at_fraction(u);
  }
  [[nodiscard]] YarnCut cut(const micro::FiberConfiguration& state, double u, double resolution = 4) const {
    return cut_yarn(mesh_, state.r, section_plane(section(state, u)), resolution);
  }
  static double area(const YarnCut& cut) { return double(cut.inside.count()) * cut.pixel * cut.pixel; }

  LatticeYarns yarns_{.n_rows = 6, .n_columns = 8, .n_elements = 5, .spacing = 2e-5, .length = 1e-3};
  micro::FiberMesh fibers_ = yarns_.mesh();
  micro::FiberConfiguration reference_ = yarns_.configuration();
  YarnMesh mesh_ = mesh_yarn(fibers_, 0, reference_.r);
};

/// Every pixel's centre lies in its tetrahedron: the four tetrahedra that it makes with the faces fill it.
TEST_F(StrainCut, PixelsLieInTheirTetrahedra) {
  const YarnCut cut = this->cut(reference_, 0.47);
  for (Index r = 0; r < cut.n_rows(); ++r)
    for (Index c = 0; c < cut.n_columns(); ++c) {
      if (!cut.inside(r, c)) continue;
      const Vec2 x = cut.centre(r, c);
      const Vec3 point = cut.plane.origin + x.x() * cut.plane.horizontal + x.y() * cut.plane.vertical;
      Tet corners;
      for (int i = 0; i < 4; ++i) corners[i] = mesh_.reference[mesh_.tets[cut.tet(r, c)][i]];
      double parts = 0;
      for (int i = 0; i < 4; ++i) {
        Tet part = corners;
        part[i] = point;
        parts += std::abs(volume(part));
      }
      EXPECT_NEAR(parts / volume(corners), 1, 1e-6);
    }
}

/// A raster misses an area by less than half a pixel along the outline.
TEST_F(StrainCut, CoversTheSection) {
  const double outline = 2 * (7 + 5) * yarns_.spacing;
  for (const double u : {0.1, 0.33, 0.5}) {  // in a layer of nodes and between two
    const YarnCut cut = this->cut(reference_, u, 8);
    EXPECT_DOUBLE_EQ(cut.pixel, mesh_.fiber_distance / 8);
    EXPECT_NEAR(area(cut), yarns_.section_area(), 0.5 * cut.pixel * outline) << "u = " << u;
    EXPECT_LT((cut.plane.horizontal - Vec3::UnitY()).norm() + (cut.plane.vertical - Vec3::UnitZ()).norm(), 1e-12);
  }
}

/// The cut is normal to the yarn, wherever that points.
TEST_F(StrainCut, FollowsTheYarn) {
  const double outline = 2 * (7 + 5) * yarns_.spacing;
  const auto turned = mapped(reference_, Eigen::AngleAxisd(0.7, Vec3(0.1, 0.3, 1).normalized()).toRotationMatrix());
  const YarnCut cut = this->cut(turned, 0.4, 8);
  EXPECT_NEAR(area(cut), yarns_.section_area(), 0.5 * cut.pixel * outline);
  EXPECT_LT(cut.plane.horizontal.cross(cut.plane.vertical).cross(turned.tangent[0]).norm(), 1e-12);
}

TEST_F(StrainCut, LongitudinalCut) {
  const YarnCut cut = cut_yarn(mesh_, reference_.r, longitudinal_plane(section(reference_, 0.5)));
  const double height = 5 * std::sqrt(0.75) * yarns_.spacing;
  EXPECT_NEAR(area(cut), height * yarns_.length, cut.pixel * (height + yarns_.length));
}

TEST_F(StrainCut, SamplesWhatTheTetrahedraHave) {
  const YarnCut cut = this->cut(reference_, 0.47);
  std::vector<double> values(mesh_.tets.size());
  for (std::size_t t = 0; t < values.size(); ++t) values[t] = double(t);
  const Index flagged = cut.tet(cut.n_rows() / 2, cut.n_columns() / 2);
  values[flagged] = std::numeric_limits<double>::quiet_NaN();
  const Picture picture = sample(cut, values);
  for (Eigen::Index i = 0; i < picture.size(); ++i) {
    if (!cut.inside(i) || cut.tet(i) == flagged) {
      EXPECT_TRUE(std::isnan(picture(i)));
    } else {
      EXPECT_EQ(picture(i), cut.tet(i));
    }
  }
}

TEST_F(StrainCut, TetrahedraInsideOutAreLeftOut) {
  auto mirrored = reference_;
  for (Vec3& r : mirrored.r) r.y() = -r.y();
  EXPECT_FALSE(cut(mirrored, 0.4).inside.any());
}

/// A fiber at the side is a metre away, 50,000 fiber distances: the picture is that of the others.
TEST_F(StrainCut, TornTetrahedraAreLeftOut) {
  auto torn = reference_;
  const Index last = fibers_.n_fibers() - 1;  // in the top row, at the side
  for (Index n = fibers_.first_node[last]; n < fibers_.first_node[last + 1]; ++n) torn.r[n].y() += 1;
  const CutPlane plane{.origin = Vec3(0.4e-3, 0, 0)};
  const YarnCut cut = cut_yarn(mesh_, torn.r, plane), whole = cut_yarn(mesh_, reference_.r, plane);
  EXPECT_LE(cut.n_columns(), whole.n_columns());
  EXPECT_EQ(cut.n_rows(), whole.n_rows());
  EXPECT_GT(area(cut), 0.9 * area(whole));
  EXPECT_LT(area(cut), area(whole));
}

TEST_F(StrainCut, PlaneBesideTheYarn) {
  const YarnCut cut = cut_yarn(mesh_, reference_.r, {.origin = Vec3(-1e-3, 0, 0)});
  EXPECT_EQ(cut.inside.size(), 0);
  EXPECT_EQ(sample(cut, std::vector<double>(mesh_.tets.size(), 1)).size(), 0);
}

TEST_F(StrainCut, CoarsePixelsAreRefused) {
  EXPECT_NE(input_error([&] { (void)cut(reference_, 0.5, 0.5); }).find("0.5"), std::string::npos);
}

TEST(GaussianSmoother, FollowsGradientsUpToTheOutline) {
  Mask mask = Mask::Constant(20, 30, true);
  mask.block(0, 0, 12, 9) = false;  // a notch
  Picture values(20, 30);
  for (Eigen::Index r = 0; r < 20; ++r)
    for (Eigen::Index c = 0; c < 30; ++c)
      values(r, c) = mask(r, c) ? 3 + 0.2 * double(c) - 0.1 * double(r) : std::numeric_limits<double>::quiet_NaN();
  const Picture fit = GaussianSmoother(mask, 5, SmoothOrder::linear)(values);
  const Picture mean = GaussianSmoother(mask, 5, SmoothOrder::mean)(values);
  for (Eigen::Index i = 0; i < mask.size(); ++i)
    if (mask(i)) {
      EXPECT_NEAR(fit(i), values(i), 1e-4);
    }
  // What the linear fit is for: at a border a mean belongs to the place σ √(2/π) inside it.
  EXPECT_NEAR(mean(19, 29) - values(19, 29), (-0.2 + 0.1) * 5 * std::sqrt(2 / std::numbers::pi), 0.1);
}

TEST(RobustScale, IsBlindToAFewWildValues) {
  std::vector<double> values;
  for (int i = 0; i < 1000; ++i) values.push_back(i % 2 == 0 ? 1 : 3);
  for (int i = 0; i < 5; ++i) values.push_back(1e9);
  const RobustScale scale = robust_scale(values);
  EXPECT_NEAR(scale.mean, 2, 0.01);
  EXPECT_NEAR(scale.deviation, 1, 0.01);
  EXPECT_NEAR(scale.rms, std::sqrt(5.0), 0.01);
}

TEST(Regions, ShareSides) {
  Mask mask = Mask::Constant(3, 4, false);
  for (const auto& [r, c] : {std::pair(0, 0), {1, 0}, {2, 1}, {2, 2}, {0, 3}}) mask(r, c) = true;
  Eigen::ArrayXX<Index> region;
  EXPECT_EQ(label_regions(mask, region), 3);
  EXPECT_EQ(region(0, 0), region(1, 0));
  EXPECT_NE(region(1, 0), region(2, 1)) << "they share a corner only";
  EXPECT_EQ(region(2, 1), region(2, 2));
  EXPECT_EQ(region(0, 1), 0);
}

TEST(Regions, DilatedDisc) {
  Mask mask = Mask::Constant(11, 11, false);
  mask(5, 5) = true;
  EXPECT_EQ(dilated(mask, 2).count(), 13);  // x² + y² ≤ 4
  mask(5, 5) = false;
  mask(0, 0) = true;
  EXPECT_EQ(dilated(mask, 1).count(), 3);
}

/// Blocks of one pixel keep nothing but the values; large blocks keep neighbours together.
TEST(ShuffledBlocks, KeepOrderWithinBlocks) {
  const Mask mask = Mask::Constant(40, 40, true);
  Picture values(40, 40);
  for (Eigen::Index r = 0; r < 40; ++r) values.row(r).setConstant(double(r / 8 % 2));  // stripes of 8
  std::mt19937 random(1);
  const auto equal_neighbours = [&](Index side) {
    const Picture shuffled = shuffled_blocks(values, mask, side, random);
    EXPECT_TRUE((shuffled == 0 || shuffled == 1).all());
    EXPECT_NEAR(shuffled.mean(), values.mean(), side == 1 ? 0.06 : 0.3);
    return (shuffled.leftCols(39) == shuffled.rightCols(39)).count() / (39 * 40.0);
  };
  EXPECT_NEAR(equal_neighbours(1), 0.5, 0.05);
  EXPECT_GT(equal_neighbours(10), 0.8);
}

/// A box of width w across a direction, in a domain that cuts it off obliquely; pixels have the part of it that covers
/// them.
TEST(BandShape, OfAPerfectBand) {
  for (const double angle : {-60.0, 0.0, 33.0, 89.0})
    for (const double width : {1.7, 3.0}) {
      const Vec2 across = Eigen::Rotation2Dd(angle * std::numbers::pi / 180) * Vec2::UnitY();
      const auto covered = [&](double s) { return std::clamp((width / 2 - std::abs(s)) / 0.25 + 0.5, 0.0, 1.0); };
      std::vector<BandPixel> pixels;
      for (double x = -5; x <= 5; x += 0.25)
        for (double y = -4; y <= 4; y += 0.25) pixels.push_back({Vec2(x, y), 0.3 * covered(across.dot(Vec2(x, y)))});
      const BandDirection direction = band_direction(pixels);
      EXPECT_NEAR(direction.angle, angle, 1) << "half a pixel over half the length";
      EXPECT_GT(direction.straightness, 0.85);
      EXPECT_NEAR(band_thickness(pixels, direction.angle), width, 0.1);
    }
}

}  // namespace
}  // namespace trame::meso
