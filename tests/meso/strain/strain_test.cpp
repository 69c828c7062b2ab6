#include "meso/strain/strain.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "tests/support/lattice_yarns.h"

namespace trame::meso {
namespace {

using micro::test::LatticeYarns;
using micro::test::mapped;

class Strain : public ::testing::TestWithParam<MeshKind> {
 protected:
  /// F on the mesh for the state that `map` makes of the reference state.
  std::vector<Mat3> gradient(const Mat3& map) const { return gradient_(mapped(reference_, map).r); }
  /// Strain between two affine states.
  StrainField between(const Mat3& a, const Mat3& b) const {
    return strain_between(mesh_, gradient(a), gradient(b), mapped(reference_, a).tangent);
  }

  // Fibers along x in micrometres' range, so that nothing hides behind lengths of 1.
  LatticeYarns yarns_{.n_rows = 4, .n_columns = 4, .n_elements = 6, .spacing = 2e-5, .length = 3e-4};
  micro::FiberConfiguration reference_ = yarns_.configuration();
  YarnMesh mesh_ = mesh_yarn(yarns_.mesh(), 0, reference_.r, {.kind = GetParam()});
  DeformationGradient gradient_{mesh_};
};

Mat3 matrix(std::initializer_list<double> rows) {
  Mat3 m;
  int i = 0;
  for (const double value : rows) m(i / 3, i % 3) = value, ++i;
  return m;
}

TEST_P(Strain, AffineMapIsExact) {
  const Mat3 F = matrix({1.02, 0.03, -0.01, 0.05, 0.9, 0.2, -0.04, 0.1, 1.1});
  const auto all = gradient(F);
  ASSERT_EQ(all.size(), mesh_.tets.size());
  for (const Mat3& F_tet : all) EXPECT_LT((F_tet - F).cwiseAbs().maxCoeff(), 1e-12);
}

TEST_P(Strain, TranslationIsNoStrain) {
  auto moved = reference_;
  for (Vec3& r : moved.r) r += Vec3(1e-3, -2e-3, 5e-4);
  for (const Mat3& F : gradient_(moved.r)) EXPECT_LT((F - Mat3::Identity()).cwiseAbs().maxCoeff(), 1e-10);
}

TEST_P(Strain, StretchAlongTheYarnAxes) {
  const StrainField field = between(Mat3::Identity(), Mat3(Vec3(1.02, 1.1, 0.8).asDiagonal()));
  EXPECT_EQ(field.n_flagged, 0);
  for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
    EXPECT_NEAR(field.E[t](0, 0), 0.5 * (1.02 * 1.02 - 1), 1e-12);
    EXPECT_NEAR(field.E[t](1, 1), 0.5 * (1.1 * 1.1 - 1), 1e-12);
    EXPECT_NEAR(field.E[t](2, 2), 0.5 * (0.8 * 0.8 - 1), 1e-12);
    EXPECT_NEAR(field.E[t](0, 1), 0, 1e-12);
    EXPECT_NEAR(field.principal[t][0], 0.105, 1e-12);
    EXPECT_NEAR(field.principal[t][1], 0.0202, 1e-12);
    EXPECT_NEAR(field.principal[t][2], -0.18, 1e-12);
    EXPECT_NEAR(field.gamma_max[t], 0.285, 1e-12);
    EXPECT_NEAR(field.det_F[t], 1.02 * 1.1 * 0.8, 1e-12);
  }
}

/// x ↦ x + k z: E_xz = k/2, E_zz = k²/2, the rest 0; principal values are the roots of λ² − λ k²/2 − k²/4.
TEST_P(Strain, SimpleShear) {
  const double k = 0.3;
  const StrainField field = between(Mat3::Identity(), matrix({1, 0, k, 0, 1, 0, 0, 0, 1}));
  const double root = std::sqrt(k * k / 4 + k * k * k * k / 16);
  for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
    EXPECT_LT((field.E[t] - matrix({0, 0, k / 2, 0, 0, 0, k / 2, 0, k * k / 2})).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_NEAR(field.principal[t][0], k * k / 4 + root, 1e-12);
    EXPECT_NEAR(field.principal[t][2], k * k / 4 - root, 1e-12);
    EXPECT_NEAR(field.gamma_max[t], 2 * root, 1e-12);
    EXPECT_NEAR(field.det_F[t], 1, 1e-12);
  }
}

TEST_P(Strain, RotationIsNoStrain) {
  const Mat3 rotation = Eigen::AngleAxisd(2.0, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  const StrainField field = between(Mat3::Identity(), rotation);
  for (const Mat3& E : field.E) EXPECT_LT(E.cwiseAbs().maxCoeff(), 1e-12);
}

/// B = S A: the strain from A to B is that of S, whatever A, in the axes of A's yarn.
TEST_P(Strain, BetweenTwoDeformedStates) {
  const Mat3 A = matrix({1.05, 0.02, 0.1, 0.01, 0.95, 0.03, -0.02, 0.04, 1.2});
  const Mat3 S = matrix({1.01, 0.02, 0, 0.03, 0.9, 0.05, 0, 0.1, 1.04});
  const StrainField field = between(A, S * A);
  const Mat3 frame = yarn_frame(A.col(0));
  const Mat3 expected = frame * (0.5 * (S.transpose() * S - Mat3::Identity())) * frame.transpose();
  for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
    EXPECT_LT((field.E[t] - expected).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_NEAR(field.det_F[t], S.determinant(), 1e-12);
  }
}

TEST_P(Strain, BetweenAStateAndItselfIsNone) {
  const Mat3 A = matrix({1.05, 0.02, 0.1, 0.01, 0.95, 0.03, -0.02, 0.04, 1.2});
  for (const Mat3& E : between(A, A).E) EXPECT_LT(E.cwiseAbs().maxCoeff(), 1e-14);
}

/// Components belong to the yarn: turned with it about z, they are the same.
TEST_P(Strain, ComponentsFollowTheYarn) {
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3::UnitZ()).toRotationMatrix();
  const Mat3 S = matrix({1.02, 0.1, 0.05, 0, 1.1, 0.2, 0, 0, 0.8});
  const StrainField straight = between(Mat3::Identity(), S), turned = between(turn, turn * S * turn.transpose() * turn);
  for (std::size_t t = 0; t < mesh_.tets.size(); ++t)
    EXPECT_LT((straight.E[t] - turned.E[t]).cwiseAbs().maxCoeff(), 1e-12);
}

/// Two fibers that change places turn the tetrahedra between them inside out; the strains far away are as before.
TEST_P(Strain, InvertedTetrahedraAreFlagged) {
  auto swapped = reference_;
  const Index n = yarns_.n_nodes_per_fiber();
  for (Index k = 0; k < n; ++k) std::swap(swapped.r[5 * n + k], swapped.r[6 * n + k]);
  const auto F_0 = gradient(Mat3::Identity()), F_swapped = gradient_(swapped.r);
  for (const bool as_b : {true, false}) {
    const StrainField field = as_b ? strain_between(mesh_, F_0, F_swapped, reference_.tangent)
                                   : strain_between(mesh_, F_swapped, F_0, reference_.tangent);
    Index n_flagged = 0;
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      const bool inverted = F_swapped[t].determinant() <= 0;
      n_flagged += inverted;
      EXPECT_EQ(field.flagged[t] == tet_inverted, inverted);
      EXPECT_EQ(std::isnan(field.E[t](0, 0)), field.flagged[t] != tet_good);
      EXPECT_EQ(std::isnan(field.gamma_max[t]), field.flagged[t] != tet_good);
    }
    EXPECT_GT(n_flagged, 0);
    EXPECT_LT(field.n_flagged, Index(mesh_.tets.size()));
    EXPECT_EQ(field.n_inverted, n_flagged);
    EXPECT_GE(field.n_flagged, field.n_inverted);
  }
}

