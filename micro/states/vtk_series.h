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
#include <string_view>
#include <utility>
#include <vector>

#include "micro/core/error.h"
#include "micro/core/types.h"
#include "micro/core/whole_file.h"

namespace trame::micro {

/// A time series in a folder: `<name>_0000.<ending>`, …, and `<name>.pvd`, complete after each `add`.
class VtkSeries {
 public:
  /// Throws WriteError where there is no room for the folder, InputError where it cannot be made otherwise.
  VtkSeries(std::filesystem::path folder, std::string name, std::string ending)
      : folder_(std::move(folder)), name_(std::move(name)), ending_(std::move(ending)) {
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
    if (!error) return;
    const std::string message = fmt::format("{}: cannot be created: {}", folder_.string(), error.message());
    if (is_lack_of_space(error.value())) throw WriteError(message);
    throw InputError(message);
  }

  [[nodiscard]] std::filesystem::path pvd() const { return folder_ / (name_ + ".pvd"); }

  /// Writes one data set, binary and compressed, as the state at time `time`. Throws WriteError; the file is then not
  /// there, and the series is what it was.
  void add(Index time, vtkXMLWriter* writer) {
    const std::string file = fmt::format("{}_{:04}.{}", name_, time, ending_);
    writer->SetFileName(part_of(folder_ / file).c_str());
    writer->SetDataModeToAppended();
    writer->EncodeAppendedDataOff();
    writer->SetCompressorTypeToZLib();
    const Silence silence;
    if (writer->Write() == 0 || writer->GetErrorCode() != 0 || !is_whole(part_of(folder_ / file)))
      fail_to_write(folder_ / file, 0);
    put_in_place(folder_ / file);
    entries_.emplace_back(time, file);
    write_pvd();
  }

 private:
  /// Keeps VTK from printing what is told by exceptions.
  class Silence {
   public:
    Silence() : before_(vtkObject::GetGlobalWarningDisplay()) { vtkObject::GlobalWarningDisplayOff(); }
    ~Silence() { vtkObject::SetGlobalWarningDisplay(before_); }
    Silence(const Silence&) = delete;
    Silence& operator=(const Silence&) = delete;

   private:
    int before_;
  };

  /// The writer does not always notice that the disk is full.
  static bool is_whole(const std::filesystem::path& file) {
    constexpr std::string_view end = "</VTKFile>\n";
    std::ifstream stream(file, std::ios::binary);
    stream.seekg(-static_cast<std::streamoff>(end.size()), std::ios::end);
    std::string last(end.size(), '\0');
    stream.read(last.data(), static_cast<std::streamsize>(last.size()));
    return stream && last == end;
  }
  void write_pvd() const {
    std::string text =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
        "  <Collection>\n";
    for (const auto& [time, file] : entries_)
      text += fmt::format("    <DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", time, file);
    write_whole_file(pvd(), text + "  </Collection>\n</VTKFile>\n");
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
