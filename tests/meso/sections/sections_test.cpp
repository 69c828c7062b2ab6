#include "meso/sections/sections.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "tests/support/lattice_yarns.h"

namespace trame::meso {
namespace {

using micro::FiberConfiguration;
using micro::FiberMesh;
using micro::test::LatticeYarns;
using std::numbers::pi;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Upper and lower side of an outline symmetric about both axes, counter-clockwise; `half_height` of x from −w/2 to
/// w/2.
template <class HalfHeight>
std::vector<Vec2> symmetric_outline(double width, HalfHeight&& half_height) {
  constexpr int n = 4000;
  std::vector<Vec2> outline;
  // Points gather at the ends, where outlines may be steep.
  const auto x = [&](int i) { return -0.5 * width * std::cos(pi * i / n); };
  for (int i = 0; i <= n; ++i) outline.emplace_back(x(i), -half_height(x(i)));
  for (int i = n - 1; i > 0; --i) outline.emplace_back(x(i), half_height(x(i)));
  return outline;
}

std::vector<Vec2> ellipse(double width, double height) {
  return symmetric_outline(
      width, [=](double x) { return 0.5 * height * std::sqrt(std::max(1 - 4 * x * x / (width * width), 0.0)); });
}

/// Two arcs of radius (w²/4 + H²/4) / H, for w > H.
std::vector<Vec2> lens(double width, double height) {
  const double radius = (width * width + height * height) / (4 * height);
  return symmetric_outline(width,
                           [=](double x) { return std::sqrt(radius * radius - x * x) - (radius - 0.5 * height); });
}

/// Shallow lenses are parabolas 1 − ξ², against √(1 − ξ²) of an ellipse: ∫₀¹ (difference)² = 8/15 + 2/3 − 3π/8.
const double lens_against_ellipse = 8.0 / 15 + 2.0 / 3 - 3 * pi / 8;

TEST(OutlineShape, ShallowLens) {
  const OutlineShape shape = outline_shape(lens(2, 0.02));
  EXPECT_TRUE(shape.lenticular());
  EXPECT_NEAR(shape.lens_residual, 0, 1e-5);
  EXPECT_NEAR(shape.ellipse_residual, std::sqrt(lens_against_ellipse / (8.0 / 15)), 1e-3);
  EXPECT_NEAR(shape.area, 2.0 / 3 * 2 * 0.02, 1e-5);
}

TEST(OutlineShape, Ellipse) {
  const OutlineShape shape = outline_shape(ellipse(2, 0.02));
  EXPECT_FALSE(shape.lenticular());
  EXPECT_NEAR(shape.ellipse_residual, 0, 1e-5);
  EXPECT_NEAR(shape.lens_residual, std::sqrt(lens_against_ellipse / (2.0 / 3)), 1e-3);
  EXPECT_NEAR(shape.area, pi * 0.01, 1e-7);
}

/// Deep lenses are no parabolas; and points at the top and bottom make a lens as well as points at the sides.
TEST(OutlineShape, LensesOfAnyProportion) {
  for (const double height : {0.1, 0.5, 0.9}) {
    std::vector<Vec2> outline = lens(1, height);
    for (const bool upright : {false, true}) {
      if (upright)
        for (Vec2& corner : outline) corner = Vec2(-corner.y(), corner.x());
      const OutlineShape shape = outline_shape(outline);
      EXPECT_NEAR(shape.width, upright ? height : 1, 1e-12);
      EXPECT_NEAR(shape.thickness, upright ? 1 : height, 1e-6);
      EXPECT_LT(shape.lens_residual, 1e-4) << height;
      EXPECT_GT(shape.ellipse_residual, 10 * shape.lens_residual) << height;
    }
  }
}

/// A circle is both: an ellipse, and a lens whose arcs are half circles.
TEST(OutlineShape, CircleIsBoth) {
  const OutlineShape shape = outline_shape(ellipse(3, 3));
  EXPECT_LT(shape.lens_residual, 1e-5);
  EXPECT_LT(shape.ellipse_residual, 1e-5);
}

/// Of a circle, or a hexagon of seven fibers, it would be chance which of the two is nearer.
TEST(OutlineShape, RoundOnesAreNeitherLensNorEllipse) {
  for (const auto& [width, height, name] :
       {std::tuple{3, 3, "round"}, {5, 4, "round"}, {4, 5, "round"}, {4, 2, "ellipse"}}) {
    EXPECT_STREQ(outline_shape(ellipse(width, height)).name(), name) << width << " x " << height;
    EXPECT_FALSE(outline_shape(ellipse(width, height)).lenticular());
  }
}

TEST(OutlineShape, LeaningOutlineIsThinnerThanHigh) {
  const OutlineShape shape = outline_shape({{0, 0}, {4, 2}, {4, 3}, {0, 1}});
  EXPECT_DOUBLE_EQ(shape.area, 4);
  EXPECT_DOUBLE_EQ(shape.width, 4);
  EXPECT_DOUBLE_EQ(shape.height, 3);
  EXPECT_DOUBLE_EQ(shape.thickness, 1);
}

TEST(OutlineShape, NothingHasNoShape) {
  EXPECT_TRUE(std::isnan(outline_shape({}).area));
  EXPECT_TRUE(std::isnan(outline_shape({{0, 0}, {1, 0}}).lens_residual));
}

TEST(ConvexHull, LeavesOutWhatIsInside) {
  const auto hull = convex_hull({{1, 1}, {0, 0}, {2, 2}, {2, 0}, {0, 2}, {1, 0}, {0.5, 1.5}});
  const std::vector<Vec2> expected = {{0, 0}, {2, 0}, {2, 2}, {0, 2}};
  EXPECT_EQ(hull, expected);
  EXPECT_LT(convex_hull({{0, 0}, {1, 1}, {2, 2}, {3, 3}}).size(), 3u);
  EXPECT_TRUE(convex_hull({}).empty());
}

/// One yarn of straight fibers along x through the points (y, z).
struct Bundle {
  FiberMesh mesh;
  FiberConfiguration fibers;

