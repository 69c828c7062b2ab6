#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkIdList.h>
#include <vtkLogger.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStringOutputWindow.h>
#include <vtkXMLPolyDataReader.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "micro/core/error.h"
#include "workflows/strains/fiber_nodes.h"

namespace trame::workflows {
namespace {

namespace fs = std::filesystem;

/// While alive, keeps what VTK would print, which it does in two ways: through a window and a log.
class CollectedOutput {
 public:
  CollectedOutput() : before_(vtkOutputWindow::GetInstance()) {
    vtkOutputWindow::SetInstance(collector_);
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
  }
  ~CollectedOutput() {
    vtkOutputWindow::SetInstance(before_);
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_WARNING);
  }
  CollectedOutput(const CollectedOutput&) = delete;
  CollectedOutput& operator=(const CollectedOutput&) = delete;
  [[nodiscard]] bool has_error() const { return collector_->GetOutput().find("ERROR") != std::string::npos; }

 private:
  vtkSmartPointer<vtkOutputWindow> before_;
  vtkNew<vtkStringOutputWindow> collector_;
};

/// The polylines of one file, in its order.
struct Polylines {
  FiberList list;
  std::vector<Vec3> positions;  ///< fiber by fiber
  std::vector<Index> label;     ///< n_fibers, the array "yarn"
};

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  throw InputError(fmt::format("{}: {}", file.string(), what));
}

void check_claims(const fs::path& file, vtkXMLPolyDataReader* reader) {
  reader->SetupUpdateExtent(0, 1, 0);
  const auto most = static_cast<vtkIdType>(max_file_nodes);
  const auto check = [&](const char* what, vtkIdType n) {
    if (n < 0 || n > most) fail(file, fmt::format("claims to hold {} {}, allowed are {}", n, what, max_file_nodes));
  };
  check("points", reader->GetNumberOfPoints());
  check("cells", reader->GetNumberOfCells());
}

void update(const fs::path& file, vtkXMLPolyDataReader* reader) {
  try {
    reader->Update();
  } catch (const std::exception&) {  // offsets may claim any size
    fail(file, "damaged VTK file: it claims to hold more than there is memory for");
  }
}

vtkSmartPointer<vtkPolyData> read_poly_data(const fs::path& file) {
  if (!fs::exists(file)) fail(file, "no such file");
  if (!fs::is_regular_file(file)) fail(file, "not a file");
  const CollectedOutput output;
  vtkNew<vtkXMLPolyDataReader> reader;
  if (reader->CanReadFile(file.c_str()) == 0) fail(file, "not a VTK XML PolyData file");
  reader->SetFileName(file.c_str());
  reader->UpdateInformation();
  if (!output.has_error()) {
    check_claims(file, reader);
    update(file, reader);
  }
  vtkSmartPointer<vtkPolyData> data = reader->GetOutput();
  if (output.has_error() || reader->GetErrorCode() != 0 || !data->GetLines()->IsValid())
    fail(file, "truncated or damaged VTK file");
  return data;
}

/// Value of an array as an integer from `smallest` to `largest`.
Index integer(const fs::path& file, vtkDataArray* array, vtkIdType at, Index smallest, Index largest) {
  const double value = at < array->GetNumberOfTuples() ? array->GetComponent(at, 0) : std::nan("");
  if (!(value >= smallest && value <= largest && value == std::floor(value)))
    fail(file, fmt::format("cell array {}: {} in cell {}, allowed are integers from {} to {}", array->GetName(), value,
                           at, smallest, largest));
  return static_cast<Index>(value);
}

