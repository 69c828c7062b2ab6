#include <fmt/format.h>
#include <vtkAbstractArray.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkIdList.h>
#include <vtkLogger.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkStringOutputWindow.h>
#include <vtkXMLPolyDataReader.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>

#include "micro/core/error.h"
#include "micro/core/text.h"
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
  std::vector<Vec3> positions;       ///< fiber by fiber
  std::vector<std::string> label;    ///< n_fibers, of the yarn
  std::vector<std::string> remarks;  ///< on how the file was understood
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
Index integer(const fs::path& file, const char* kind, vtkDataArray* array, vtkIdType at, Index smallest,
              Index largest) {
  const double value = at < array->GetNumberOfTuples() ? array->GetComponent(at, 0) : std::nan("");
  if (!(value >= smallest && value <= largest && value == std::floor(value)))
    fail(file, fmt::format("{0} array {1}: {2} in {0} {3}, allowed are integers from {4} to {5}", kind,
                           array->GetName(), value, at, smallest, largest));
  return static_cast<Index>(value);
}

/// A label of yarns, by whatever name the file has it: an integer or a text.
struct LabelArray {
  vtkAbstractArray* array = nullptr;
  bool at_points = false;

  [[nodiscard]] std::string at(const fs::path& file, vtkIdType i) const {
    const char* kind = at_points ? "point" : "cell";
    if (auto* numbers = vtkDataArray::SafeDownCast(array))
      return std::to_string(
          integer(file, kind, numbers, i, std::numeric_limits<Index>::min(), std::numeric_limits<Index>::max()));
    auto* texts = vtkStringArray::SafeDownCast(array);
    if (texts == nullptr || i >= texts->GetNumberOfValues())
      fail(file, fmt::format("{} array {} has no text or number for {} {}", kind, array->GetName(), kind, i));
    std::string label = texts->GetValue(i);
    check_yarn_name(fmt::format("{}: {} array {}", file.string(), kind, array->GetName()), label);
    return label;
  }
};

/// Names of arrays without those that have another meaning here; quoted.
std::string other_arrays(vtkFieldData* cells, vtkFieldData* points) {
  std::string names;
  for (vtkFieldData* data : {cells, points})
    for (int i = 0; i < data->GetNumberOfArrays(); ++i) {
      const char* name = data->GetAbstractArray(i) != nullptr ? data->GetAbstractArray(i)->GetName() : nullptr;
      if (name == nullptr || std::string_view(name) == "radius" || std::string_view(name) == "family") continue;
      names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", printable(name));
    }
  return names;
}

/// The array "yarn", else one that is called alike, of cells or of points.
LabelArray find_label(vtkPolyData* data) {
  for (const bool exact : {true, false})
    for (const bool at_points : {false, true}) {
      vtkFieldData* arrays = at_points ? static_cast<vtkFieldData*>(data->GetPointData()) : data->GetCellData();
      for (int i = 0; i < arrays->GetNumberOfArrays(); ++i) {
        vtkAbstractArray* array = arrays->GetAbstractArray(i);
        if (array == nullptr || array->GetName() == nullptr) continue;
        if (exact ? std::string_view(array->GetName()) == "yarn" : names_yarns(array->GetName()))
          return {array, at_points};
      }
    }
  return {};
}

/// A line of a file: its points, and the cells that it is made of.
struct Line {
  std::vector<vtkIdType> points, cells;
};

std::vector<Line> cells_as_lines(const fs::path& file, vtkPolyData* data) {
  std::vector<Line> lines;
  vtkNew<vtkIdList> ids;
  std::size_t n_points = 0;
  for (vtkIdType f = 0; f < data->GetNumberOfLines(); ++f) {
    data->GetLines()->GetCellAtId(f, ids);
    Line& line = lines.emplace_back();
    line.cells = {data->GetNumberOfVerts() + f};
    for (vtkIdType i = 0; i < ids->GetNumberOfIds(); ++i) {
      const vtkIdType id = ids->GetId(i);
      if (id < 0 || id >= data->GetNumberOfPoints())
        fail(file, fmt::format("line {} has point {}, but there are {}", f, id, data->GetNumberOfPoints()));
      line.points.push_back(id);
    }
    if ((n_points += line.points.size()) > 2 * max_file_nodes)
      fail(file, fmt::format("lines of more than {} points", max_file_nodes));
  }
  return lines;
}

