#pragma once
/// \file
/// Files with fiber nodes as other programs write them: HDF5 dataset by dataset, VTK polylines.

#include <hdf5.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkXMLPolyDataWriter.h>

#include <filesystem>
#include <string>
#include <vector>

#include "micro/core/types.h"

namespace trame::test {

/// An HDF5 file open for writing, created where it does not exist. Groups of a path are made as needed; what is there
/// already is replaced.
class Hdf5File {
 public:
  explicit Hdf5File(const std::filesystem::path& path)
      : file_(std::filesystem::exists(path) ? H5Fopen(path.c_str(), H5F_ACC_RDWR, access_)
                                            : H5Fcreate(path.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, access_)) {}
  ~Hdf5File() {
    H5Fclose(file_);
    H5Pclose(access_);
  }
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  [[nodiscard]] hid_t id() const { return file_; }
  void put(const std::string& path, const std::vector<int>& values) {
    put(path, H5T_STD_I32LE, {values.size()}, H5T_NATIVE_INT, values.data());
  }
  void put(const std::string& path, const std::vector<double>& values) {
    put(path, H5T_IEEE_F64LE, {values.size()}, H5T_NATIVE_DOUBLE, values.data());
  }
  void put(const std::string& path, const std::vector<Vec3>& values, hid_t type = H5T_IEEE_F64LE) {
    put(path, type, {values.size(), 3}, H5T_NATIVE_DOUBLE, values.empty() ? nullptr : values[0].data());
  }
  /// Texts of variable length.
  void put(const std::string& path, const std::vector<const char*>& values) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    put(path, type, {values.size()}, type, values.data());
    H5Tclose(type);
  }
  /// A single text of fixed length.
  void put_fixed(const std::string& path, const std::string& value) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, value.size());
    put(path, type, {}, type, value.data());
    H5Tclose(type);
  }
  /// A dataset of any size; without data nothing is stored for it.
  void put(const std::string& path, hid_t type, const std::vector<hsize_t>& size, hid_t memory_type, const void* data) {
    remove(path);
    const hid_t links = H5Pcreate(H5P_LINK_CREATE);
    H5Pset_create_intermediate_group(links, 1);
    const hid_t space =
        size.empty() ? H5Screate(H5S_SCALAR) : H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr);
    const hid_t set = H5Dcreate2(file_, path.c_str(), type, space, links, H5P_DEFAULT, H5P_DEFAULT);
    if (data) H5Dwrite(set, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data);
    H5Dclose(set);
    H5Sclose(space);
    H5Pclose(links);
  }
  void put_attribute(const char* name, int value) {
    const hid_t space = H5Screate(H5S_SCALAR);
    const hid_t attribute = H5Acreate2(file_, name, H5T_STD_I32LE, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, H5T_NATIVE_INT, &value);
    H5Aclose(attribute);
    H5Sclose(space);
  }
  void remove(const std::string& path) {
    H5E_auto2_t print = nullptr;
    void* data = nullptr;
    H5Eget_auto2(H5E_DEFAULT, &print, &data);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // it need not be there
    H5Ldelete(file_, path.c_str(), H5P_DEFAULT);
    H5Eset_auto2(H5E_DEFAULT, print, data);
  }

 private:
  /// Without locks, as our readers have it: within a process the library wants the same for all.
  static hid_t without_locks() {
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_file_locking(access, false, true);
    return access;
  }
  hid_t access_ = without_locks();
  hid_t file_;
};

/// Polylines through `points`: line f through start[f] … start[f+1] − 1, with cell array "yarn" where labels are given.
inline vtkSmartPointer<vtkPolyData> polylines(const std::vector<Vec3>& points, const std::vector<Index>& start,
                                              const std::vector<int>& labels = {}) {
  auto data = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> positions;
  positions->SetDataTypeToDouble();
  for (const Vec3& x : points) positions->InsertNextPoint(x.data());
  data->SetPoints(positions);
  vtkNew<vtkCellArray> lines;
  for (std::size_t f = 0; f + 1 < start.size(); ++f) {
    lines->InsertNextCell(start[f + 1] - start[f]);
    for (Index n = start[f]; n < start[f + 1]; ++n) lines->InsertCellPoint(n);
  }
  data->SetLines(lines);
  if (labels.empty()) return data;
  vtkNew<vtkIntArray> yarn;
  yarn->SetName("yarn");
  for (const int label : labels) yarn->InsertNextValue(label);
  data->GetCellData()->AddArray(yarn);
  return data;
}

inline void write_vtp(const std::filesystem::path& file, vtkPolyData* data) {
  vtkNew<vtkXMLPolyDataWriter> writer;
  writer->SetFileName(file.c_str());
  writer->SetInputData(data);
  writer->Write();
}

}  // namespace trame::test
