/// Strains at nodes, and strains of the tetrahedra of fields that are not affine: bending and torsion of a bundle.

#include "meso/strain/nodal_strain.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <limits>

#include "meso/strain/statistics.h"
#include "tests/support/lattice_yarns.h"

namespace trame::meso {
namespace {

using micro::test::LatticeYarns;
using micro::test::mapped;

constexpr double slope = 0.01;  // of curvature and of twist, per unit of length

/// A deformation with its exact strain in the axes (x, y, z), both of a point of the reference.
struct Field {
  const char* name;
  std::function<Vec3(const Vec3&)> position;
  std::function<Mat3(const Vec3&)> strain;
};

constexpr double y_0 = 2.25, z_0 = 1.7;  // about the middle of the sections below

/// Plane sections stay plane and normal to an arc of curvature κ in the plane (x, z): the only strain is
/// E_xx = ½ ((1 − κ z)² − 1).
const Field bending{"bending",
                    [](const Vec3& X) {
                      const double z = X.z() - z_0, angle = slope * X.x(), radius = 1 / slope - z;
                      return Vec3(radius * std::sin(angle), X.y(), 1 / slope - radius * std::cos(angle));
                    },
                    [](const Vec3& X) {
                      const double stretch = 1 - slope * (X.z() - z_0);
                      return Mat3(Vec3(0.5 * (stretch * stretch - 1), 0, 0).asDiagonal());
                    }};

/// Sections turn by τ x: E_xx = ½ τ² r², E_xy = −½ τ z, E_xz = ½ τ y about the axis.
const Field torsion{"torsion",
                    [](const Vec3& X) {
                      const Vec3 axis(0, y_0, z_0);
                      return Vec3(Eigen::AngleAxisd(slope * X.x(), Vec3::UnitX()) * (X - axis) + axis);
                    },
                    [](const Vec3& X) {
                      const double y = X.y() - y_0, z = X.z() - z_0;
                      Mat3 E = Mat3::Zero();
                      E(0, 0) = 0.5 * slope * slope * (y * y + z * z);
                      E(0, 1) = E(1, 0) = -0.5 * slope * z;
                      E(0, 2) = E(2, 0) = 0.5 * slope * y;
                      return E;
                    }};

/// A yarn of 5 × 5 fibers at distance 1, or of 9 × 9 at ½ with twice as many nodes on each: the same yarn.
class Bundle {
 public:
  Bundle(bool fine, MeshKind kind, const Field& field)
      : yarns_{.n_rows = fine ? 9 : 5,
               .n_columns = fine ? 9 : 5,
               .n_elements = fine ? 10 : 5,
               .spacing = fine ? 0.5 : 1.0,
               .length = 10},
        mesh(mesh_yarn(yarns_.mesh(), 0, yarns_.configuration().r, {.kind = kind})) {
    const auto reference = yarns_.configuration();
    auto r = reference.r;
    for (Vec3& x : r) x = field.position(x);
    const DeformationGradient gradient(mesh);
    strain = strain_between(mesh, gradient(reference.r), gradient(r), reference.tangent);
  }

 private:
  LatticeYarns yarns_;