/// Points that lie at the same place are one: each segment may have its own.
std::vector<vtkIdType> places(vtkPolyData* data) {
  std::map<std::array<double, 3>, vtkIdType> first_at;
  std::vector<vtkIdType> place;
  for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i) {
    std::array<double, 3> x{};
    data->GetPoint(i, x.data());
    const bool comparable = std::isfinite(x[0]) && std::isfinite(x[1]) && std::isfinite(x[2]);
    place.push_back(comparable ? first_at.emplace(x, i).first->second : i);
  }
  return place;
}

/// Segments, lines of two points each, that meet at their ends are the pieces of fibers: each chain of them is one
/// line. Lines of more points, and segments that meet no other, stay as they are.
std::vector<Line> joined(const fs::path& file, vtkPolyData* data, std::vector<Line> lines) {
  if (std::any_of(lines.begin(), lines.end(), [](const Line& line) { return line.points.size() != 2; })) return lines;
  const std::vector<vtkIdType> place = places(data);
  std::map<vtkIdType, std::vector<std::size_t>> segments_at;
  for (std::size_t k = 0; k < lines.size(); ++k)
    for (const vtkIdType point : lines[k].points) segments_at[place[point]].push_back(k);
  for (const auto& [point, segments] : segments_at)
    if (segments.size() > 2)
      fail(file, fmt::format("{} lines of two points meet at point {}: fibers do not branch", segments.size(), point));
  std::vector<char> used(lines.size(), 0);
  std::vector<Line> chains;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const vtkIdType begin = segments_at[place[lines[k].points[0]]].size() == 1   ? lines[k].points[0]
                            : segments_at[place[lines[k].points[1]]].size() == 1 ? lines[k].points[1]
                                                                                 : -1;
    if (begin < 0 || used[k] != 0) continue;
    Line& chain = chains.emplace_back();
    chain.points = {begin};
    for (std::size_t at = k;;) {
      used[at] = 1;
      chain.cells.push_back(lines[at].cells[0]);
      const bool forward = place[lines[at].points[0]] == place[chain.points.back()];
      chain.points.push_back(lines[at].points[forward ? 1 : 0]);
      const auto& next = segments_at[place[chain.points.back()]];
      if (next.size() == 1) break;
      at = next[0] == at ? next[1] : next[0];
      if (used[at] != 0) break;
    }
  }
  if (std::find(used.begin(), used.end(), 0) != used.end())
    fail(file, "lines of two points form a closed ring, which has no ends that a fiber could have");
  return chains;
}

/// Points of the lines one after the other, and where each line starts.
void gather_points(vtkPolyData* data, const std::vector<Line>& cells, Polylines& lines) {
  FiberList& list = lines.list;
  vtkDataArray* radius = data->GetPointData()->GetArray("radius");
  list.start = {0};
  for (const Line& line : cells) {
    for (const vtkIdType id : line.points) lines.positions.emplace_back(data->GetPoint(id));
    list.start.push_back(static_cast<Index>(lines.positions.size()));
    const bool known = radius && !line.points.empty() && line.points[0] < radius->GetNumberOfTuples();
    list.radius.push_back(known ? radius->GetComponent(line.points[0], 0) : std::numeric_limits<double>::quiet_NaN());
  }
}

