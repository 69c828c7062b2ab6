#include "meso/strain/strain.h"

#include <deal.II/base/multithread_info.h>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/dofs/dof_handler.h>
#include <deal.II/fe/fe_simplex_p.h>
#include <deal.II/fe/fe_system.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/fe/mapping_fe.h>
#include <deal.II/grid/tria.h>
#include <deal.II/lac/vector.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>

namespace trame::meso {

struct DeformationGradient::Impl {
  std::vector<Index> nodes;
  double scale = 1;  ///< reference lengths are in fiber distances, so that the library sees numbers near 1
  dealii::Triangulation<3> triangulation;
  dealii::MappingFE<3> mapping{dealii::FE_SimplexP<3>(1)};
  dealii::FESystem<3> element{dealii::FE_SimplexP<3>(1), 3};
  dealii::DoFHandler<3> dofs;
  std::vector<std::array<dealii::types::global_dof_index, 3>> vertex_dofs;

  explicit Impl(const YarnMesh& mesh) : nodes(mesh.nodes), scale(1 / mesh.fiber_distance) {
    std::vector<dealii::Point<3>> vertices;
    for (const Vec3& x : mesh.reference) vertices.emplace_back(scale * x.x(), scale * x.y(), scale * x.z());
    std::vector<dealii::CellData<3>> cells;
    for (const auto& tet : mesh.tets) {
      dealii::CellData<3> cell(4);
      for (int v = 0; v < 4; ++v) cell.vertices[v] = static_cast<unsigned>(tet[v]);
      cells.push_back(cell);
    }
    triangulation.create_triangulation(vertices, cells, dealii::SubCellData());
    dofs.reinit(triangulation);
    dofs.distribute_dofs(element);
    vertex_dofs.resize(vertices.size());
    for (const auto& cell : dofs.active_cell_iterators())
      for (const unsigned v : cell->vertex_indices())
        for (unsigned i = 0; i < 3; ++i) vertex_dofs[cell->vertex_index(v)][i] = cell->vertex_dof_index(v, i);
  }
};

DeformationGradient::DeformationGradient(const YarnMesh& mesh) {
  // Yarns are what runs in parallel; threads of the library's own would only be in the way.
  static std::once_flag once;
  std::call_once(once, [] { dealii::MultithreadInfo::set_thread_limit(1); });
  impl_ = std::make_unique<Impl>(mesh);
}

DeformationGradient::~DeformationGradient() = default;
DeformationGradient::DeformationGradient(DeformationGradient&&) noexcept = default;

std::vector<Mat3> DeformationGradient::operator()(const std::vector<Vec3>& r) const {
  const Impl& impl = *impl_;
  dealii::Vector<double> position(impl.dofs.n_dofs());
  for (std::size_t v = 0; v < impl.nodes.size(); ++v)
    for (unsigned i = 0; i < 3; ++i) position[impl.vertex_dofs[v][i]] = impl.scale * r[impl.nodes[v]][i];
  const dealii::QGaussSimplex<3> centre(1);
  dealii::FEValues<3> values(impl.mapping, impl.element, centre, dealii::update_gradients);
  const dealii::FEValuesExtractors::Vector x(0);
  std::vector<dealii::Tensor<2, 3>> gradient(1);
  std::vector<Mat3> F;
  F.reserve(impl.triangulation.n_active_cells());
  for (const auto& cell : impl.dofs.active_cell_iterators()) {
    values.reinit(cell);
    values[x].get_function_gradients(position, gradient);
    Mat3& F_cell = F.emplace_back();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) F_cell(i, j) = gradient[0][i][j];
  }
  return F;
}

Mat3 green_lagrange(const Mat3& F) { return 0.5 * (F.transpose() * F - Mat3::Identity()); }

namespace {

/// Smallest singular value.
double smallest_stretch(const Mat3& F) {
  Eigen::SelfAdjointEigenSolver<Mat3> squares;
  squares.computeDirect(F.transpose() * F, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(squares.eigenvalues()[0], 0.0));
}

TetFlag flag_of(const Mat3& F_a, const Mat3& F_b, const Vec3& axis) {
  // "Not above 0" is true for NaN, too.
  if (!(F_a.determinant() > 0 && F_b.determinant() > 0 && axis.norm() > 0)) return tet_inverted;
  const double stretch = std::min(smallest_stretch(F_a), smallest_stretch(F_b));
  return stretch >= collapse_stretch ? tet_good : tet_collapsed;
}

}  // namespace

StrainField strain_between(const YarnMesh& mesh, const std::vector<Mat3>& F_a, const std::vector<Mat3>& F_b,
                           const std::vector<Vec3>& tangent_a) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  StrainField field;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    Vec3 axis = Vec3::Zero();
    for (const Index v : mesh.tets[t]) axis += tangent_a[mesh.nodes[v]];
    const TetFlag flag = flag_of(F_a[t], F_b[t], axis);
    field.flagged.push_back(flag);
    field.n_flagged += flag == tet_good ? 0 : 1;
    field.n_inverted += flag == tet_inverted ? 1 : 0;
    field.det_F.push_back(flag == tet_good ? F_b[t].determinant() / F_a[t].determinant() : nan);
    Mat3 E = Mat3::Constant(nan);
    Vec3 principal = Vec3::Constant(nan);
    if (flag == tet_good) {
      const Mat3 frame = yarn_frame(axis);
      E = frame * green_lagrange(F_b[t] * F_a[t].inverse()) * frame.transpose();
      principal = Eigen::SelfAdjointEigenSolver<Mat3>(E, Eigen::EigenvaluesOnly).eigenvalues().reverse();
    }
    field.E.push_back(E);
    field.principal.push_back(principal);
    field.gamma_max.push_back(principal[0] - principal[2]);
  }
  return field;
}

}  // namespace trame::meso
