#include "micro/states/fibers_vtk.h"

#include <vtkAppendPolyData.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkXMLPolyDataWriter.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "micro/fiber/lagrange.h"
#include "micro/states/vtk_copies.h"
#include "micro/states/vtk_series.h"

namespace trame::micro {
namespace {

/// One 3-node element: its first node and the derivatives of the quadratic through its nodes with respect to arc
/// length.
struct Element {
  const FiberMesh& mesh;
  Index first;

  [[nodiscard]] Vec3 derivative(const std::vector<Vec3>& r, double s) const {
    return lagrange_shape(&mesh.arc_length[first], s).derivative(r, first);
  }
  [[nodiscard]] Vec3 second_derivative(const std::vector<Vec3>& r) const {
    const double h = mesh.arc_length[first + 2] - mesh.arc_length[first];
    return (derivative(r, mesh.arc_length[first + 2]) - derivative(r, mesh.arc_length[first])) / h;
  }
};

/// Calls `visit(fiber, element)` for every element.
template <class Visit>
void for_each_element(const FiberMesh& mesh, Visit&& visit) {
  for (Index f = 0; f < mesh.n_fibers(); ++f)
    for (Index e = 0; e < mesh.n_elements(f); ++e) visit(f, Element{mesh, mesh.first_node[f] + 2 * e});
}

/// Elements that meet at each node: 2 between elements, else 1.
std::vector<double> elements_at_nodes(const FiberMesh& mesh) {
  std::vector<double> count(mesh.n_nodes(), 0.0);
  for_each_element(mesh, [&](Index, const Element& element) {
    for (int i = 0; i < 3; ++i) count[element.first + i] += 1;
  });
  return count;
}

/// Length of fiber that is nearer to each node than to any other.
std::vector<double> tributary_length(const FiberMesh& mesh) {
  std::vector<double> length(mesh.n_nodes(), 0.0);
  for (Index f = 0; f < mesh.n_fibers(); ++f)
    for (Index n = mesh.first_node[f]; n + 1 < mesh.first_node[f + 1]; ++n) {
      const double half = 0.5 * (mesh.arc_length[n + 1] - mesh.arc_length[n]);
      length[n] += half;
      length[n + 1] += half;
    }
  return length;
}

Index nearest_node(const FiberMesh& mesh, Index fiber, double s) {
  const auto begin = mesh.arc_length.begin() + mesh.first_node[fiber];
  const auto end = mesh.arc_length.begin() + mesh.first_node[fiber + 1];
  auto upper = std::lower_bound(begin, end, s);
  if (upper == end) --upper;
  if (upper != begin && s - *(upper - 1) < *upper - s) --upper;
  return static_cast<Index>(upper - mesh.arc_length.begin());
}

}  // namespace

std::vector<double> fiber_tension(const FiberMesh& mesh, const std::vector<Vec3>& reference,
                                  const std::vector<Vec3>& current) {
  std::vector<double> tension(mesh.n_nodes(), 0.0);
  for_each_element(mesh, [&](Index f, const Element& element) {
    const double s_0 = mesh.arc_length[element.first], s_2 = mesh.arc_length[element.first + 2];
    const double middle = 0.5 * (s_0 + s_2), offset = 0.5 * (s_2 - s_0) / std::sqrt(3.0);
    const auto strain = [&](double s) {
      return 0.5 * (element.derivative(current, s).squaredNorm() - element.derivative(reference, s).squaredNorm());
    };
    const double mean = 0.5 * (strain(middle + offset) + strain(middle - offset));
    const double slope = 0.5 * (strain(middle + offset) - strain(middle - offset)) / offset;
    for (int i = 0; i < 3; ++i)
      tension[element.first + i] +=
          mesh.axial_stiffness[f] * (mean + slope * (mesh.arc_length[element.first + i] - middle));
  });
  const std::vector<double> count = elements_at_nodes(mesh);
  for (std::size_t n = 0; n < tension.size(); ++n) tension[n] /= count[n];
  return tension;
}

std::vector<double> fiber_curvature(const FiberMesh& mesh, const std::vector<Vec3>& current) {
  std::vector<Vec3> first(mesh.n_nodes(), Vec3::Zero()), second(mesh.n_nodes(), Vec3::Zero());
  for_each_element(mesh, [&](Index, const Element& element) {
    for (Index n = element.first; n < element.first + 3; ++n) {
      first[n] += element.derivative(current, mesh.arc_length[n]);
      second[n] += element.second_derivative(current);
    }
  });
  const std::vector<double> count = elements_at_nodes(mesh);
  std::vector<double> curvature(mesh.n_nodes());
  for (std::size_t n = 0; n < curvature.size(); ++n) {
    const Vec3 r_s = first[n] / count[n], r_ss = second[n] / count[n];
    curvature[n] = r_s.cross(r_ss).norm() / std::pow(r_s.norm(), 3);
  }
  return curvature;
}

std::vector<double> fiber_contact_force(const FiberMesh& mesh, const ContactRecord& contacts) {
  std::vector<double> force(mesh.n_nodes(), 0.0);
  for (std::size_t c = 0; c < contacts.normal_force.size(); ++c) {
    force[nearest_node(mesh, contacts.fiber_a[c], contacts.s_a[c])] += contacts.normal_force[c];
    force[nearest_node(mesh, contacts.fiber_b[c], contacts.s_b[c])] += contacts.normal_force[c];
  }
  const std::vector<double> length = tributary_length(mesh);
  for (std::size_t n = 0; n < force.size(); ++n) force[n] /= length[n];
  return force;
}

struct FibersVtkWriter::Impl {
  SnapshotHeader header;
  std::vector<Vec3> reference;
  Copies copies;
  Periods periods;  // of the reference
  VtkSeries series;
  const FiberMesh& mesh = header.mesh;

