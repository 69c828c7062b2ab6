#include "meso/strain/nodal_strain.h"

#include <Eigen/Eigenvalues>
#include <limits>

namespace trame::meso {

NodalStrain nodal_strain(const YarnMesh& mesh, const StrainField& field) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const std::size_t n = mesh.nodes.size();
  NodalStrain nodal{.E = std::vector<Mat3>(n, Mat3::Zero()),
                    .principal = std::vector<Vec3>(n, Vec3::Constant(nan)),
                    .gamma_max = std::vector<double>(n, nan),
                    .det_F = std::vector<double>(n, 0),
                    .flagged = std::vector<Index>(n, 0)};
  std::vector<double> volume(n, 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (field.flagged[t]) continue;
    for (const Index v : mesh.tets[t]) {
      volume[v] += mesh.volumes[t];
      nodal.E[v] += mesh.volumes[t] * field.E[t];
      nodal.det_F[v] += mesh.volumes[t] * field.det_F[t];
    }
  }
  for (std::size_t v = 0; v < n; ++v) {
    nodal.flagged[v] = volume[v] > 0 ? 0 : 1;
    nodal.E[v] /= volume[v];  // 0 / 0 is NaN
    nodal.det_F[v] /= volume[v];
    if (nodal.flagged[v]) continue;
    nodal.principal[v] =
        Eigen::SelfAdjointEigenSolver<Mat3>(nodal.E[v], Eigen::EigenvaluesOnly).eigenvalues().reverse();
    nodal.gamma_max[v] = nodal.principal[v][0] - nodal.principal[v][2];
  }
  return nodal;
}

}  // namespace trame::meso
