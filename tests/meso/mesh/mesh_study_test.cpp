/// Figures of data/measurements/meso_*.csv that come from states of a run: TRAME_STATES names them, TRAME_FROM and
/// TRAME_TO are numbers of increments.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>

#include "meso/fiber_states.h"
#include "meso/strain/nodal_strain.h"

namespace trame::meso {
namespace {

/// One yarn's mesh with F in A and in B.
struct YarnGradients {
  YarnMesh mesh;
  std::vector<Mat3> F_a, F_b;
};

class MeshStudy : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* file = std::getenv("TRAME_STATES");
    if (file == nullptr) GTEST_SKIP() << "TRAME_STATES names no states";
    const auto increment = [](const char* name) {
      const char* value = std::getenv(name);
      return value == nullptr ? 0 : std::atoi(value);
    };
    const RunStates states(file);
    fibers = states.header().mesh;
    reference = states.read(0).fibers;
    a = states.read(increment("TRAME_FROM")).fibers;
    b = states.read(increment("TRAME_TO")).fibers;
  }
  [[nodiscard]] std::vector<YarnGradients> yarns(MeshKind kind) const {
    std::vector<YarnGradients> result;
    for (Index y = 0; y < static_cast<Index>(fibers.yarns.size()); ++y) {
      YarnMesh mesh = mesh_yarn(fibers, y, reference.r, {.kind = kind});
      if (mesh.tets.empty()) continue;
      const DeformationGradient gradient(mesh);
      result.push_back({std::move(mesh), gradient(a.r), gradient(b.r)});
    }
    return result;
  }

  micro::FiberMesh fibers;
  micro::FiberConfiguration reference, a, b;
};

/// Means over all yarns where tetrahedra are left out below one smallest stretch or another.
TEST_F(MeshStudy, SmallestStretchAndMeans) {
  const auto all = yarns(MeshKind::delaunay);
  for (const double limit : {0.0, 0.05, 0.1, 0.15, 0.2, 0.3}) {
    double volume = 0, left_out = 0, squares = 0;
    Mat3 mean = Mat3::Zero();
    for (const YarnGradients& yarn : all)
      for (std::size_t t = 0; t < yarn.F_a.size(); ++t) {
        const Mat3 &F_a = yarn.F_a[t], &F_b = yarn.F_b[t];
        const double stretch = std::min(F_a.jacobiSvd().singularValues()[2], F_b.jacobiSvd().singularValues()[2]);
        const double v = yarn.mesh.volumes[t];
        if (F_a.determinant() <= 0 || F_b.determinant() <= 0 || stretch < limit) {
          left_out += v;
          continue;
        }
        Vec3 axis = Vec3::Zero();
        for (const Index n : yarn.mesh.tets[t]) axis += a.tangent[yarn.mesh.nodes[n]];
        const Mat3 frame = yarn_frame(axis), E = frame * green_lagrange(F_b * F_a.inverse()) * frame.transpose();
        volume += v;
        mean += v * E;
        squares += v * E.squaredNorm();
      }
    mean /= volume;
    fmt::print("stretch < {:.2f}: {:.1f} % left out, mean E_horizontal {:.4f}, E_vertical {:.4f}, deviation {:.4g}\n",
               limit, 100 * left_out / (volume + left_out), mean(1, 1), mean(2, 2),
               std::sqrt(squares / volume - mean.squaredNorm()));
  }
}

/// Value at a vertex of the linear fit to E over the patch around it, weighted by volume; the mean where the patch is
/// too small for a fit.
std::vector<Mat3> fitted_strain(const YarnMesh& mesh, const StrainField& field) {
  std::vector<std::vector<std::size_t>> patches(mesh.nodes.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    if (!field.flagged[t])
      for (const Index v : mesh.tets[t]) patches[v].push_back(t);
  std::vector<Mat3> result = nodal_strain(mesh, field).E;
  for (std::size_t v = 0; v < patches.size(); ++v) {
    const auto n = static_cast<Eigen::Index>(patches[v].size());
    Eigen::MatrixX4d places(n, 4);
    Eigen::Matrix<double, Eigen::Dynamic, 9> values(n, 9);
    for (Eigen::Index k = 0; k < n; ++k) {
      const std::size_t t = patches[v][k];
      Vec3 centre = Vec3::Zero();
      for (const Index u : mesh.tets[t]) centre += 0.25 * (mesh.reference[u] - mesh.reference[v]) / mesh.fiber_distance;
      const double weight = std::sqrt(mesh.volumes[t]);
      places.row(k) << weight, weight * centre.transpose();
      values.row(k) = weight * Eigen::Map<const Eigen::Matrix<double, 1, 9>>(field.E[t].data());
    }
    const Eigen::RowVector4d scale = places.colwise().norm().cwiseMax(1e-300);
    Eigen::ColPivHouseholderQR<Eigen::MatrixX4d> qr(n, 4);
    qr.setThreshold(1e-2);
    qr.compute(places.array().rowwise() / scale.array());
    if (n < 4 || qr.rank() < 4) continue;
    const Eigen::Matrix<double, Eigen::Dynamic, 9> fit = qr.solve(values);
    result[v] = Eigen::Map<const Mat3>(Eigen::Matrix<double, 1, 9>(fit.row(0) / scale[0]).data());
  }
  return result;
}

/// How much strains at nodes differ between the two meshes, over their size.
TEST_F(MeshStudy, RecoveryAtNodes) {
  for (const bool fit : {false, true}) {
    std::array<std::map<Index, Mat3>, 2> nodal;  // by node of the fiber mesh
    for (const MeshKind kind : {MeshKind::delaunay, MeshKind::swept})
      for (const YarnGradients& yarn : yarns(kind)) {
        const StrainField field = strain_between(yarn.mesh, yarn.F_a, yarn.F_b, a.tangent);
        const std::vector<Mat3> E = fit ? fitted_strain(yarn.mesh, field) : nodal_strain(yarn.mesh, field).E;
        for (std::size_t v = 0; v < E.size(); ++v) nodal[kind == MeshKind::swept][yarn.mesh.nodes[v]] = E[v];
      }
    Vec3 differences = Vec3::Zero(), squares = Vec3::Zero();
    for (const auto& [node, E] : nodal[0]) {
      const auto other = nodal[1].find(node);
      if (other == nodal[1].end() || !E.allFinite() || !other->second.allFinite()) continue;
      differences += (E - other->second).diagonal().cwiseAbs2();
      squares += E.diagonal().cwiseAbs2();
    }
    const Vec3 ratio = differences.cwiseQuotient(squares).cwiseSqrt();
    fmt::print("{}: E_axial {:.2f}, E_horizontal {:.2f}, E_vertical {:.2f}\n", fit ? "linear fit" : "mean", ratio[0],
               ratio[1], ratio[2]);
  }
}

}  // namespace
}  // namespace trame::meso
