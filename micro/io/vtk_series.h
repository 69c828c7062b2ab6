#pragma once
/// \file
/// What all VTK output shares: file names of a time series, the .pvd file that ParaView opens, point and cell arrays.

#include <fmt/format.h>
#include <vtkDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkXMLWriter.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "micro/core/error.h"
#include "micro/core/types.h"

namespace trame::micro {

/// A time series in a folder: `<name>_0000.<ending>`, …, and `<name>.pvd`, complete after each `add`.
class VtkSeries {
 public:
  /// Throws InputError where the folder cannot be made.
  VtkSeries(std::filesystem::path folder, std::string name, std::string ending)
      : folder_(std::move(folder)), name_(std::move(name)), ending_(std::move(ending)) {
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
    if (error) throw InputError(fmt::format("{}: cannot be created: {}", folder_.string(), error.message()));
  }

  [[nodiscard]] std::filesystem::path pvd() const { return folder_ / (name_ + ".pvd"); }

  /// Writes one data set, binary and compressed, as the state at time `time`. Throws InputError.
  void add(Index time, vtkXMLWriter* writer) {
    const std::string file = fmt::format("{}_{:04}.{}", name_, time, ending_);
    writer->SetFileName((folder_ / file).c_str());
    writer->SetDataModeToAppended();
    writer->EncodeAppendedDataOff();
    writer->SetCompressorTypeToZLib();
    if (writer->Write() == 0) throw InputError(fmt::format("{}: cannot be written", (folder_ / file).string()));
    entries_.emplace_back(time, file);
    write_pvd();
  }

 private:
  void write_pvd() const {
    std::ofstream out(pvd());
    out << "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
        << "  <Collection>\n";
    for (const auto& [time, file] : entries_)
      out << fmt::format("    <DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", time, file);
    out << "  </Collection>\n</VTKFile>\n";
    if (!out.flush()) throw InputError(fmt::format("{}: cannot be written", pvd().string()));
  }

  std::filesystem::path folder_;
  std::string name_, ending_;
  std::vector<std::pair<Index, std::string>> entries_;
};

inline void add_array(vtkFieldData* data, const char* name, const std::vector<double>& values) {
  vtkNew<vtkFloatArray> array;
  array->SetName(name);
  array->SetNumberOfValues(static_cast<vtkIdType>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i)
    array->SetValue(static_cast<vtkIdType>(i), static_cast<float>(values[i]));
  data->AddArray(array);
}

inline void add_array(vtkFieldData* data, const char* name, const std::vector<Vec3>& values) {
  vtkNew<vtkFloatArray> array;
  array->SetName(name);
  array->SetNumberOfComponents(3);
  array->SetNumberOfTuples(static_cast<vtkIdType>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) array->SetTuple(static_cast<vtkIdType>(i), values[i].data());
  data->AddArray(array);
}

inline void add_array(vtkFieldData* data, const char* name, const std::vector<Index>& values) {
  vtkNew<vtkIntArray> array;
  array->SetName(name);
  array->SetNumberOfValues(static_cast<vtkIdType>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) array->SetValue(static_cast<vtkIdType>(i), values[i]);
  data->AddArray(array);
}

/// Field data `load` (name of the stage) and `stage_time`.
inline void add_load(vtkDataSet* data, const std::string& stage, double stage_time) {
  vtkNew<vtkStringArray> load;
  load->SetName("load");
  load->InsertNextValue(stage);
  data->GetFieldData()->AddArray(load);
  vtkNew<vtkDoubleArray> time;
  time->SetName("stage_time");
  time->InsertNextValue(stage_time);
  data->GetFieldData()->AddArray(time);
}

inline vtkSmartPointer<vtkPoints> make_points(const std::vector<Vec3>& positions) {
  auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(static_cast<vtkIdType>(positions.size()));
  for (std::size_t i = 0; i < positions.size(); ++i) points->SetPoint(static_cast<vtkIdType>(i), positions[i].data());
  return points;
}

}  // namespace trame::micro