 public:
  YarnMesh mesh;
  StrainField strain;
};

/// Root mean square over the volume of the error of the tetrahedra's strains at their centres.
double error_of_tets(const Bundle& bundle, const Field& field) {
  double sum = 0;
  for (std::size_t t = 0; t < bundle.mesh.tets.size(); ++t) {
    Vec3 centre = Vec3::Zero();
    for (const Index v : bundle.mesh.tets[t]) centre += 0.25 * bundle.mesh.reference[v];
    sum += bundle.mesh.volumes[t] * (bundle.strain.E[t] - field.strain(centre)).squaredNorm();
  }
  return std::sqrt(sum / bundle.mesh.quality.volume);
}

class Manufactured : public ::testing::TestWithParam<MeshKind> {};

/// Linear tetrahedra: the error of strains falls with the size of the cells.
TEST_P(Manufactured, StrainsOfTetrahedraConvergeWithFirstOrder) {
  for (const Field& field : {bending, torsion}) {
    const double coarse = error_of_tets(Bundle(false, GetParam(), field), field),
                 fine = error_of_tets(Bundle(true, GetParam(), field), field);
    EXPECT_NEAR(coarse / fine, 2, 0.3) << field.name << ": " << coarse << " and " << fine;
    EXPECT_LT(coarse, slope) << field.name;
  }
}

/// A vertex inside sees tetrahedra on all sides. The swept mesh of a lattice is the same turned about such a vertex by
/// 180° and mirrored along the axis, so that what is linear in the field comes out exact; what is left is of the order
/// of the squares of κ and τ, over a cell.
TEST(NodalStrain, InsideExactForWhatIsLinear) {
  for (const Field& field : {bending, torsion}) {
    const Bundle bundle(false, MeshKind::swept, field);
    const NodalStrain nodal = nodal_strain(bundle.mesh, bundle.strain);
    Index n_inside = 0;
    for (std::size_t v = 0; v < bundle.mesh.nodes.size(); ++v) {
      const Vec3& X = bundle.mesh.reference[v];
      const bool inside = X.x() > 0.5 && X.x() < 9.5 && X.y() > 0.9 && X.y() < 3.6 && X.z() > 0.5 && X.z() < 3;
      if (!inside) continue;
      ++n_inside;
      EXPECT_LT((nodal.E[v] - field.strain(X)).cwiseAbs().maxCoeff(), 3 * slope * slope) << field.name << " " << v;
    }
    EXPECT_EQ(n_inside, 3 * 3 * 9) << "3 rows of 3 fibers, 9 nodes on each";
  }
}

/// On the surface the mean over the tetrahedra is the value of a place up to half a cell inside (between the ends:
/// there it is up to two thirds).
TEST(NodalStrain, OnTheSurfaceHalfACellInside) {
  const Bundle bundle(false, MeshKind::swept, bending);
  const NodalStrain nodal = nodal_strain(bundle.mesh, bundle.strain);
  for (std::size_t v = 0; v < bundle.mesh.nodes.size(); ++v) {
    const double x = bundle.mesh.reference[v].x();
    if (x < 0.5 || x > 9.5) continue;
    const double exact = bending.strain(bundle.mesh.reference[v])(0, 0);
    EXPECT_NEAR(nodal.E[v](0, 0), exact, 0.5 * std::sqrt(0.75) * slope + 3 * slope * slope);
  }
}

TEST_P(Manufactured, UniformStrainIsExactAtAllNodes) {
  const LatticeYarns yarns;
  const auto reference = yarns.configuration();
  const YarnMesh mesh = mesh_yarn(yarns.mesh(), 0, reference.r, {.kind = GetParam()});
  const Mat3 F = (Mat3() << 1.02, 0.03, -0.01, 0.05, 0.9, 0.2, -0.04, 0.1, 1.1).finished();
  const DeformationGradient gradient(mesh);
  const StrainField field =
      strain_between(mesh, gradient(reference.r), gradient(mapped(reference, F).r), reference.tangent);
  const NodalStrain nodal = nodal_strain(mesh, field);
  for (std::size_t v = 0; v < mesh.nodes.size(); ++v) {
    EXPECT_LT((nodal.E[v] - green_lagrange(F)).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_NEAR(nodal.det_F[v], F.determinant(), 1e-12);
    EXPECT_NEAR(nodal.gamma_max[v], field.gamma_max[0], 1e-12);
    EXPECT_NEAR(nodal.principal[v][1], field.principal[0][1], 1e-12);
    EXPECT_EQ(nodal.flagged[v], 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, Manufactured, ::testing::Values(MeshKind::delaunay, MeshKind::swept),
                         [](const auto& info) { return info.param == MeshKind::delaunay ? "Delaunay" : "Swept"; });

/// Two tetrahedra with a common face: weights are volumes, flagged ones have none.
TEST(NodalStrain, WeightsAreVolumes) {
  YarnMesh mesh;
  mesh.nodes = {0, 1, 2, 3, 4};
  mesh.tets = {{0, 1, 2, 3}, {1, 2, 3, 4}};
  mesh.volumes = {1, 3};
  StrainField field;
  field.E = {Mat3::Identity(), 5 * Mat3::Identity()};
  field.det_F = {1, 2};
  field.flagged = {tet_good, tet_good};
  const NodalStrain both = nodal_strain(mesh, field);
  EXPECT_DOUBLE_EQ(both.E[0](0, 0), 1);
  EXPECT_DOUBLE_EQ(both.E[1](1, 1), 4);  // (1 · 1 + 3 · 5) / 4
  EXPECT_DOUBLE_EQ(both.det_F[2], 1.75);
  EXPECT_DOUBLE_EQ(both.E[4](2, 2), 5);
  field.flagged[1] = tet_collapsed;
  field.E[1].setConstant(std::numeric_limits<double>::quiet_NaN());
  const NodalStrain first = nodal_strain(mesh, field);
  EXPECT_DOUBLE_EQ(first.E[1](1, 1), 1);
  EXPECT_EQ(first.flagged, (std::vector<Index>{0, 0, 0, 0, 1}));
  EXPECT_TRUE(std::isnan(first.E[4](0, 0)) && std::isnan(first.gamma_max[4]) && std::isnan(first.det_F[4]));
}

TEST(Statistics, OfWeightedValues) {
  const Statistics s = weighted_statistics({{4, 1}, {1, 6}, {2, 3}});
  EXPECT_DOUBLE_EQ(s.mean, 1.6);
  EXPECT_DOUBLE_EQ(s.deviation, std::sqrt(0.6 * 0.36 + 0.3 * 0.16 + 0.1 * 5.76));
  EXPECT_EQ(s.min, 1);
  EXPECT_EQ(s.quantile_05, 1);
  EXPECT_EQ(s.median, 1);
  EXPECT_EQ(s.quantile_95, 4);
  EXPECT_EQ(s.max, 4);
  EXPECT_EQ(weighted_statistics({{1, 1}, {2, 1}, {3, 1}}).median, 2);
  for (const Statistics& none : {weighted_statistics({}), weighted_statistics({{1, 0}})})
    EXPECT_TRUE(std::isnan(none.mean) && std::isnan(none.median) && std::isnan(none.max));
}

}  // namespace
}  // namespace trame::meso
