/// What sections along a yarn show between two states.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "meso/bands/band_survey.h"
#include "tests/support/lattice_yarns.h"

namespace trame::meso {
namespace {

using micro::test::LatticeYarns;
using micro::test::mapped;

/// A flat yarn of round fibers that is stretched by 4 % and squeezed to 0.8 of its height. Fibers' sections follow.
class Survey : public ::testing::Test {
 protected:
  LatticeYarns yarns_{.n_rows = 4, .n_columns = 11, .n_elements = 10, .length = 20};
  micro::FiberMesh fibers_ = yarns_.mesh();
  micro::FiberConfiguration a_ = yarns_.configuration();
  micro::FiberConfiguration b_ = mapped(a_, Vec3(1.04, 1, 0.8).asDiagonal());

  [[nodiscard]] std::vector<SectionPair> pairs(Index n) const {
    return section_pairs(fibers_, fibers_.yarns[0], a_, b_, n);
  }
};

TEST_F(Survey, SectionsAreTheSameMaterialInBothStates) {
  const auto sections = pairs(5);
  ASSERT_EQ(sections.size(), 5u);
  for (int k = 0; k < 5; ++k) {
    const SectionPair& pair = sections[k];
    EXPECT_NEAR(pair.a.fraction, (k + 0.5) / 5, 1e-9);
    EXPECT_NEAR(pair.b.origin.x(), 1.04 * pair.a.origin.x(), 1e-9);
    EXPECT_NEAR(pair.b.shape.height, 0.8 * pair.a.shape.height, 1e-9);
    EXPECT_NEAR(pair.b.shape.area, 0.8 * pair.a.shape.area, 1e-9);
    EXPECT_NEAR(pair.axial_strain.side, 0.5 * (1.04 * 1.04 - 1), 1e-9);
    EXPECT_NEAR(pair.axial_strain.ratio, 1, 1e-9);
  }
}

TEST_F(Survey, MeansOfSections) {
  auto sections = pairs(4);
  const double height = sections[0].a.shape.height;
  sections[1].b.status = SectionStatus::no_fiber;  // is left out on both sides
  sections[1].a.shape.height = 1e9;
  sections[2].axial_strain = {.side = 0.06, .centre = 0.02, .n_side = 1, .n_centre = 1, .ratio = 3};
  sections[3].axial_strain = {.side = 0.06, .centre = 0.02, .n_side = 0, .n_centre = 1, .ratio = 3};
  const SectionMeans means = section_means(sections);
  EXPECT_EQ(means.n_sections, 3);
  EXPECT_NEAR(means.height_a, height, 1e-9);
  EXPECT_NEAR(means.height_b, 0.8 * height, 1e-9);
  const double uniform = 0.5 * (1.04 * 1.04 - 1);
  EXPECT_NEAR(means.side_to_centre, (uniform + 0.06) / (uniform + 0.02), 1e-9);
  EXPECT_TRUE(std::isnan(section_means({}).height_a));
}

TEST_F(Survey, MagnitudesOfComponents) {
  StrainField field;
  field.E = {(Mat3() << -1, 4, 5, 4, 2, -6, 5, -6, -3).finished()};
  field.gamma_max = {7};
  const double expected[] = {1, 2, 3, 6, 7};
  const char* names[] = {"E_axial", "E_horizontal", "E_vertical", "E_horizontal_vertical", "gamma_max"};
  for (std::size_t k = 0; k < band_components.size(); ++k) {
    EXPECT_EQ(magnitudes(field, band_components[k])[0], expected[k]);
    EXPECT_STREQ(text(band_components[k]), names[k]);
  }
}

/// Simple shear by 0.2 in a band 2 wide that stands upright in the section, vertical on vertical: E_yz = 0.1 and
/// γ_max in it. The other components have E_zz = 0 and E_yy = 0.02, E_xx = 0.
TEST_F(Survey, BandsComeWithTheirStationAndComponent) {
  b_ = a_;
  for (Vec3& r : b_.r) r.z() += 0.2 * std::clamp(r.y() - 5.25, -1.0, 1.0);
  const YarnMesh mesh = mesh_yarn(fibers_, 0, a_.r);
  const DeformationGradient gradient(mesh);
  const StrainField field = strain_between(mesh, gradient(a_.r), gradient(b_.r), a_.tangent);
  auto sections = pairs(3);
  sections[1].a.status = SectionStatus::no_fiber;
  const auto found = survey_bands(mesh, field, a_.r, sections, {.n_shuffles = 99});
  ASSERT_EQ(found.size(), 2 * band_components.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    EXPECT_EQ(found[k].station, k < band_components.size() ? 0 : 2);
    EXPECT_EQ(found[k].component, band_components[k % band_components.size()]);
    const bool sheared =
        found[k].component == BandComponent::horizontal_vertical || found[k].component == BandComponent::gamma_max;
    if (!sheared) continue;
    ASSERT_EQ(found[k].bands.size(), 1u) << text(found[k].component);
    const double in_hundredths = 100 * found[k].bands[0].p_value;  // of 1 + 99 pictures
    EXPECT_NEAR(in_hundredths, std::round(in_hundredths), 1e-9);
    EXPECT_GE(in_hundredths, 1 - 1e-9);
    EXPECT_LT(90 - std::abs(found[k].bands[0].angle), 5);
  }
  EXPECT_TRUE(found[0].bands.empty()) << "no axial strain";
}

TEST_F(Survey, NoBandsWithoutAMesh) { EXPECT_TRUE(survey_bands({}, {}, a_.r, pairs(2)).empty()); }

}  // namespace
}  // namespace trame::meso