TEST_P(Strain, CollapsedYarnIsFlaggedEverywhere) {
  const StrainField field = between(Mat3::Identity(), Mat3::Zero());
  EXPECT_EQ(field.n_flagged, Index(mesh_.tets.size()));
  EXPECT_EQ(field.n_inverted, Index(mesh_.tets.size()));
}

/// Pressed in any direction to less than `collapse_stretch` of the reference, in A or in B, however it is turned.
TEST_P(Strain, NearlyFlatTetrahedraAreFlagged) {
  const Mat3 turn = Eigen::AngleAxisd(0.8, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  const auto pressed = [&](double stretch) { return Mat3(turn * Vec3(1, 1.5, stretch).asDiagonal() * turn); };
  const Mat3 flat = pressed(0.99 * collapse_stretch), thick = pressed(1.01 * collapse_stretch);
  for (const StrainField& field : {between(Mat3::Identity(), flat), between(flat, Mat3::Identity())}) {
    EXPECT_EQ(field.n_flagged, Index(mesh_.tets.size()));
    EXPECT_EQ(field.n_inverted, 0);
    EXPECT_EQ(field.flagged[0], tet_collapsed);
    EXPECT_TRUE(std::isnan(field.E[0](0, 0)) && std::isnan(field.det_F[0]));
  }
  for (const StrainField& field : {between(Mat3::Identity(), thick), between(thick, Mat3::Identity())})
    EXPECT_EQ(field.n_flagged, 0);
}

INSTANTIATE_TEST_SUITE_P(Meshes, Strain, ::testing::Values(MeshKind::delaunay, MeshKind::swept),
                         [](const auto& info) { return info.param == MeshKind::delaunay ? "Delaunay" : "Swept"; });

/// The size of gradient errors on a smooth field that is not affine: both meshes agree to first order in the cell size.
TEST(StrainMeshes, AgreeOnTheMeanOfASmoothField) {
  const LatticeYarns yarns{.n_rows = 6, .n_columns = 6, .n_elements = 20, .length = 40};
  const auto reference = yarns.configuration();
  auto bent = reference;
  for (Vec3& r : bent.r) r.z() += 1e-3 * r.x() * r.x() / 2;
  double mean[2];
  for (const MeshKind kind : {MeshKind::delaunay, MeshKind::swept}) {
    const YarnMesh mesh = mesh_yarn(yarns.mesh(), 0, reference.r, {.kind = kind});
    const DeformationGradient gradient(mesh);
    const StrainField field = strain_between(mesh, gradient(reference.r), gradient(bent.r), reference.tangent);
    double sum = 0;
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) sum += mesh.volumes[t] * field.E[t](0, 0);
    mean[kind == MeshKind::swept] = sum / mesh.quality.volume;
  }
  // E_xx = (a x)²/2, whose mean over 0 … L is a² L²/6; chords of length h take a² h²/24 away.
  const double exact = 1e-6 * 1600 / 6, chord = 1e-6 / 24;
  EXPECT_NEAR(mean[0], exact - chord, 1e-12);
  EXPECT_NEAR(mean[1], exact - chord, 1e-12);
}

TEST(YarnFrame, IsRightHandedAndLooksUp) {
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 2, 0), Vec3(1, 1, 0.5), Vec3(0, 0, 3), Vec3(1e-9, 0, -1)}) {
    const Mat3 frame = yarn_frame(axis);
    EXPECT_LT((frame * frame.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_NEAR(frame.determinant(), 1, 1e-14);
    EXPECT_NEAR(frame.row(0).dot(axis), axis.norm(), 1e-14 * axis.norm());
    EXPECT_GE(frame(2, 2), -1e-15);
  }
  EXPECT_EQ(yarn_frame(Vec3(2, 0, 0)), Mat3::Identity());
}

}  // namespace
}  // namespace trame::meso
