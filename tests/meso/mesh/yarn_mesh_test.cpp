#include "meso/mesh/yarn_mesh.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "meso/mesh/tetrahedron.h"
#include "tests/support/lattice_yarns.h"

namespace trame::meso {
namespace {

using micro::test::LatticeYarns;

const MeshKind both_kinds[] = {MeshKind::delaunay, MeshKind::swept};

TEST(Tetrahedron, CornerOfACube) {
  const Tet tet = {Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  EXPECT_DOUBLE_EQ(volume(tet), 1.0 / 6);
  EXPECT_DOUBLE_EQ(volume({tet[1], tet[0], tet[2], tet[3]}), -1.0 / 6);
  EXPECT_DOUBLE_EQ(circumradius(tet), std::sqrt(3.0) / 2);
  const auto [smallest, largest] = dihedral_range(tet);
  EXPECT_NEAR(smallest, std::acos(1 / std::sqrt(3.0)) * 180 / std::numbers::pi, 1e-12);
  EXPECT_NEAR(largest, 90, 1e-12);
}

TEST(Tetrahedron, RegularOneHasOneAngle) {
  const auto [smallest, largest] = dihedral_range({Vec3(1, 1, 1), Vec3(1, -1, -1), Vec3(-1, 1, -1), Vec3(-1, -1, 1)});
  EXPECT_NEAR(smallest, std::acos(1.0 / 3) * 180 / std::numbers::pi, 1e-12);
  EXPECT_NEAR(largest, smallest, 1e-12);
}

TEST(Tetrahedron, FlatOnesHaveNoCircumradius) {
  EXPECT_TRUE(std::isinf(circumradius(Tet{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0)})));
  EXPECT_TRUE(std::isinf(circumradius(Triangle{Vec2(0, 0), Vec2(1, 1), Vec2(2, 2)})));
}

TEST(Tetrahedron, CircumradiusOfATriangle) {
  EXPECT_DOUBLE_EQ(circumradius(Triangle{Vec2(0, 0), Vec2(3, 0), Vec2(0, 4)}), 2.5);
}

/// What must hold for every mesh: positive volumes, no face shared by more than two cells, every node of every fiber
/// used.
void expect_sound(const YarnMesh& mesh, std::size_t n_nodes) {
  ASSERT_EQ(mesh.status, MeshStatus::ok);
  EXPECT_EQ(std::set<Index>(mesh.nodes.begin(), mesh.nodes.end()).size(), mesh.nodes.size());
  EXPECT_EQ(mesh.nodes.size(), n_nodes);
  EXPECT_EQ(mesh.quality.n_unused_fibers, 0);
  EXPECT_EQ(mesh.quality.n_slivers, 0);
  EXPECT_EQ(mesh.quality.n_inverted_removed, 0);
  std::map<std::set<Index>, int> faces;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    Tet x;
    for (int i = 0; i < 4; ++i) x[i] = mesh.reference[mesh.tets[t][i]];
    EXPECT_GT(volume(x), 0);
    EXPECT_EQ(volume(x), mesh.volumes[t]);
    for (int i = 0; i < 4; ++i) {
      std::set<Index> face(mesh.tets[t].begin(), mesh.tets[t].end());
      face.erase(mesh.tets[t][i]);
      EXPECT_LE(++faces[face], 2);
    }
  }
}

TEST(YarnMesh, FillsTheLattice) {
  // Spacings as in a real yarn: nodes much farther apart along fibers than fibers are from each other, all in metres.
  const LatticeYarns yarns{
      .n_yarns = 2, .n_rows = 4, .n_columns = 6, .n_elements = 10, .spacing = 2e-5, .length = 3e-3};
  for (const MeshKind kind : both_kinds) {
    const YarnMesh mesh = mesh_yarn(yarns.mesh(), 1, yarns.configuration().r, {.kind = kind});
    expect_sound(mesh, 24 * 21);
    EXPECT_EQ(mesh.yarn, 1);
    EXPECT_NEAR(mesh.fiber_distance, 2e-5, 1e-18);
    EXPECT_NEAR(mesh.node_spacing, 3e-3 / 20, 1e-17);
    EXPECT_EQ(mesh.tets.size(), 3u * 30 * 20) << "3 in each prism, 30 triangles, 20 layers";
    EXPECT_NEAR(mesh.quality.volume / (yarns.section_area() * yarns.length), 1, 1e-12);
    EXPECT_NEAR(mesh.quality.min_volume / mesh.quality.max_volume, 1, 1e-9);
    EXPECT_GT(mesh.quality.min_dihedral, 10);
    EXPECT_LT(mesh.quality.max_dihedral, 140);
    for (const Index n : mesh.nodes) EXPECT_GE(n, 24 * 21) << "nodes of the other yarn";
  }
}

/// Fibers after any computation: a lattice with a little noise, which makes plain Delaunay triangulations full of
/// slivers.
TEST(YarnMesh, NoiseMakesNoSlivers) {
  const LatticeYarns yarns{.n_rows = 5, .n_columns = 7, .n_elements = 15};
  for (const double noise : {1e-9, 1e-6, 1e-4, 1e-3, 1e-2}) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-noise, noise);
    auto r = yarns.configuration().r;
    for (Vec3& x : r) x += Vec3(uniform(random), uniform(random), uniform(random));
    for (const MeshKind kind : both_kinds) {
      const YarnMesh mesh = mesh_yarn(yarns.mesh(), 0, r, {.kind = kind});
      expect_sound(mesh, 35 * 31);
      EXPECT_GT(mesh.quality.min_dihedral, 5) << "noise " << noise;
      EXPECT_NEAR(mesh.quality.volume / (yarns.section_area() * yarns.length), 1, 10 * noise + 1e-12)
          << "noise " << noise;
    }
  }
}