/// Yarns by their labels; family from the first fiber.
void find_yarns(const fs::path& file, vtkPolyData* data, const std::vector<Line>& cells, Polylines& lines) {
  const LabelArray label = find_label(data);
  for (std::size_t f = 0; f < cells.size(); ++f) {
    std::string of_fiber = label.array == nullptr ? "0" : "";
    for (const vtkIdType i : label.at_points ? cells[f].points : cells[f].cells) {
      if (label.array == nullptr) break;
      const std::string here = label.at(file, i);
      if (!of_fiber.empty() && here != of_fiber)
        fail(file,
             fmt::format("array {}: fiber {} belongs to {} and to {}", label.array->GetName(), f, of_fiber, here));
      of_fiber = here;
    }
    lines.label.push_back(of_fiber);
  }
  make_yarns(lines.label, lines.list);
  if (const std::string others = other_arrays(data->GetCellData(), data->GetPointData());
      label.array == nullptr && !others.empty())
    lines.remarks.push_back(fmt::format("no array \"yarn\", so all fibers are one yarn; there are {}", others));
  else if (label.array != nullptr && std::string_view(label.array->GetName()) != "yarn")
    lines.remarks.push_back(fmt::format("yarns are taken from the array \"{}\"", printable(label.array->GetName())));
  vtkDataArray* family = data->GetCellData()->GetArray("family");
  if (family == nullptr) return;
  for (std::size_t y = 0; y < lines.list.yarns.size(); ++y) {
    const auto first = std::find(lines.list.yarn.begin(), lines.list.yarn.end(), static_cast<Index>(y));
    const vtkIdType cell = cells[first - lines.list.yarn.begin()].cells[0];
    lines.list.yarns[y].family = static_cast<micro::YarnFamily>(integer(file, "cell", family, cell, 0, 2));
  }
}

/// Field data "unit": a text.
void apply_unit(const fs::path& file, vtkPolyData* data, Polylines& lines) {
  auto* unit = vtkStringArray::SafeDownCast(data->GetFieldData()->GetAbstractArray("unit"));
  if (unit == nullptr || unit->GetNumberOfValues() == 0) {
    const std::string remark = remark_on_size(lines.positions, "field data \"unit\" in the file, such as \"um\",");
    if (!remark.empty()) lines.remarks.push_back(remark);
    return;
  }
  const double factor = metres(file.string() + ": field data unit", unit->GetValue(0));
  for (Vec3& x : lines.positions) x *= factor;
  for (double& r : lines.list.radius) r *= factor;
}

Polylines read_polylines(const fs::path& file) {
  const vtkSmartPointer<vtkPolyData> data = read_poly_data(file);
  Polylines lines;
  if (data->GetNumberOfLines() == 0) fail(file, "holds no polylines");
  const std::vector<Line> pieces = cells_as_lines(file, data), cells = joined(file, data, pieces);
  if (cells.size() < pieces.size())
    lines.remarks.push_back(
        fmt::format("{} lines of two points were joined to {} fibers", pieces.size(), cells.size()));
  gather_points(data, cells, lines);
  check_start(file.string() + ": polylines", lines.list.start);
  find_yarns(file, data, cells, lines);
  apply_unit(file, data, lines);
  check_positions(file.string() + ": Points", lines.positions);
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
  [[nodiscard]] std::vector<std::string> remarks() const override {
    std::vector<std::string> all = first_.remarks;
    if (const std::string turned = order_.remark(); !turned.empty()) all.push_back(turned);
    return all;
  }
  [[nodiscard]] micro::Increment read(Index i) const override {
    if (i < 0 || i >= n_increments())
      throw InputError(fmt::format("no state {}: there are {} files, counted from 0", i, files_.size()));
    const Polylines lines = read_polylines(files_[i]);
    if (lines.list.start != first_.list.start || lines.label != first_.label)
      fail(files_[i],
           fmt::format("its polylines differ from those of {} in number, points or yarns", files_[0].string()));
    micro::Increment increment;
    increment.stage = made_name(files_[i].stem().string());
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
