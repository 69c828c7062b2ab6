#include "meso/yarn_fields.h"

#include "meso/non_affine.h"

namespace trame::meso {

YarnFields yarn_fields(const micro::FiberMesh& fibers, const YarnMesh& mesh, const std::vector<Mat3>& F_a,
                       const std::vector<Mat3>& F_b, const micro::FiberConfiguration& a,
                       const micro::FiberConfiguration& b) {
  YarnFields fields;
  fields.strain = strain_between(mesh, F_a, F_b, a.tangent);
  fields.nodal = nodal_strain(mesh, fields.strain);
  const micro::Yarn& yarn = fibers.yarns[mesh.yarn];
  const std::vector<double> D2 = non_affine_residual(fibers, yarn, a.r, b.r);
  for (const Index n : mesh.nodes) fields.D2_min.push_back(D2[n - fibers.first_node[yarn.first_fiber]]);
  fields.zones = find_shear_zones(mesh, a.r, fields.strain.gamma_max);
  return fields;
}

}  // namespace trame::meso
