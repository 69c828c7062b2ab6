#include "meso/yarns_vtk.h"

#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <utility>

#include "micro/io/vtk_series.h"

namespace trame::meso {

struct YarnsVtkWriter::Impl {
  const micro::FiberMesh& fibers;
  const std::vector<YarnMesh>& meshes;
  Index from;
  std::vector<Vec3> positions_a;
  micro::VtkSeries series;

  void add_geometry(vtkUnstructuredGrid* grid, const std::vector<Vec3>& r) const {
    std::vector<Vec3> positions, displacement;
    grid->AllocateEstimate(1, 4);
    for (const YarnMesh& mesh : meshes) {
      const auto first = static_cast<vtkIdType>(positions.size());
      for (const auto& tet : mesh.tets) {
        const vtkIdType ids[4] = {first + tet[0], first + tet[1], first + tet[2], first + tet[3]};
        grid->InsertNextCell(VTK_TETRA, 4, ids);
      }
      for (const Index n : mesh.nodes) {
        positions.push_back(r[n]);
        displacement.push_back(r[n] - positions_a[n]);
      }
    }
    grid->SetPoints(micro::make_points(positions));
    micro::add_array(grid->GetPointData(), "displacement", displacement);
  }

  void add_yarns(vtkUnstructuredGrid* grid) const {
    std::vector<Index> yarns, families;
    for (const YarnMesh& mesh : meshes) {
      yarns.insert(yarns.end(), mesh.tets.size(), mesh.yarn);
      families.insert(families.end(), mesh.tets.size(), static_cast<Index>(fibers.yarns[mesh.yarn].family));
    }
    micro::add_array(grid->GetCellData(), "yarn", yarns);
    micro::add_array(grid->GetCellData(), "family", families);
  }
};

namespace {

/// One array over the cells of all yarns: `value(field, cell)`.
template <class T, class Value>
void add_cells(vtkUnstructuredGrid* grid, const char* name, const std::vector<StrainField>& strains, Value&& value) {
  std::vector<T> values;
  for (const StrainField& field : strains)
    for (std::size_t c = 0; c < field.E.size(); ++c) values.push_back(value(field, c));
  micro::add_array(grid->GetCellData(), name, values);
}

void add_strains(vtkUnstructuredGrid* grid, const std::vector<StrainField>& strains) {
  const auto component = [&](const char* name, int i, int j) {
    add_cells<double>(grid, name, strains, [=](const StrainField& field, std::size_t c) { return field.E[c](i, j); });
  };
  component("E_axial", 0, 0);
  component("E_horizontal", 1, 1);
  component("E_vertical", 2, 2);
  component("E_axial_horizontal", 0, 1);
  component("E_axial_vertical", 0, 2);
  component("E_horizontal_vertical", 1, 2);
  const char* principal[] = {"E_I", "E_II", "E_III"};
  for (int i = 0; i < 3; ++i)
    add_cells<double>(grid, principal[i], strains,
                      [=](const StrainField& field, std::size_t c) { return field.principal[c][i]; });
  add_cells<double>(grid, "gamma_max", strains,
                    [](const StrainField& field, std::size_t c) { return field.gamma_max[c]; });
  add_cells<double>(grid, "det_F", strains, [](const StrainField& field, std::size_t c) { return field.det_F[c]; });
  add_cells<Index>(grid, "flagged", strains, [](const StrainField& field, std::size_t c) { return field.flagged[c]; });
}

}  // namespace

YarnsVtkWriter::YarnsVtkWriter(const micro::FiberMesh& fibers, const std::vector<YarnMesh>& meshes, Index from,
                               std::vector<Vec3> positions_a, const std::filesystem::path& folder)
    : impl_(new Impl{fibers, meshes, from, std::move(positions_a), micro::VtkSeries(folder, "yarns", "vtu")}) {}

YarnsVtkWriter::~YarnsVtkWriter() = default;

std::filesystem::path YarnsVtkWriter::pvd() const { return impl_->series.pvd(); }

void YarnsVtkWriter::append(Index index, const micro::Increment& state_b, const std::vector<StrainField>& strains) {
  vtkNew<vtkUnstructuredGrid> grid;
  impl_->add_geometry(grid, state_b.fibers.r);
  impl_->add_yarns(grid);
  add_strains(grid, strains);
  micro::add_load(grid, state_b.stage, state_b.stage_time);
  micro::add_array(grid->GetFieldData(), "from", std::vector<Index>{impl_->from});
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  writer->SetInputData(grid);
  impl_->series.add(index, writer);
}

}  // namespace trame::meso
