/// \file
/// Hard cases of meso: degenerate points for the triangulation, tetrahedra that collapse or turn inside out, yarns of
/// few fibers, fibers that change places, states with nothing in them.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <random>

#include "meso/comparison.h"
#include "tests/support/analyse.h"
#include "tests/support/lattice_yarns.h"
#include "tests/support/measured.h"
#include "tests/support/temporary_folder.h"

namespace trame::meso {
namespace {

using micro::FiberConfiguration;
using micro::test::input_error;
using micro::test::LatticeYarns;
using micro::test::mapped;
using micro::test::measured;
using test::analyse;
using test::Analysis;

/// A few states in memory.
class States : public FiberStates {
 public:
  States(micro::FiberMesh mesh, std::vector<FiberConfiguration> states) : states_(std::move(states)) {
    header_.mesh = std::move(mesh);
  }
  [[nodiscard]] std::string name() const override { return "states"; }
  [[nodiscard]] const micro::SnapshotHeader& header() const override { return header_; }
  [[nodiscard]] Index n_increments() const override { return static_cast<Index>(states_.size()); }
  [[nodiscard]] micro::Increment read(Index i) const override {
    micro::Increment increment;
    increment.fibers = states_.at(i);
    return increment;
  }

 private:
  micro::SnapshotHeader header_;
  std::vector<FiberConfiguration> states_;
};

const Mat3 some_map = (Mat3() << 1.02, 0.03, -0.01, 0.05, 0.9, 0.2, -0.04, 0.1, 1.1).finished();

/// Largest difference of F from an affine map over a mesh.
double affine_error(const YarnMesh& mesh, const FiberConfiguration& reference) {
  double largest = 0;
  for (const Mat3& F : DeformationGradient(mesh)(mapped(reference, some_map).r))
    largest = std::max(largest, (F - some_map).cwiseAbs().maxCoeff());
  return largest;
}

std::vector<Vec3> shaken(std::vector<Vec3> r, double amplitude) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> draw(-amplitude, amplitude);
  for (Vec3& x : r) x += Vec3(draw(random), draw(random), draw(random));
  return r;
}

/// All that strain_post computes between two states; nothing of it may throw.
struct Everything {
  Analysis analysis;
  std::vector<YarnContinuum> continuum;
  std::vector<SectionPair> sections;
  std::vector<SectionBands> bands;
};
Everything everything(const States& states) {
  const YarnComparer comparer(states, {.n_stations = 3, .bands = {.n_shuffles = 9}, .n_threads = 1});
  const Comparison comparison = comparer.compare({1, 2});
  Everything all{.analysis = analyse(states, {.from = 1, .to = {2}, .n_threads = 1}),
                 .continuum = {},
                 .sections = comparison.yarns[0].sections,
                 .bands = comparison.yarns[0].on_mesh().bands};
  for (const YarnComparison& yarn : comparison.yarns) all.continuum.push_back(yarn.continuum);
  return all;
}
Everything everything(const micro::FiberMesh& mesh, const FiberConfiguration& reference, const FiberConfiguration& a,
                      const FiberConfiguration& b) {
  return everything(States(mesh, {reference, a, b}));
}

/// Square and hexagonal lattices, all corners of a cell on one sphere, with noise from none and below round-off to 3 %.
TEST(MesoHardCases, CosphericalLattices) {
  double smallest_angle = 180;
  Index n_slivers = 0, n_unused = 0;
  for (const bool square : {false, true})
    for (const double noise : {0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-4, 1e-2, 3e-2}) {
      const LatticeYarns yarns{.n_rows = 6, .n_columns = 7, .n_elements = 8, .length = 16};
      FiberConfiguration fibers = yarns.configuration();
      if (square)
        for (Vec3& x : fibers.r) {
          const double row = std::round(x.z() / std::sqrt(0.75));
          x = Vec3(x.x(), x.y() - 0.5 * std::fmod(row, 2), row);
        }
      fibers.r = shaken(fibers.r, noise);
      const YarnMesh mesh = mesh_yarn(yarns.mesh(), 0, fibers.r);
      ASSERT_EQ(mesh.status, MeshStatus::ok);
      smallest_angle = std::min(smallest_angle, mesh.quality.min_dihedral);
      n_slivers += mesh.quality.n_slivers;
      n_unused += mesh.quality.n_unused_fibers;
      EXPECT_LT(affine_error(mesh, fibers), 1e-10) << "noise " << noise;
    }
  measured(fmt::format("16 lattices: smallest dihedral angle {:.1f}°, {} slivers, {} fibers left out", smallest_angle,
                       n_slivers, n_unused));
  EXPECT_GE(smallest_angle, MeshLimits().min_dihedral);
  EXPECT_EQ(n_slivers, 0);
  EXPECT_EQ(n_unused, 0);
}

/// All fibers side by side, exactly and up to round-off; and all on one line along the yarn (one fiber in another).
TEST(MesoHardCases, CollinearAndCoplanarNodes) {
  const LatticeYarns layer{.n_rows = 1, .n_columns = 8};
  Index n_tets = 0;
  for (const double noise : {0.0, 1e-15, 1e-12}) {
    FiberConfiguration fibers = layer.configuration();
    fibers.r = shaken(fibers.r, noise);
    for (const MeshKind kind : {MeshKind::delaunay, MeshKind::swept}) {
      const YarnMesh mesh = mesh_yarn(layer.mesh(), 0, fibers.r, {.kind = kind});
      EXPECT_EQ(mesh.status, MeshStatus::flat_section);
      n_tets += static_cast<Index>(mesh.tets.size());
    }
  }
  const LatticeYarns yarns;
  FiberConfiguration line = yarns.configuration();
  for (Vec3& x : line.r) x = Vec3(x.x(), 0, 0);
  const std::string error = input_error([&] { (void)analyse(States(yarns.mesh(), {line, line}), {}); });
  measured(fmt::format("{} tetrahedra of 6 flat meshes; on one line: \"{}\"", n_tets, error));
  EXPECT_EQ(n_tets, 0);
  EXPECT_NE(error.find("its fibers lie in one another in the reference state"), std::string::npos);
}

/// The outline of the section dented by 10⁻⁹ to 0.2 fiber distances: flat tetrahedra over each dent, unless they are
/// carved away; and none of the dented fibers may be lost with them.
TEST(MesoHardCases, SliversOnTheOutline) {
  const LatticeYarns yarns{.n_rows = 5, .n_columns = 8, .n_elements = 10, .length = 20};
  const double top = 4 * std::sqrt(0.75);
  double smallest_angle = 180, largest_error = 0;
  for (const double dent : {1e-9, 1e-6, 1e-3, 0.05, 0.2}) {
    FiberConfiguration fibers = yarns.configuration();
    for (Vec3& x : fibers.r)
      if (x.z() > 0.99 * top && static_cast<int>(x.y()) % 2 == 1) x.z() -= dent;
    const YarnMesh mesh = mesh_yarn(yarns.mesh(), 0, fibers.r);
    smallest_angle = std::min(smallest_angle, mesh.quality.min_dihedral);
    largest_error = std::max(largest_error, affine_error(mesh, fibers));
    EXPECT_EQ(mesh.quality.n_slivers, 0) << dent;
    EXPECT_EQ(mesh.quality.n_unused_fibers, 0) << dent;
  }
  measured(fmt::format("smallest dihedral angle {:.1f}°, error of an affine F {:.1e}", smallest_angle, largest_error));
  EXPECT_GE(smallest_angle, MeshLimits().min_dihedral);
  EXPECT_LT(largest_error, 1e-10);
}

/// Half of the yarn mirrored: det F < 0 there. What is flagged is exactly that, and the other half is not touched by
/// it.
TEST(MesoHardCases, InvertedTetrahedra) {
  const LatticeYarns yarns{.n_rows = 4, .n_columns = 5, .n_elements = 10, .length = 20};
  const FiberConfiguration reference = yarns.configuration();
  FiberConfiguration b = reference;
  for (Vec3& x : b.r)
    if (x.x() > 10) x.z() = -x.z();
  const Everything all = everything(yarns.mesh(), reference, reference, b);
  const StrainField& field = all.analysis.fields[0].strain;
  double largest_left = 0;
  Index n_wrong = 0;
  for (std::size_t t = 0; t < field.E.size(); ++t) {
    double low = 1e9, high = 0;
    for (const Index v : all.analysis.meshes[0].tets[t]) {
      low = std::min(low, all.analysis.meshes[0].reference[v].x());
      high = std::max(high, all.analysis.meshes[0].reference[v].x());
    }
    if (low > 10) n_wrong += field.flagged[t] != tet_inverted;
    if (high <= 10) largest_left = std::max(largest_left, field.E[t].norm());
  }
  measured(fmt::format("{} of {} tetrahedra flagged, {} missed, |E| ≤ {:.0e} in the other half", field.n_flagged,
                       field.E.size(), n_wrong, largest_left));
  EXPECT_EQ(n_wrong, 0);
  EXPECT_LT(largest_left, 1e-12);
}

/// State A pressed flat to a thousandth over a fifth of its length, B = reference: E ~ 10⁶/2 there unless it is
/// flagged.
TEST(MesoHardCases, CollapsedTetrahedraDoNotSpoilMeans) {
  const LatticeYarns yarns{.n_rows = 4, .n_columns = 5, .n_elements = 10, .length = 20};
  const FiberConfiguration reference = yarns.configuration();
  FiberConfiguration a = reference;
  for (Vec3& x : a.r)
    if (x.x() > 16) x.z() *= 1e-3;
  const Everything all = everything(yarns.mesh(), reference, a, reference);
  const YarnStrain& row = all.analysis.strains.at(0);
  measured(fmt::format("{} of {} flagged; vertical strain: mean {:.2g}, median {:.1g}, largest {:.2g}", row.n_flagged,
                       row.n_tets, row.vertical.mean, row.vertical.median, row.vertical.max));
  EXPECT_GT(row.n_flagged, 0.15 * row.n_tets);
  EXPECT_EQ(row.n_inverted, 0);
  EXPECT_NEAR(row.vertical.median, 0, 1e-12);
  // |E| < ½ λ_max²(F_B) / λ_min²(F_A), F_B = I.
  EXPECT_LE(row.gamma_max.max, 0.5 / (collapse_stretch * collapse_stretch));
}

/// The whole yarn pressed into a plane, a line and a point: all flagged, means NaN, no crash.
TEST(MesoHardCases, YarnCollapsedAltogether) {
  const LatticeYarns yarns;
  const FiberConfiguration reference = yarns.configuration();
  Index n_flagged = 0, n_tets = 0;
  for (const Vec3& scale : {Vec3(1, 1, 0), Vec3(1, 0, 0), Vec3(0, 0, 0)}) {
    const FiberConfiguration flat = mapped(reference, scale.asDiagonal());
    for (const bool as_a : {true, false}) {
      const Everything all = as_a ? everything(yarns.mesh(), reference, flat, reference)
                                  : everything(yarns.mesh(), reference, reference, flat);
      n_flagged += all.analysis.strains.at(0).n_flagged;
      n_tets += all.analysis.strains.at(0).n_tets;
      EXPECT_TRUE(std::isnan(all.analysis.strains.at(0).axial.mean));
      EXPECT_TRUE(all.analysis.fields[0].zones.zones.empty());
      for (const SectionBands& cut : all.bands) EXPECT_TRUE(cut.bands.empty());
    }
  }
  measured(fmt::format("{} of {} tetrahedra flagged", n_flagged, n_tets));
  EXPECT_EQ(n_flagged, n_tets);
}

/// One and two fibers enclose no volume, three do.
TEST(MesoHardCases, YarnsOfFewFibers) {
  std::string figures;
  for (const Index n_fibers : {1, 2, 3}) {
    const LatticeYarns yarns{.n_rows = 2, .n_columns = 2};
    micro::FiberMesh mesh = yarns.mesh();
    mesh.yarns[0].n_fibers = n_fibers;
    const FiberConfiguration reference = yarns.configuration(), b = mapped(reference, some_map);
    const Everything all = everything(mesh, reference, reference, b);
    figures += fmt::format("{}{}: {} tetrahedra, {}", figures.empty() ? "" : "; ", n_fibers, all.analysis.n_tets,
                           text(all.continuum[0].verdict));
    EXPECT_EQ(all.analysis.meshes[0].status, n_fibers < 3 ? MeshStatus::too_few_fibers : MeshStatus::ok);
    EXPECT_EQ(all.analysis.strains.size(), n_fibers < 3 ? 0u : 1u);
    EXPECT_EQ(all.continuum[0].verdict, n_fibers < 3 ? ContinuumVerdict::too_few_fibers : ContinuumVerdict::holds);
    for (const SectionPair& pair : all.sections) {
      EXPECT_EQ(pair.a.status, SectionStatus::ok);
      EXPECT_EQ(Index(pair.a.fibers.size()), n_fibers);
    }
    if (n_fibers == 3) {
      const Mat3 expected = green_lagrange(some_map);
      EXPECT_NEAR(all.analysis.strains[0].axial.mean, expected(0, 0), 1e-10);
    }
  }
  measured(figures);
}

/// Two neighbours inside a yarn change places along the whole length.
TEST(MesoHardCases, FibersThatChangePlaces) {
  const LatticeYarns yarns{.n_rows = 5, .n_columns = 6, .n_elements = 10, .length = 20};
  const FiberConfiguration reference = yarns.configuration();
  FiberConfiguration b = reference;
  const Index n = yarns.n_nodes_per_fiber(), left = (2 * 6 + 2) * n, right = left + n;
  for (Index k = 0; k < n; ++k) std::swap(b.r[left + k], b.r[right + k]);
  const Everything all = everything(yarns.mesh(), reference, reference, b);
  const YarnStrain& row = all.analysis.strains.at(0);
  measured(
      fmt::format("{:.0f} % of the tetrahedra flagged, {:.1f} % of the neighbours new, median strain elsewhere {:.0e}",
                  100.0 * row.n_flagged / row.n_tets, 100 * all.continuum[0].exchanged, row.gamma_max.median));
  // Of 30 fibers each has about 24 tetrahedra a layer around it: what two of them touch is flagged or strained at most.
  EXPECT_GT(row.n_flagged, 0);
  EXPECT_LT(row.n_flagged, 0.25 * row.n_tets);
  EXPECT_LT(row.gamma_max.median, 1e-12);
  EXPECT_GT(all.continuum[0].exchanged, 0);
  EXPECT_NE(all.continuum[0].verdict, ContinuumVerdict::holds);
}

/// NaN in one node's position: run files with it are refused by name; in memory it costs what it touches and no more.
TEST(MesoHardCases, NanInAState) {
  const LatticeYarns yarns{.n_rows = 4, .n_columns = 5};
  const FiberConfiguration reference = yarns.configuration();
  FiberConfiguration broken = mapped(reference, some_map);
  broken.r[77].y() = std::numeric_limits<double>::quiet_NaN();
  const trame::test::TemporaryFolder folder;
  {
    micro::SnapshotWriter writer(folder / "states.h5", {"1", "scene", "", yarns.mesh(), {}});
    for (const FiberConfiguration& state : {reference, broken}) {
      micro::Increment increment;
      increment.fibers = state;
      writer.append(increment);
    }
  }
  const std::string error = input_error([&] { (void)analyse(RunStates(folder / "states.h5"), {}); });
  EXPECT_NE(error.find("not finite"), std::string::npos) << error;
  EXPECT_NE(error.find("increment 1"), std::string::npos) << error;
  const Everything all = everything(yarns.mesh(), reference, reference, broken);
  const YarnStrain& row = all.analysis.strains.at(0);
  measured(fmt::format("file: refused; in memory: {} of {} tetrahedra flagged, axial strain off by {:.0e}",
                       row.n_flagged, row.n_tets, std::abs(row.axial.mean - green_lagrange(some_map)(0, 0))));
  EXPECT_GT(row.n_flagged, 0);
  EXPECT_LE(row.n_flagged, 40) << "the tetrahedra around one node";
  EXPECT_NEAR(row.axial.mean, green_lagrange(some_map)(0, 0), 1e-10);
}

/// A file with the reference state alone: strains from it to itself.
TEST(MesoHardCases, OneIncrementOnly) {
  const LatticeYarns yarns{.n_yarns = 2};
  const States states(yarns.mesh(), {yarns.configuration()});
  const Analysis analysis = analyse(states, {});
  double largest = 0;
  for (const YarnStrain& row : analysis.strains)
    largest = std::max({largest, std::abs(row.axial.min), row.gamma_max.max, std::abs(row.det_F.mean - 1)});
  measured(fmt::format("{} yarns, largest strain {:.0e}", analysis.strains.size(), largest));
  EXPECT_EQ(analysis.strains.size(), 2u);
  EXPECT_LT(largest, 1e-12);
}

}  // namespace
}  // namespace trame::meso
