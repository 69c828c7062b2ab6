#include "meso/fabric/fabric_facts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "meso/fabric/plan_cover.h"

namespace trame::meso {
namespace {

using micro::FiberConfiguration;
using micro::FiberMesh;
using micro::YarnFamily;
using std::numbers::pi;

/// Yarns of a weave with given centre lines: each has fibers of one radius beside each other, moved along with it.
struct GivenWeave {
  FiberMesh mesh;
  FiberConfiguration fibers;

  /// `z`: height of the centre line along the yarn, and its slope.
  struct Line {
    std::function<double(double)> z = [](double) { return 0.0; };
    std::function<double(double)> slope = [](double) { return 0.0; };
  };

  /// Straight in the plan, from −half_length to half_length along its system, at `across`. Fibers lie beside each
  /// other.
  void add(YarnFamily family, double across, double half_length, double radius, Index n_fibers, const Line& line) {
    constexpr Index n_nodes = 801;
    const Vec3 along = family == YarnFamily::warp ? Vec3::UnitX() : Vec3::UnitY();
    const Vec3 side = family == YarnFamily::warp ? Vec3::UnitY() : Vec3::UnitX();
    mesh.yarns.push_back({"yarn", family, mesh.n_fibers(), n_fibers});
    for (Index f = 0; f < n_fibers; ++f) {
      double s = 0;
      for (Index n = 0; n < n_nodes; ++n) {
        const double step = 2 * half_length / (n_nodes - 1), x = -half_length + n * step;
        const Vec3 tangent = (along + line.slope(x) * Vec3::UnitZ()).normalized();
        if (n > 0) s += step * std::hypot(1, line.slope(x - 0.5 * step));
        mesh.arc_length.push_back(s);
        fibers.r.emplace_back(x * along + (across + (2 * f - n_fibers + 1) * radius) * side +
                              line.z(x) * Vec3::UnitZ());
        fibers.g1.push_back(side);
        fibers.g2.push_back(tangent.cross(side));
        fibers.tangent.push_back(tangent);
      }
      mesh.first_node.push_back(mesh.first_node.back() + n_nodes);
      mesh.radius.push_back(radius);
      mesh.axial_stiffness.push_back(1);
      mesh.yarn_of_fiber.push_back(static_cast<Index>(mesh.yarns.size()) - 1);
    }
  }
  [[nodiscard]] std::vector<double> density(double value) const {
    return std::vector<double>(static_cast<std::size_t>(mesh.n_fibers()), value);
  }
};

constexpr double warp_radius = 10e-6, weft_radius = 15e-6, warp_spacing = 100e-6, weft_spacing = 160e-6;
constexpr Index n_warp = 5, n_weft = 4;

double at(Index k, Index n, double spacing) { return (k - 0.5 * (n - 1)) * spacing; }

/// Straight yarns: warps of three fibers on wefts of one, touching.
GivenWeave flat() {
  GivenWeave weave;
  const double warp_half = 0.5 * n_weft * weft_spacing, weft_half = 0.5 * n_warp * warp_spacing;
  for (Index j = 0; j < n_warp; ++j)
    weave.add(YarnFamily::warp, at(j, n_warp, warp_spacing), warp_half, warp_radius, 3,
              {[](double) { return warp_radius; }});
  for (Index i = 0; i < n_weft; ++i)
    weave.add(YarnFamily::weft, at(i, n_weft, weft_spacing), weft_half, weft_radius, 1,
              {[](double) { return -weft_radius; }});
  return weave;
}

TEST(FabricFacts, OfStraightYarnsByHand) {
  const GivenWeave weave = flat();
  const auto facts = fabric_facts(weave.mesh, weave.fibers, weave.density(1000));
  ASSERT_TRUE(facts);
  EXPECT_EQ(facts->warp.n_yarns, n_warp);
  EXPECT_EQ(facts->weft.n_yarns, n_weft);
  EXPECT_NEAR(facts->warp.spacing, warp_spacing, 1e-12);
  EXPECT_NEAR(facts->weft.spacing, weft_spacing, 1e-12);
  for (const SystemFacts* system : {&facts->warp, &facts->weft}) {
    EXPECT_NEAR(system->crimp.mean, 0, 1e-12);
    EXPECT_NEAR(system->take_up, 0, 1e-12);
    EXPECT_NEAR(system->width.deviation, 0, 1e-12);
  }
  EXPECT_NEAR(facts->warp.width.mean, 6 * warp_radius, 1e-9);
  EXPECT_NEAR(facts->warp.height.mean, 2 * warp_radius, 1e-9);
  EXPECT_NEAR(facts->weft.width.mean, 2 * weft_radius, 1e-9);
  EXPECT_NEAR(facts->thickness, 2 * warp_radius + 2 * weft_radius, 1e-12);
  EXPECT_NEAR(facts->outline_thickness, 2 * warp_radius + 2 * weft_radius, 1e-12);
  // By hand: 3 π (10 µm)² 1000 kg/m³ = 0.942 tex on 100 µm, π (15 µm)² 1000 kg/m³ = 0.707 tex on 160 µm.
  const double warp_tex = 3 * pi * warp_radius * warp_radius * 1000, weft_tex = pi * weft_radius * weft_radius * 1000;
  EXPECT_NEAR(1e6 * facts->warp.linear_density, 0.94248, 1e-5);
  EXPECT_NEAR(1e6 * facts->weft.linear_density, 0.70686, 1e-5);
  EXPECT_NEAR(1e3 * facts->areal_density, 9.4248 + 4.4179, 1e-3);
  EXPECT_NEAR(facts->warp.areal_density, warp_tex / warp_spacing, 1e-9);
  EXPECT_NEAR(facts->weft.areal_density, weft_tex / weft_spacing, 1e-9);
  EXPECT_NEAR(facts->volume_fraction, facts->areal_density / 1000 / facts->thickness, 1e-9);
  const double warp_cover = 0.6, weft_cover = 30.0 / 160;
  EXPECT_NEAR(facts->cover_factor, warp_cover + weft_cover - warp_cover * weft_cover, 1e-4);
  // A yarn has two edges in a spacing, each known to a 128th.
  EXPECT_NEAR(facts->projected_cover, facts->cover_factor, 2.0 / 128);
}

/// Two layers of the weft, one below and one above the warps: spacings are of columns, masses of all yarns.
TEST(FabricFacts, OfTwoLayersOfWeft) {
  GivenWeave weave;
  const double warp_half = 0.5 * n_weft * weft_spacing, weft_half = 0.5 * n_warp * warp_spacing;
  for (Index j = 0; j < n_warp; ++j)
    weave.add(YarnFamily::warp, at(j, n_warp, warp_spacing), warp_half, warp_radius, 3, {});
  for (Index i = 0; i < n_weft; ++i)
    for (const double side : {-1, 1})
      weave.add(YarnFamily::weft, at(i, n_weft, weft_spacing), weft_half, weft_radius, 1,
                {[=](double) { return side * (warp_radius + weft_radius); }});
  const auto facts = fabric_facts(weave.mesh, weave.fibers, weave.density(1000), 2);
  ASSERT_TRUE(facts);
  EXPECT_EQ(facts->weft.n_yarns, 2 * n_weft);
  EXPECT_NEAR(facts->warp.spacing, warp_spacing, 1e-12);
  EXPECT_NEAR(facts->weft.spacing, weft_spacing, 1e-12);
  EXPECT_NEAR(facts->thickness, 2 * warp_radius + 4 * weft_radius, 1e-12);
  EXPECT_NEAR(1e3 * facts->warp.areal_density, 9.4248, 1e-3);
  EXPECT_NEAR(1e3 * facts->weft.areal_density, 2 * 4.4179, 1e-3);
}

/// Where densities are not known there is no mass, and all else.
TEST(FabricFacts, WithoutDensities) {
  const GivenWeave weave = flat();
  const auto facts = fabric_facts(weave.mesh, weave.fibers, weave.density(std::nan("")));
  ASSERT_TRUE(facts);
  EXPECT_TRUE(std::isnan(facts->areal_density));
  EXPECT_TRUE(std::isnan(facts->warp.linear_density));
  EXPECT_GT(facts->volume_fraction, 0.1);
  EXPECT_NEAR(facts->warp.spacing, warp_spacing, 1e-12);
}

/// A plain weave whose warps are sine waves of a wave length of two weft spacings over straight wefts.
TEST(FabricFacts, CrimpOfSineWaves) {
  const double amplitude = 25e-6, wave = pi / weft_spacing;
  GivenWeave weave;
  const double warp_half = 0.5 * n_weft * weft_spacing, weft_half = 0.5 * n_warp * warp_spacing;
  for (Index j = 0; j < n_warp; ++j) {
    const double sign = j % 2 == 0 ? 1 : -1;  // extreme over the wefts, at ±½, ±1½ weft spacings
    weave.add(YarnFamily::warp, at(j, n_warp, warp_spacing), warp_half, warp_radius, 1,
              {[=](double x) { return sign * amplitude * std::sin(wave * x); },
               [=](double x) { return sign * amplitude * wave * std::cos(wave * x); }});
  }
  for (Index i = 0; i < n_weft; ++i)
    weave.add(YarnFamily::weft, at(i, n_weft, weft_spacing), weft_half, weft_radius, 1, {});
  const auto facts = fabric_facts(weave.mesh, weave.fibers, weave.density(1000));
  ASSERT_TRUE(facts);
  // Length of a sine wave over its wave length: (2/π) √(1 + a²k²) E(m), m = a²k²/(1 + a²k²).
  const double steepness = amplitude * wave, m = steepness * steepness / (1 + steepness * steepness);
  const double ratio = 2 / pi * std::sqrt(1 + steepness * steepness) * std::comp_ellint_2(std::sqrt(m));
  EXPECT_GT(ratio, 1.05);
  EXPECT_NEAR(facts->warp.crimp.mean, ratio - 1, 1e-5);
  EXPECT_NEAR(facts->warp.crimp.deviation, 0, 1e-9);
  EXPECT_NEAR(facts->warp.take_up, 1 - 1 / ratio, 1e-5);
  EXPECT_NEAR(facts->weft.crimp.mean, 0, 1e-12);
  EXPECT_NEAR(facts->warp.areal_density, ratio * 1000 * pi * warp_radius * warp_radius / warp_spacing, 1e-6);
  EXPECT_NEAR(facts->thickness, 2 * (amplitude + warp_radius), 1e-9) << "crowns of the warp on both sides";
}

/// An outermost yarn that sticks out is in the outline, but not in the thickness.
TEST(FabricFacts, ThicknessIsWithoutFreeEdges) {
  GivenWeave weave = flat();
  for (Index n = 0; n < weave.mesh.first_node[3]; ++n) weave.fibers.r[n].z() += 40e-6;
  const auto facts = fabric_facts(weave.mesh, weave.fibers, weave.density(1000));
  ASSERT_TRUE(facts);
  EXPECT_NEAR(facts->thickness, 2 * warp_radius + 2 * weft_radius, 1e-12);
  EXPECT_NEAR(facts->outline_thickness, 2 * warp_radius + 2 * weft_radius + 40e-6, 1e-12);
}

/// Yarns may be listed in any order, and the fabric may lie in any direction.
TEST(FabricFacts, OfTurnedAndShuffledYarns) {
  GivenWeave weave;
  const double half = 4e-4;
  for (const Index j : {2, 0, 3, 1})
    weave.add(YarnFamily::warp, at(j, 4, warp_spacing), half, warp_radius, 1, {[](double) { return warp_radius; }});
  for (const Index i : {1, 2, 0})
    weave.add(YarnFamily::weft, at(i, 3, weft_spacing), half, weft_radius, 1, {[](double) { return -weft_radius; }});
  const double c = std::cos(0.4), s = std::sin(0.4);
  Mat3 turn = Mat3::Identity();
  turn.topLeftCorner<2, 2>() << c, -s, s, c;
  for (auto* vectors : {&weave.fibers.r, &weave.fibers.g1, &weave.fibers.g2, &weave.fibers.tangent})
    for (Vec3& v : *vectors) v = turn * v;
  const auto facts = fabric_facts(weave.mesh, weave.fibers, weave.density(1000));
  ASSERT_TRUE(facts);
  EXPECT_NEAR(facts->warp.spacing, warp_spacing, 1e-12);
  EXPECT_NEAR(facts->weft.spacing, weft_spacing, 1e-12);
  EXPECT_NEAR(facts->projected_cover, 1 - (1 - 0.2) * (1 - 30.0 / 160), 2.0 / 128);
}

TEST(FabricFacts, OnlyOfWeaves) {
  GivenWeave weave;
  weave.add(YarnFamily::warp, 0, 1e-3, warp_radius, 1, {});
  weave.add(YarnFamily::warp, 1e-4, 1e-3, warp_radius, 1, {});
  EXPECT_FALSE(fabric_facts(weave.mesh, weave.fibers, weave.density(1000)));
  weave.add(YarnFamily::weft, 0, 1e-3, weft_radius, 1, {});
  weave.add(YarnFamily::weft, 2e-3, 1e-3, weft_radius, 1, {});  // beyond the warps' ends
  EXPECT_FALSE(fabric_facts(weave.mesh, weave.fibers, weave.density(1000)));
}

TEST(PlanCover, OfStrips) {
  const Vec2 corner(1, 2), a(4, 0), b(1, 3);
  EXPECT_EQ(plan_cover({}, corner, a, b, 10, 10), 0);
  EXPECT_EQ(plan_cover({{corner + 0.5 * b - a, corner + 0.5 * b + 2 * a, 2}}, corner, a, b, 10, 10), 1);
  const std::vector<Strip> middle = {{corner + 0.5 * b - a, corner + 0.5 * b + 2 * a, 0.75}};
  EXPECT_NEAR(plan_cover(middle, corner, a, b, 100, 100), 0.5, 1e-12);
  const std::vector<Strip> round = {{Vec2(3.5, 3.5), Vec2(3.5, 3.5), 1}};
  EXPECT_NEAR(plan_cover(round, corner, a, b, 400, 400), pi / 12, 1e-3);
}

}  // namespace
}  // namespace trame::meso