/// Points of the lines one after the other, and where each line starts.
void gather_points(const fs::path& file, vtkPolyData* data, Polylines& lines) {
  FiberList& list = lines.list;
  vtkDataArray* radius = data->GetPointData()->GetArray("radius");
  vtkNew<vtkIdList> ids;
  list.start = {0};
  for (vtkIdType f = 0; f < data->GetNumberOfLines(); ++f) {
    data->GetLines()->GetCellAtId(f, ids);
    for (vtkIdType i = 0; i < ids->GetNumberOfIds(); ++i) {
      const vtkIdType id = ids->GetId(i);
      if (id < 0 || id >= data->GetNumberOfPoints())
        fail(file, fmt::format("line {} has point {}, but there are {}", f, id, data->GetNumberOfPoints()));
      lines.positions.emplace_back(data->GetPoint(id));
    }
    if (lines.positions.size() > max_file_nodes)
      fail(file, fmt::format("lines of more than {} points", max_file_nodes));
    list.start.push_back(static_cast<Index>(lines.positions.size()));
    const bool known = radius && ids->GetNumberOfIds() > 0 && ids->GetId(0) < radius->GetNumberOfTuples();
    list.radius.push_back(known ? radius->GetComponent(ids->GetId(0), 0) : std::numeric_limits<double>::quiet_NaN());
  }
}

/// Yarns by the labels of the array "yarn", in the order of the labels; family from its first fiber.
void find_yarns(const fs::path& file, vtkPolyData* data, Polylines& lines) {
  vtkDataArray* label = data->GetCellData()->GetArray("yarn");
  vtkDataArray* family = data->GetCellData()->GetArray("family");
  std::map<Index, Index> yarn_of_label;
  for (vtkIdType f = 0; f < data->GetNumberOfLines(); ++f) {
    const vtkIdType cell = data->GetNumberOfVerts() + f;
    lines.label.push_back(
        label ? integer(file, label, cell, std::numeric_limits<Index>::min(), std::numeric_limits<Index>::max()) : 0);
    yarn_of_label[lines.label.back()] = 0;
  }
  for (auto& [name, index] : yarn_of_label) {
    index = static_cast<Index>(lines.list.yarns.size());
    const auto first = std::find(lines.label.begin(), lines.label.end(), name) - lines.label.begin();
    const Index of = family ? integer(file, family, data->GetNumberOfVerts() + first, 0, 2) : 2;
    lines.list.yarns.push_back({fmt::format("yarn/{}", name), static_cast<micro::YarnFamily>(of), 0, 0});
  }
  for (const Index name : lines.label) lines.list.yarn.push_back(yarn_of_label[name]);
}

Polylines read_polylines(const fs::path& file) {
  const vtkSmartPointer<vtkPolyData> data = read_poly_data(file);
  Polylines lines;
  if (data->GetNumberOfLines() == 0) fail(file, "holds no polylines");
  gather_points(file, data, lines);
  check_start(file.string() + ": polylines", lines.list.start);
  check_finite(file.string() + ": Points", lines.positions);
  find_yarns(file, data, lines);
  return lines;
}

class VtpNodes : public meso::FiberStates {
 public:
  explicit VtpNodes(const std::vector<fs::path>& files)
      : files_(files), first_(read_polylines(files[0])), order_(files[0].string(), first_.list, first_.positions) {
    first_.positions = {};
    header_.mesh = order_.mesh();
  }

  [[nodiscard]] std::string name() const override { return files_[0].string(); }
  [[nodiscard]] const micro::SnapshotHeader& header() const override { return header_; }
  [[nodiscard]] Index n_increments() const override { return static_cast<Index>(files_.size()); }
  [[nodiscard]] micro::Increment read(Index i) const override {
    if (i < 0 || i >= n_increments())
      throw InputError(fmt::format("no state {}: there are {} files, counted from 0", i, files_.size()));
    const Polylines lines = read_polylines(files_[i]);
    if (lines.list.start != first_.list.start || lines.label != first_.label)
      fail(files_[i],
           fmt::format("its polylines differ from those of {} in number, points or yarns", files_[0].string()));
    micro::Increment increment;
    increment.stage = files_[i].stem().string();
    increment.fibers = order_.configuration(lines.positions);
    return increment;
  }

 private:
  std::vector<fs::path> files_;
  Polylines first_;  ///< without positions
  NodeOrder order_;
  micro::SnapshotHeader header_;
};

}  // namespace

std::unique_ptr<meso::FiberStates> open_vtp_nodes(const std::vector<fs::path>& files) {
  return std::make_unique<VtpNodes>(files);
}

}  // namespace trame::workflows