  Bundle(const std::vector<Vec2>& points, double radius, double length = 10) {
    mesh.yarns = {{"yarn", micro::YarnFamily::free, 0, static_cast<Index>(points.size())}};
    for (const Vec2& point : points) {
      mesh.first_node.push_back(mesh.first_node.back() + 3);
      mesh.radius.push_back(radius);
      mesh.axial_stiffness.push_back(1);
      mesh.yarn_of_fiber.push_back(0);
      for (const double x : {0.0, 0.5 * length, length}) {
        mesh.arc_length.push_back(x);
        fibers.r.emplace_back(x, point.x(), point.y());
        fibers.g1.push_back(Vec3::UnitY());
        fibers.g2.push_back(Vec3::UnitZ());
        fibers.tangent.push_back(Vec3::UnitX());
      }
    }
  }
  [[nodiscard]] YarnSections sections() const { return {mesh, mesh.yarns[0], fibers}; }
};

/// A hexagon of k rings of touching discs around one.
std::vector<Vec2> hexagon(int k) {
  std::vector<Vec2> points;
  for (int i = -k; i <= k; ++i)
    for (int j = -k; j <= k; ++j)
      if (std::abs(i + j) <= k) points.emplace_back(i + 0.5 * j, 0.5 * std::sqrt(3.0) * j);
  return points;
}

double hexagon_fill(int k) { return Bundle(hexagon(k), 0.5).sections().at(5).fill; }

/// The hull of discs about a polygon of area A and perimeter P has the area A + P R + π R² (Steiner). Discs are
/// polygons of 64 corners, so every side of the hull may be short of that by R (1 − cos π/64).
TEST(Sections, FillOfAHexagonalPacking) {
  for (const int k : {1, 3, 20}) {
    const double n = 3 * k * (k + 1) + 1, area = 1.5 * std::sqrt(3.0) * k * k + 6 * k * 0.5 + pi / 4;
    const double missing = (6 * k + pi) * 0.5 * (1 - std::cos(pi / 64));
    EXPECT_GE(hexagon_fill(k), n * pi / 4 / area);
    EXPECT_LE(hexagon_fill(k), n * pi / 4 / (area - missing));
  }
}

/// Without its outline, whose share falls with 1/k, a packing fills π/√12; 0.1/k² is left by the extrapolation.
TEST(Sections, FillOfAnEndlessHexagonalPacking) {
  EXPECT_NEAR(2 * hexagon_fill(40) - hexagon_fill(20), pi / std::sqrt(12.0), 3e-4);
}

TEST(Sections, OneFiberIsItsOwnOutline) {
  const Section section = Bundle({{2, 3}}, 0.5).sections().at(4);
  ASSERT_EQ(section.status, SectionStatus::ok);
  EXPECT_DOUBLE_EQ(section.fraction, 0.4);
  EXPECT_DOUBLE_EQ(section.arc_length, 4);
  EXPECT_TRUE(section.origin.isApprox(Vec3(4, 2, 3)));
  EXPECT_TRUE(section.frame.isIdentity(1e-15));
  EXPECT_NEAR(section.fiber_area, pi / 4, 1e-12);
  EXPECT_NEAR(section.shape.width, 1, 1e-12);
  EXPECT_NEAR(section.shape.height, 1, 1e-12);
  EXPECT_NEAR(section.shape.area, 32 * std::sin(2 * pi / 64) / 4, 1e-12) << "a polygon of 64 corners";
}

TEST(Sections, TwoAndThreeFibers) {
  const Section two = Bundle({{0, 0}, {1, 0}}, 0.5).sections().at(5);
  EXPECT_NEAR(two.shape.width, 2, 1e-12);
  EXPECT_NEAR(two.shape.height, 1, 1e-12);
  EXPECT_NEAR(two.shape.area, 1 + pi / 4, 0.002);
  const Section three = Bundle({{0, 0}, {1, 0}, {0.5, 0.5 * std::sqrt(3.0)}}, 0.5).sections().at(5);
  EXPECT_NEAR(three.shape.width, 2, 1e-12);
  EXPECT_NEAR(three.shape.height, 1 + 0.5 * std::sqrt(3.0), 1e-12);
  EXPECT_NEAR(three.shape.area, std::sqrt(3.0) / 4 + 1.5 + pi / 4, 0.002);
}

/// Two fibers that run at ±θ to the yarn: their circles become ellipses 1/cos θ as wide.
TEST(Sections, ObliqueFibersAreCutObliquely) {
  Bundle bundle({{0, 0}, {0, 5}}, 0.5);
  const double angle = 0.6;
  for (Index n = 0; n < 6; ++n) {
    const double side = n < 3 ? angle : -angle;
    bundle.fibers.g1[n] = Vec3(-std::sin(side), std::cos(side), 0);
    bundle.fibers.r[n].y() = bundle.fibers.r[n].x() * std::sin(side);
    bundle.fibers.r[n].x() *= std::cos(side);
  }
  const Section section = bundle.sections().at_fraction(0.3);
  ASSERT_EQ(section.fibers.size(), 2u);
  EXPECT_NEAR(bundle.sections().length(), 10 * std::cos(angle), 1e-12);
  for (const FiberCut& cut : section.fibers) {
    EXPECT_NEAR(cut.area(), pi / 4 / std::cos(angle), 1e-12);
    EXPECT_NEAR(std::abs(cut.half_axes(0, 0)), 0.5 / std::cos(angle), 1e-12);
    EXPECT_NEAR(std::abs(cut.half_axes(1, 1)), 0.5, 1e-12);
    EXPECT_NEAR(cut.centre.x(), 3 * std::sin(cut.fiber == 0 ? angle : -angle), 1e-9);
    EXPECT_NEAR(cut.centre.y(), cut.fiber == 0 ? -2.5 : 2.5, 1e-12);
    EXPECT_NEAR(cut.s, 3, 1e-9);
  }
}

/// A yarn bent to a quarter of a circle is cut along radii: every section is that of the straight yarn, and the length
/// of its mean curve is that of the circle through the centroid. Quadratic elements of an angle φ are off by φ⁴/1000.
TEST(Sections, CurvedYarn) {
  const LatticeYarns yarns{.n_rows = 4, .n_columns = 6, .n_elements = 20, .length = 60};
  FiberMesh mesh = yarns.mesh();
  FiberConfiguration fibers = yarns.configuration();
  const Section straight = YarnSections(mesh, mesh.yarns[0], fibers).at(30);
  const double radius = yarns.length / (pi / 2), centroid = straight.origin.z();
  for (std::size_t n = 0; n < fibers.r.size(); ++n) {
    const double angle = fibers.r[n].x() / radius, distance = radius + fibers.r[n].z() - centroid;
    const Mat3 turn = Eigen::AngleAxisd(angle, Vec3::UnitY()).toRotationMatrix();
    fibers.r[n] = turn * Vec3(0, fibers.r[n].y(), distance);
    fibers.g2[n] = turn * fibers.g2[n];
    mesh.arc_length[n] = angle * distance;
  }
  const YarnSections sections(mesh, mesh.yarns[0], fibers);
  EXPECT_NEAR(sections.length(), yarns.length, 1e-6 * yarns.length);
  for (const double arc_length : {1.0, 20.0, 33.3, 55.0}) {
    const Section section = sections.at(arc_length);
    ASSERT_EQ(section.fibers.size(), 24u);
    EXPECT_NEAR(section.arc_length, arc_length, 1e-12);
    EXPECT_NEAR(section.fraction, arc_length / yarns.length, 1e-6);
    EXPECT_NEAR(section.shape.width, straight.shape.width, 1e-4);
    EXPECT_NEAR(section.shape.height, straight.shape.height, 1e-4);
    EXPECT_NEAR(section.fill, straight.fill, 1e-4);
    for (std::size_t f = 0; f < 24; ++f) EXPECT_LT((section.fibers[f].centre - straight.fibers[f].centre).norm(), 1e-4);
  }
}

TEST(Sections, SeriesCoversTheYarn) {
  const Bundle bundle({{0, 0}, {1, 0}}, 0.5);
  const auto series = bundle.sections().series(4);
  ASSERT_EQ(series.size(), 4u);
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(series[k].arc_length, 1.25 + 2.5 * k, 1e-12);
}

TEST(Sections, EndsBelongToTheYarnAndNothingBeyond) {
  const Bundle bundle({{0, 0}, {1, 0}, {0, 1}}, 0.5);
  const YarnSections sections = bundle.sections();
  for (const double end : {0.0, sections.length()}) {
    EXPECT_EQ(sections.at(end).status, SectionStatus::ok);
    EXPECT_EQ(sections.at(end).fibers.size(), 3u);
  }
  for (const Section& section : {sections.at(-0.1), sections.at(10.1), sections.at(nan), sections.at_fraction(1.5)}) {
    EXPECT_EQ(section.status, SectionStatus::beyond_end);
    EXPECT_TRUE(section.fibers.empty());
    EXPECT_TRUE(std::isnan(section.shape.width));
    EXPECT_TRUE(std::isnan(section.fill));
  }
  EXPECT_EQ(text(SectionStatus::beyond_end), "beyond the ends of the yarn");
}

/// The mean of fibers of lengths 5, 10, 10, 10 at 0.8 of them is at x = 7, where the first has ended.
TEST(Sections, FibersThatEndBeforeTheStationAreLeftOut) {
  Bundle bundle({{0, 0}, {1, 0}, {0, 1}, {1, 1}}, 0.5);
  for (Index n = 0; n < 3; ++n) {
    bundle.mesh.arc_length[n] *= 0.5;
    bundle.fibers.r[n].x() *= 0.5;
  }
  const Section section = bundle.sections().at_fraction(0.8);
  EXPECT_DOUBLE_EQ(section.origin.x(), 7);
  ASSERT_EQ(section.fibers.size(), 3u);
  EXPECT_EQ(section.fibers[0].fiber, 1);
}

TEST(Sections, FibersThatRunAgainstEachOtherHaveNoSection) {
  Bundle bundle({{0, 0}, {1, 0}}, 0.5);
  std::swap(bundle.fibers.r[3], bundle.fibers.r[5]);
  EXPECT_EQ(bundle.sections().at_fraction(0.3).status, SectionStatus::no_fiber);
}

/// Eight fibers side by side, at ±0.5, ±1.5 (centre) and ±2.5, ±3.5 (sides of an outline of width 8) from the middle.
class AxialStrain : public ::testing::Test {
 protected:
  static std::vector<Vec2> row() {
    std::vector<Vec2> points;
    for (int f = 0; f < 8; ++f) points.emplace_back(f, 0);
    return points;
  }
  /// The yarn with the Green-Lagrange strain E(offset from the middle) along each fiber.
  template <class Strain>
  [[nodiscard]] std::vector<Vec3> strained(std::vector<Vec3> r, Strain&& E) const {
    for (Vec3& x : r) x.x() *= std::sqrt(1 + 2 * E(x.y() - 3.5));
    return r;
  }
  [[nodiscard]] SideToCentre ratio(const std::vector<Vec3>& r_a, const std::vector<Vec3>& r_b) const {
    return side_to_centre(section_, axial_strains(bundle_.mesh, section_, r_a, r_b));
  }
  const Bundle bundle_{row(), 0.5};
  const Section section_ = bundle_.sections().at(4);
};

TEST_F(AxialStrain, ParabolaAcrossTheWidth) {
  const auto r_b = strained(bundle_.fibers.r, [](double y) { return 0.01 + 0.001 * y * y; });
  const SideToCentre result = ratio(bundle_.fibers.r, r_b);
  EXPECT_EQ(result.n_side, 4);
  EXPECT_EQ(result.n_centre, 4);
  EXPECT_NEAR(result.side, 0.01 + 0.001 * (6.25 + 12.25) / 2, 1e-14);
  EXPECT_NEAR(result.centre, 0.01 + 0.001 * (0.25 + 2.25) / 2, 1e-14);
  EXPECT_NEAR(result.ratio, 0.01925 / 0.01125, 1e-11);
}

/// Strain is from A: what fibers were stretched by before does not count.
TEST_F(AxialStrain, IsRelativeToA) {
  const auto r_a = strained(bundle_.fibers.r, [](double) { return 0.105; });
  const auto r_b = strained(r_a, [](double y) { return 0.02 * std::abs(y); });
  const auto strains = axial_strains(bundle_.mesh, section_, r_a, r_b);
  for (int f = 0; f < 8; ++f) EXPECT_NEAR(strains[f], 0.02 * std::abs(f - 3.5), 1e-14);
}

TEST_F(AxialStrain, NoRatioToNothing) {
  const auto r_b = strained(bundle_.fibers.r, [](double y) { return std::abs(y) > 2 ? 0.02 : 1e-5; });
  const SideToCentre result = ratio(bundle_.fibers.r, r_b);
  EXPECT_NEAR(result.side, 0.02, 1e-14);
  EXPECT_NEAR(result.centre, 1e-5, 1e-14);
  EXPECT_TRUE(std::isnan(result.ratio));
  EXPECT_TRUE(std::isnan(ratio(bundle_.fibers.r, bundle_.fibers.r).ratio)) << "no strain at all";
}

TEST_F(AxialStrain, UnknownValuesAreLeftOut) {
  const SideToCentre result = side_to_centre(section_, {nan, 4, 1, 1, 1, nan, 2, 3});
  EXPECT_EQ(result.n_side, 3);
  EXPECT_EQ(result.n_centre, 3);
  EXPECT_DOUBLE_EQ(result.ratio, 3);
  const SideToCentre none = side_to_centre(section_, std::vector<double>(8, nan));
  EXPECT_TRUE(std::isnan(none.side) && std::isnan(none.centre) && std::isnan(none.ratio));
}

TEST_F(AxialStrain, FiberWithoutLengthHasNone) {
  const std::vector<Vec3> collapsed(bundle_.fibers.r.size(), Vec3::Zero());
  for (const double strain : axial_strains(bundle_.mesh, section_, collapsed, bundle_.fibers.r))
    EXPECT_TRUE(std::isnan(strain));
}

}  // namespace
}  // namespace trame::meso
