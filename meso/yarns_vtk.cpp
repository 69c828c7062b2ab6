#include "meso/yarns_vtk.h"

#include <vtkAppendFilter.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <utility>

#include "micro/states/vtk_copies.h"
#include "micro/states/vtk_series.h"

namespace trame::meso {

struct YarnsVtkWriter::Impl {
  const micro::SnapshotHeader& header;
  const std::vector<YarnMesh>& meshes;
  Index from;
  std::vector<Vec3> positions_a;
  micro::Copies copies;
  micro::Periods periods_a;
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
      families.insert(families.end(), mesh.tets.size(), static_cast<Index>(header.mesh.yarns[mesh.yarn].family));
    }
    micro::add_array(grid->GetCellData(), "yarn", yarns);
    micro::add_array(grid->GetCellData(), "family", families);
  }
};

namespace {

/// One array over all yarns, one entry after the other: `values(yarn)` are those of a yarn.
template <class T, class Values>
void add(vtkFieldData* data, const char* name, const std::vector<YarnFields>& yarns, Values&& values) {
  std::vector<T> all;
  for (const YarnFields& yarn : yarns) {
    const auto& own = values(yarn);
    all.insert(all.end(), own.begin(), own.end());
  }
  micro::add_array(data, name, all);
}

/// Components, principal values and the like of the members that `StrainField` and `NodalStrain` share; `part` picks
/// one of the two.
template <class Part>
void add_strains(vtkFieldData* data, const std::vector<YarnFields>& yarns, Part&& part) {
  const auto component = [&](const char* name, int i, int j) {
    add<double>(data, name, yarns, [&](const YarnFields& yarn) {
      std::vector<double> values;
      for (const Mat3& E : part(yarn).E) values.push_back(E(i, j));
      return values;
    });
  };
  component("E_axial", 0, 0);
  component("E_horizontal", 1, 1);
  component("E_vertical", 2, 2);
  component("E_axial_horizontal", 0, 1);
  component("E_axial_vertical", 0, 2);
  component("E_horizontal_vertical", 1, 2);
  const char* principal[] = {"E_I", "E_II", "E_III"};
  for (int i = 0; i < 3; ++i)
    add<double>(data, principal[i], yarns, [&](const YarnFields& yarn) {
      std::vector<double> values;
      for (const Vec3& E : part(yarn).principal) values.push_back(E[i]);
      return values;
    });
  add<double>(data, "gamma_max", yarns, [&](const YarnFields& yarn) { return part(yarn).gamma_max; });
  add<double>(data, "det_F", yarns, [&](const YarnFields& yarn) { return part(yarn).det_F; });
  add<Index>(data, "flagged", yarns, [&](const YarnFields& yarn) { return part(yarn).flagged; });
}

}  // namespace

YarnsVtkWriter::YarnsVtkWriter(const micro::SnapshotHeader& header, const std::vector<YarnMesh>& meshes, Index from,
                               const micro::Increment& state_a, const std::filesystem::path& folder,
                               const micro::Copies& copies) {
  const micro::Periods periods = micro::periods_of(header, state_a);
  micro::check_copies(copies, micro::is_periodic(periods));
  impl_.reset(
      new Impl{header, meshes, from, state_a.fibers.r, copies, periods, micro::VtkSeries(folder, "yarns", "vtu")});
}

YarnsVtkWriter::~YarnsVtkWriter() = default;

std::filesystem::path YarnsVtkWriter::pvd() const { return impl_->series.pvd(); }

void YarnsVtkWriter::append(Index index, const micro::Increment& state_b, const std::vector<YarnFields>& yarns) {
  vtkNew<vtkUnstructuredGrid> grid;
  impl_->add_geometry(grid, state_b.fibers.r);
  impl_->add_yarns(grid);
  add_strains(
      grid->GetCellData(), yarns, [](const YarnFields& yarn) -> const auto& { return yarn.strain; });
  add_strains(
      grid->GetPointData(), yarns, [](const YarnFields& yarn) -> const auto& { return yarn.nodal; });
  add<Index>(grid->GetCellData(), "shear_zone", yarns, [](const YarnFields& yarn) { return yarn.zones.zone; });
  add<double>(grid->GetCellData(), "shear_contrast", yarns, [](const YarnFields& yarn) { return yarn.zones.contrast; });
  add<double>(grid->GetPointData(), "D2_min", yarns, [](const YarnFields& yarn) { return yarn.D2_min; });
  const micro::CopyPlaces places{impl_->copies, micro::periods_of(impl_->header, state_b), impl_->periods_a};
  const auto data = micro::with_copies<vtkAppendFilter>(grid.Get(), places);
  micro::add_load(data, state_b.stage, state_b.stage_time);
  micro::add_array(data->GetFieldData(), "from", std::vector<Index>{impl_->from});
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  writer->SetInputData(data);
  impl_->series.add(index, writer);
}

}  // namespace trame::meso