/// A yarn bent to a quarter of a circle: by Pappus, its volume is that of the straight one of the length of the path of
/// its section's centroid, less what chords cut off arcs.
TEST(YarnMesh, CurvedYarn) {
  const LatticeYarns yarns{.n_rows = 3, .n_columns = 5, .n_elements = 40, .length = 100};
  auto r = yarns.configuration().r;
  auto fibers = yarns.mesh();
  double centroid = 0;
  for (const Vec3& x : r) centroid += x.z() / double(r.size());
  const double radius = yarns.length / (std::numbers::pi / 2);
  for (std::size_t n = 0; n < r.size(); ++n) {
    const double angle = r[n].x() / radius, distance = radius + r[n].z() - centroid;
    fibers.arc_length[n] = angle * distance;
    r[n] = Vec3(distance * std::sin(angle), r[n].y(), distance * std::cos(angle));
  }
  for (const MeshKind kind : both_kinds) {
    const YarnMesh mesh = mesh_yarn(fibers, 0, r, {.kind = kind});
    expect_sound(mesh, 15 * 81);
    EXPECT_NEAR(mesh.quality.volume / (yarns.section_area() * yarns.length), 1, 1e-4);
  }
}

/// Turned by half a revolution over its length: the straight bundle's volume, less what is cut off on the turning
/// outline.
TEST(YarnMesh, TwistedYarn) {
  const LatticeYarns yarns{.n_rows = 3, .n_columns = 3, .n_elements = 60, .length = 120};
  auto r = yarns.configuration().r;
  auto fibers = yarns.mesh();
  const Vec3 centre = [&] {
    Vec3 sum = Vec3::Zero();
    for (const Vec3& x : r) sum += x;
    return Vec3(sum / double(r.size()));
  }();
  for (std::size_t n = 0; n < r.size(); ++n) {
    const double turn = std::numbers::pi * r[n].x() / yarns.length;
    const Vec3 arm(0, r[n].y() - centre.y(), r[n].z() - centre.z());
    fibers.arc_length[n] *= std::hypot(1, arm.norm() * std::numbers::pi / yarns.length);
    r[n] = Vec3(r[n].x(), 0, 0) + Eigen::AngleAxisd(turn, Vec3::UnitX()) * arm;
  }
  for (const MeshKind kind : both_kinds) {
    const YarnMesh mesh = mesh_yarn(fibers, 0, r, {.kind = kind});
    expect_sound(mesh, 9 * 121);
    EXPECT_NEAR(mesh.quality.volume / (yarns.section_area() * yarns.length), 1, 0.01);
  }
}

