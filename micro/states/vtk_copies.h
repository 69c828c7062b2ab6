#pragma once
/// \file
/// Copies of a periodic cell in VTK output: points displaced by the periods of their state, the point array
/// `displacement` by how much the copy's place has changed, all other arrays as they are, and on cells the array
/// `copy`, (i, j) of cell_copies.h.

#include <vtkCellData.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkSmartPointer.h>

#include <algorithm>

#include "micro/states/cell_copies.h"
#include "micro/states/vtk_series.h"

namespace trame::micro {

/// What copies of a state are displaced by, and were in the reference state of `displacement`.
struct CopyPlaces {
  Copies copies = one_cell;
  Periods now, reference;
};

/// `copy` on cells, which are those of one copy after the other.
inline void add_copy_numbers(vtkDataSet* data, const Copies& copies) {
  const std::vector<CopyNumber> numbers = copy_numbers(copies);
  vtkNew<vtkIntArray> array;
  array->SetName("copy");
  array->SetNumberOfComponents(2);
  array->SetComponentName(0, "warp");
  array->SetComponentName(1, "weft");
  array->SetNumberOfTuples(data->GetNumberOfCells());
  const vtkIdType n_cells = data->GetNumberOfCells() / static_cast<vtkIdType>(numbers.size());
  for (vtkIdType c = 0; c < data->GetNumberOfCells(); ++c)
    array->SetTypedTuple(c, numbers[static_cast<std::size_t>(c / n_cells)].data());
  data->GetCellData()->AddArray(array);
}

/// The same cell elsewhere; arrays but `displacement` are shared.
template <class DataSet>
vtkSmartPointer<DataSet> displaced(DataSet* cell, const Vec3& by, const Vec3& by_since_reference) {
  auto copy = vtkSmartPointer<DataSet>::New();
  copy->ShallowCopy(cell);
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(cell->GetNumberOfPoints());
  vtkDataArray* before = cell->GetPointData()->GetArray("displacement");
  std::vector<Vec3> displacement;
  for (vtkIdType n = 0; n < cell->GetNumberOfPoints(); ++n) {
    points->SetPoint(n, Vec3(Vec3(cell->GetPoint(n)) + by).data());
    displacement.emplace_back(Vec3(before->GetTuple3(n)) + by_since_reference);
  }
  copy->SetPoints(points);
  add_array(copy->GetPointData(), "displacement", displacement);
  return copy;
}

/// All copies in one data set: `Append` is VTK's filter that joins such sets. What is not periodic stays as it is.
template <class Append, class DataSet>
vtkSmartPointer<DataSet> with_copies(DataSet* cell, const CopyPlaces& places) {
  const auto [along_warp, along_weft] = is_periodic(places.now);
  vtkSmartPointer<DataSet> all = cell;
  if (!along_warp && !along_weft) return all;
  if (places.copies != one_cell) {
    vtkNew<Append> append;
    append->SetOutputPointsPrecision(vtkAlgorithm::DOUBLE_PRECISION);
    for (const CopyNumber& number : copy_numbers(places.copies)) {
      const Vec3 by = displacement_of(number, places.now);
      append->AddInputData(displaced(cell, by, by - displacement_of(number, places.reference)));
    }
    append->Update();
    all = DataSet::SafeDownCast(append->GetOutput());
  }
  if (all->GetNumberOfCells() > 0) add_copy_numbers(all, places.copies);
  return all;
}

}  // namespace trame::micro