  void add_lines(vtkPolyData* data) const {
    vtkNew<vtkCellArray> lines;
    for (Index f = 0; f < mesh.n_fibers(); ++f) {
      lines->InsertNextCell(mesh.n_nodes(f));
      for (Index n = mesh.first_node[f]; n < mesh.first_node[f + 1]; ++n) lines->InsertCellPoint(n);
    }
    data->SetLines(lines);
  }
  void add_cell_data(vtkPolyData* data) const {
    std::vector<Index> fiber, family;
    for (Index f = 0; f < mesh.n_fibers(); ++f) {
      fiber.push_back(f);
      family.push_back(static_cast<Index>(mesh.yarns[mesh.yarn_of_fiber[f]].family));
    }
    add_array(data->GetCellData(), "fiber", fiber);
    add_array(data->GetCellData(), "yarn", mesh.yarn_of_fiber);
    add_array(data->GetCellData(), "family", family);
  }
  void add_point_data(vtkPolyData* data, const Increment& increment) const {
    std::vector<double> radius(mesh.n_nodes());
    for (Index f = 0; f < mesh.n_fibers(); ++f)
      std::fill(radius.begin() + mesh.first_node[f], radius.begin() + mesh.first_node[f + 1], mesh.radius[f]);
    std::vector<Vec3> displacement(increment.fibers.r);
    for (std::size_t n = 0; n < displacement.size(); ++n) displacement[n] -= reference[n];
    vtkPointData* points = data->GetPointData();
    add_array(points, "radius", radius);
    add_array(points, "displacement", displacement);
    add_array(points, "tension", fiber_tension(mesh, reference, increment.fibers.r));
    add_array(points, "curvature", fiber_curvature(mesh, increment.fibers.r));
    add_array(points, "contact_force", fiber_contact_force(mesh, increment.contacts));
  }
};

FibersVtkWriter::FibersVtkWriter(const SnapshotHeader& header, const Increment& reference,
                                 const std::filesystem::path& folder, const Copies& copies) {
  const Periods periods = periods_of(header, reference);
  check_copies(copies, is_periodic(periods));
  impl_.reset(new Impl{header, reference.fibers.r, copies, periods, VtkSeries(folder, "fibers", "vtp")});
}

FibersVtkWriter::~FibersVtkWriter() = default;

void FibersVtkWriter::append(Index index, const Increment& increment) {
  vtkNew<vtkPolyData> cell;
  cell->SetPoints(make_points(increment.fibers.r));
  impl_->add_lines(cell);
  impl_->add_cell_data(cell);
  impl_->add_point_data(cell, increment);
  const CopyPlaces places{impl_->copies, periods_of(impl_->header, increment), impl_->periods};
  const auto data = with_copies<vtkAppendPolyData>(cell.Get(), places);
  add_load(data, increment.stage, increment.stage_time);
  vtkNew<vtkXMLPolyDataWriter> writer;
  writer->SetInputData(data);
  impl_->series.add(index, writer);
}

std::filesystem::path write_fibers_vtk(const SnapshotReader& states, const std::filesystem::path& folder,
                                       const Copies& copies) {
  if (states.n_increments() == 0) throw InputError("the state file holds no increment");
  FibersVtkWriter writer(states.header(), states.read(0), folder, copies);
  for (Index i = 0; i < states.n_increments(); ++i) writer.append(i, states.read(i));
  return folder / "fibers.pvd";
}

}  // namespace trame::micro