TEST(YarnMesh, FewFibersGiveAnEmptyMesh) {
  for (const Index n_fibers : {1, 2}) {
    const LatticeYarns yarns{.n_rows = 1, .n_columns = n_fibers};
    for (const MeshKind kind : both_kinds) {
      const YarnMesh mesh = mesh_yarn(yarns.mesh(), 0, yarns.configuration().r, {.kind = kind});
      EXPECT_EQ(mesh.status, MeshStatus::too_few_fibers);
      EXPECT_TRUE(mesh.tets.empty());
    }
  }
}

TEST(YarnMesh, ThreeFibersGiveOneTriangle) {
  const LatticeYarns yarns{.n_rows = 2, .n_columns = 2};
  auto fibers = yarns.mesh();
  fibers.yarns[0].n_fibers = 3;
  for (const MeshKind kind : both_kinds) {
    const YarnMesh mesh = mesh_yarn(fibers, 0, yarns.configuration().r, {.kind = kind});
    expect_sound(mesh, 33);
    EXPECT_NEAR(mesh.quality.volume, std::sqrt(3.0) / 4 * yarns.length, 1e-12);
  }
}

TEST(YarnMesh, FibersInOneLayerEncloseNothing) {
  const LatticeYarns yarns{.n_rows = 1, .n_columns = 6};
  for (const double noise : {0.0, 1e-9}) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-noise, noise);
    auto r = yarns.configuration().r;
    for (Vec3& x : r) x += Vec3(uniform(random), uniform(random), uniform(random));
    for (const MeshKind kind : both_kinds)
      EXPECT_EQ(mesh_yarn(yarns.mesh(), 0, r, {.kind = kind}).status, MeshStatus::flat_section) << "noise " << noise;
  }
}

/// One fiber away from the others: it belongs to the yarn, so the mesh reaches out for it.
TEST(YarnMesh, FiberApartIsKept) {
  const LatticeYarns yarns{.n_rows = 2, .n_columns = 3};
  auto r = yarns.configuration().r;
  for (Index n = 0; n < 11; ++n) r[n].y() -= 0.8;
  for (const MeshKind kind : both_kinds) expect_sound(mesh_yarn(yarns.mesh(), 0, r, {.kind = kind}), 66);
}

TEST(YarnMesh, UnequalFibersCanOnlyBeTriangulated) {
  const LatticeYarns yarns{.n_rows = 2, .n_columns = 2, .length = 20};
  auto fibers = yarns.mesh();
  auto r = yarns.configuration().r;
  // Fiber 0 with 9 nodes instead of 11.
  fibers.arc_length.erase(fibers.arc_length.begin(), fibers.arc_length.begin() + 2);
  r.erase(r.begin(), r.begin() + 2);
  for (std::size_t f = 1; f < fibers.first_node.size(); ++f) fibers.first_node[f] -= 2;
  for (Index n = 0; n < 9; ++n) {
    fibers.arc_length[n] = 2.5 * n;
    r[n] = Vec3(2.5 * n, 0, 0);
  }
  EXPECT_EQ(mesh_yarn(fibers, 0, r, {.kind = MeshKind::swept}).status, MeshStatus::unequal_fibers);
  const YarnMesh mesh = mesh_yarn(fibers, 0, r);
  ASSERT_EQ(mesh.status, MeshStatus::ok);
  EXPECT_NEAR(mesh.quality.volume / (yarns.section_area() * yarns.length), 1, 1e-9);
}

}  // namespace
}  // namespace trame::meso
