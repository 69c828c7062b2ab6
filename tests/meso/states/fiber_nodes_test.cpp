/// Fiber nodes from elsewhere: HDF5 and VTK files, good ones and hostile ones.

#include "workflows/strains/fiber_nodes.h"

#include <gtest/gtest.h>
#include <unistd.h>
#include <vtkStringArray.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>

#include "tests/support/fiber_files.h"
#include "tests/support/lattice_yarns.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/text_file.h"
#include "workflows/program/file_probe.h"

namespace trame::workflows {
namespace {

using micro::test::input_error;
using micro::test::LatticeYarns;
using micro::test::mapped;
using test::Hdf5File;
using test::polylines;
using test::write_text;
using test::write_vtp;
using trame::test::TemporaryFolder;
namespace fs = std::filesystem;

/// Three fibers of 3, 2 and 4 nodes along x, unevenly spaced; the second belongs to another yarn.
const std::vector<Index> start = {0, 3, 5, 9};
const std::vector<Vec3> straight = {{0, 0, 0}, {1, 0, 0}, {3, 0, 0}, {0, 5, 0}, {2, 5, 0},
                                    {0, 1, 0}, {2, 1, 0}, {3, 1, 0}, {7, 1, 0}};

/// y grows by 0.1 x²: on a fiber along x, dr/ds = (1, 0.2 x, 0).
std::vector<Vec3> bent() {
  std::vector<Vec3> r = straight;
  for (Vec3& x : r) x.y() += 0.1 * x.x() * x.x();
  return r;
}

void expect_bent_tangents(const micro::FiberConfiguration& fibers, const std::vector<double>& at) {
  for (std::size_t n = 0; n < at.size(); ++n) {
    EXPECT_NEAR((fibers.tangent[n] - Vec3(1, 0.2 * at[n], 0)).norm(), 0, 1e-14) << "node " << n;
    EXPECT_NEAR(fibers.g1[n].dot(fibers.tangent[n]), 0, 1e-14);
    EXPECT_NEAR(fibers.g1[n].cross(fibers.g2[n]).dot(fibers.tangent[n].normalized()), 1, 1e-14);
  }
}

// ---- HDF5 ---------------------------------------------------------------------------------------------------------

class Hdf5Nodes : public ::testing::Test {
 protected:
  Hdf5Nodes() {
    Hdf5File file(path_);
    file.put("fibers/start", std::vector<int>(start.begin(), start.end()));
    file.put("fibers/yarn", std::vector<int>{1, 0, 1});
    file.put("increments/0/position", straight);
    file.put("increments/1/position", bent());
  }
  /// What opening and reading everything complains about.
  [[nodiscard]] std::string complaint() const {
    return input_error([&] {
      const auto states = open_states({path_});
      for (Index i = 0; i < states->n_increments(); ++i) (void)states->read(i);
    });
  }
  void expect_complaint(const std::string& part) const {
    const std::string message = complaint();
    EXPECT_NE(message.find(part), std::string::npos) << "message: " << message << "\nexpected: " << part;
    EXPECT_NE(message.find(path_.string()), std::string::npos) << "message names the file: " << message;
  }

  TemporaryFolder folder_;
  fs::path path_ = folder_ / "nodes.h5";
};

TEST_F(Hdf5Nodes, FibersOfAYarnBecomeConsecutive) {
  const auto states = open_states({path_});
  EXPECT_EQ(states->n_increments(), 2);
  const micro::FiberMesh& mesh = states->header().mesh;
  EXPECT_EQ(mesh.first_node, (std::vector<Index>{0, 2, 5, 9}));
  EXPECT_EQ(mesh.yarn_of_fiber, (std::vector<Index>{0, 1, 1}));
  EXPECT_EQ(mesh.arc_length, (std::vector<double>{0, 2, 0, 1, 3, 0, 2, 3, 7}));
  ASSERT_EQ(mesh.yarns.size(), 2u);
  EXPECT_EQ(mesh.yarns[1].name, "yarn/1");
  EXPECT_EQ(mesh.yarns[1].family, micro::YarnFamily::free);
  EXPECT_EQ(mesh.yarns[1].first_fiber, 1);
  EXPECT_EQ(mesh.yarns[1].n_fibers, 2);
  EXPECT_TRUE(std::isnan(mesh.radius[0]));
  const std::vector<Vec3> expected = {straight[3], straight[4], straight[0], straight[1], straight[2],
                                      straight[5], straight[6], straight[7], straight[8]};
  EXPECT_EQ(states->read(0).fibers.r, expected);
}

TEST_F(Hdf5Nodes, TangentsAreThoseOfParabolas) {
  const micro::FiberConfiguration fibers = open_states({path_})->read(1).fibers;
  // Two nodes have a chord only; its slope is that at its middle, x = 1.
  EXPECT_NEAR((fibers.tangent[0] - Vec3(1, 0.2, 0)).norm(), 0, 1e-14);
  EXPECT_NEAR((fibers.tangent[1] - Vec3(1, 0.2, 0)).norm(), 0, 1e-14);
  expect_bent_tangents(fibers, {1, 1, 0, 1, 3, 0, 2, 3, 7});
}

TEST_F(Hdf5Nodes, WhatIsOptionalIsRead) {
  Hdf5File file(path_);
  std::vector<Vec3> tangents(9);
  for (int n = 0; n < 9; ++n) tangents[n] = Vec3(n + 1, 2, 0);
  file.put("increments/1/tangent", tangents, H5T_IEEE_F32LE);
  file.put_fixed("increments/1/stage", "load");
  file.put("increments/1/stage_time", std::vector<double>{0.5});
  file.put("increments/0/stage", std::vector<const char*>{"start µ"});
  file.put("fibers/radius", std::vector<double>{1, 2, 3});
  file.put("yarns/name", std::vector<const char*>{"weft/1", "warp/1"});
  file.put("yarns/family", std::vector<int>{1, 0});
  file.put_attribute("layout_version", 1);
  const auto states = open_states({path_});
  EXPECT_EQ(states->read(0).stage, "start µ");
  const micro::Increment increment = states->read(1);
  EXPECT_EQ(increment.stage, "load");
  EXPECT_EQ(increment.stage_time, 0.5);
  EXPECT_EQ(increment.fibers.tangent[0], tangents[3]);  // file order: the first fiber of yarn 0 begins at node 3
  EXPECT_EQ(increment.fibers.tangent[8], tangents[8]);
  EXPECT_EQ(states->header().mesh.radius, (std::vector<double>{2, 1, 3}));
  EXPECT_EQ(states->header().mesh.yarns[1].name, "warp/1");
  EXPECT_EQ(states->header().mesh.yarns[1].family, micro::YarnFamily::warp);
}

TEST_F(Hdf5Nodes, WithoutYarnsThereIsOne) {
  Hdf5File(path_).remove("fibers/yarn");
  const auto states = open_states({path_});
  ASSERT_EQ(states->header().mesh.yarns.size(), 1u);
  EXPECT_EQ(states->header().mesh.yarns[0].n_fibers, 3);
  EXPECT_EQ(states->read(0).fibers.r, straight);
}

TEST_F(Hdf5Nodes, AGoodFileHasNoComplaint) { EXPECT_EQ(complaint(), ""); }

TEST_F(Hdf5Nodes, IncrementsOutOfRange) {
  const auto states = open_states({path_});
  EXPECT_NE(input_error([&] { (void)states->read(2); }).find("no increment 2: it holds 2"), std::string::npos);
  EXPECT_NE(input_error([&] { (void)states->read(-1); }), "");
}

TEST_F(Hdf5Nodes, MissingParts) {
  Hdf5File(path_).remove("increments/1/position");
  expect_complaint("dataset increments/1/position is missing");
  Hdf5File(path_).remove("increments/0");
  expect_complaint("group increments has 1 members, which must be called 0 … 0, but 0 is not there");
  Hdf5File(path_).remove("increments/1");
  expect_complaint("group increments is empty");
  Hdf5File(path_).remove("increments");
  expect_complaint("group increments is missing");
  Hdf5File(path_).remove("fibers");
  expect_complaint("neither a state file (no attribute layout) nor fiber nodes (no dataset fibers/start)");
}

TEST_F(Hdf5Nodes, FibersThatCannotBe) {
  for (const std::vector<int>& bad :
       {std::vector<int>{}, {0}, {1, 3}, {0, 3, 2, 9}, {0, 1, 9}, {0, -4, 9}, {0, 3, 3, 9}}) {
    Hdf5File(path_).put("fibers/start", bad);
    expect_complaint("dataset fibers/start");
  }
}

TEST_F(Hdf5Nodes, OtherSizesAndTypes) {
  Hdf5File(path_).put("increments/1/position", std::vector<Vec3>(8, Vec3::Ones()));
  expect_complaint("dataset increments/1/position has size (8 x 3), expected (9 x 3)");
  Hdf5File(path_).put("increments/1/position", std::vector<double>(27, 1.0));
  expect_complaint("dataset increments/1/position has size (27), expected (9 x 3)");
  Hdf5File(path_).put("increments/1/position", std::vector<Vec3>());
  expect_complaint("dataset increments/1/position has size (0 x 3), expected (9 x 3)");
  Hdf5File(path_).put("fibers/yarn", std::vector<double>{0, 0, 1});
  expect_complaint("dataset fibers/yarn must hold integers");
  Hdf5File(path_).put("fibers/start", std::vector<const char*>{"0", "9"});
  expect_complaint("dataset fibers/start must hold integers");
}

TEST_F(Hdf5Nodes, PlacesThatCannotBe) {
  std::vector<Vec3> bad = bent();
  bad[4].z() = std::nan("");
  Hdf5File(path_).put("increments/1/position", bad);
  expect_complaint("dataset increments/1/position holds values that are not finite, at node 4");
  bad = straight;
  bad[8] = bad[7];
  Hdf5File(path_).put("increments/0/position", bad);
  expect_complaint("dataset increments/0/position: nodes 2 and 3 of fiber 2 coincide");
  bad[8].x() = 1e308, bad[7].x() = -1e308;
  Hdf5File(path_).put("increments/0/position", bad);
  expect_complaint("dataset increments/0/position holds 1e+308 m, at node 7; must be at most 1e+09 m");
  Hdf5File(path_).put("increments/0/position", straight);
  Hdf5File(path_).put("increments/1/position", bad);
  expect_complaint("dataset increments/1/position holds 1e+308 m, at node 7");
}

TEST_F(Hdf5Nodes, YarnsThatCannotBe) {
  Hdf5File(path_).put("fibers/yarn", std::vector<int>{0, 3, 0});
  expect_complaint("dataset fibers/yarn holds 0 … 3, allowed: 0 … 2");
  Hdf5File(path_).put("fibers/yarn", std::vector<int>{0, -1, 0});
  expect_complaint("dataset fibers/yarn holds -1 … 0, allowed: 0 … 2");
  Hdf5File(path_).put("fibers/yarn", std::vector<int>{0, 1, 0});
  Hdf5File(path_).put("yarns/name", std::vector<const char*>{"a"});
  expect_complaint("dataset fibers/yarn holds 0 … 1, allowed: 0 … 0");
  for (const char* name : {"", "b\nc", "\x1b[2J", "Tr\xe4ger"}) {
    Hdf5File(path_).put("yarns/name", std::vector<const char*>{"a", name});
    expect_complaint("dataset yarns/name holds \"");
    expect_complaint("a yarn's name is a text of one line");
  }
  Hdf5File(path_).put("yarns/name", std::vector<int>{1, 2});
  expect_complaint("dataset yarns/name must hold text");
  Hdf5File(path_).put("yarns/name", std::vector<const char*>{"a", "b"});
  Hdf5File(path_).put("yarns/family", std::vector<int>{0, 3});
  expect_complaint("dataset yarns/family holds 3, allowed: 0 (warp), 1 (weft), 2 (neither)");
}

/// Nothing may be allocated for a size before it is checked: these would be terabytes.
TEST_F(Hdf5Nodes, HugeClaims) {
  const hsize_t huge = hsize_t(1) << 40;
  Hdf5File(path_).put("increments/1/position", H5T_IEEE_F64LE, {huge, 3}, 0, nullptr);
  expect_complaint("dataset increments/1/position has size (1099511627776 x 3)");
  Hdf5File(path_).put("yarns/name", H5T_C_S1, {huge}, 0, nullptr);
  expect_complaint("dataset yarns/name has 1099511627776 entries, allowed are");
  Hdf5File(path_).put("fibers/start", H5T_STD_I64LE, {huge}, 0, nullptr);
  expect_complaint("dataset fibers/start has 1099511627776 entries, allowed are");
}

TEST_F(Hdf5Nodes, FibersThatRunAgainstTheirYarnAreTurned) {
  std::vector<Vec3> turned = straight, bent_turned = bent(), tangents(9, Vec3(0, 0, 1));
  std::reverse(turned.begin() + 5, turned.end());
  std::reverse(bent_turned.begin() + 5, bent_turned.end());
  Hdf5File(path_).put("fibers/yarn", std::vector<int>{0, 0, 0});
  Hdf5File(path_).put("increments/0/position", turned);
  Hdf5File(path_).put("increments/1/position", bent_turned);
  Hdf5File(path_).put("increments/1/tangent", tangents);
  const auto states = open_states({path_});
  EXPECT_EQ(states->read(0).fibers.r, straight);
  EXPECT_EQ(states->read(1).fibers.r, bent());
  EXPECT_EQ(states->read(1).fibers.tangent[4], Vec3(0, 0, 1));
  EXPECT_EQ(states->read(1).fibers.tangent[5], Vec3(0, 0, -1));
  EXPECT_EQ(states->header().mesh.arc_length, (std::vector<double>{0, 1, 3, 0, 2, 0, 2, 3, 7}));
  EXPECT_EQ(states->remarks().at(0), "1 of 3 fibers ran against the others of their yarn and were turned");
}

TEST_F(Hdf5Nodes, LabelsMayBeTextsAndOtherwiseSpelled) {
  Hdf5File(path_).put("fibers/yarn", std::vector<const char*>{"weft, \"1\"", "warp", "weft, \"1\""});
  EXPECT_EQ(open_states({path_})->header().mesh.yarns.at(1).name, "weft, \"1\"");
  Hdf5File(path_).put("fibers/yarn", std::vector<const char*>{"a", "b"});
  expect_complaint("dataset fibers/yarn has 2 entries, expected 3");
  Hdf5File(path_).remove("fibers/yarn");
  Hdf5File(path_).put("fibers/TowId", std::vector<int>{1, 0, 1});
  EXPECT_EQ(open_states({path_})->header().mesh.yarns.size(), 2u);
  EXPECT_EQ(open_states({path_})->remarks().at(0), "yarns are taken from the dataset fibers/TowId");
  Hdf5File(path_).remove("fibers/TowId");
  Hdf5File(path_).put("fibers/strand", std::vector<int>{1, 0, 1});
  EXPECT_EQ(open_states({path_})->remarks().at(0),
            "no dataset fibers/yarn, so all fibers are one yarn; there are fibers/strand");
}

TEST_F(Hdf5Nodes, AUnitIsTaken) {
  Hdf5File(path_).put("fibers/yarn", std::vector<int>{0, 0, 0});
  Hdf5File(path_).put("fibers/radius", std::vector<double>{2, 2, 2});
  {
    const Hdf5File file(path_);
    const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
    H5Tset_size(type, 2);
    const hid_t attribute = H5Acreate2(file.id(), "unit", type, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, type, "mm");
    H5Aclose(attribute), H5Sclose(space), H5Tclose(type);
  }
  const auto states = open_states({path_});
  EXPECT_NEAR(states->read(1).fibers.r[2].x(), bent()[2].x() * 1e-3, 1e-15);
  EXPECT_NEAR(states->header().mesh.radius[0], 2e-3, 1e-15);
  EXPECT_NEAR(states->header().mesh.arc_length[2], 3e-3, 1e-15);
}

TEST_F(Hdf5Nodes, OtherVersion) {
  Hdf5File(path_).put_attribute("layout_version", 2);
  expect_complaint("layout_version 2 of fiber nodes; this program reads version 1 only");
}

TEST_F(Hdf5Nodes, NotAFileOfThisKind) {
  fs::remove(path_);
  expect_complaint("no such file");
  fs::create_directory(path_);
  expect_complaint("not a file");
  fs::remove(path_);
  for (const std::string& content : {std::string(), std::string("x,y,z\n0,0,0\n"), std::string(5000, '\0')}) {
    write_text(path_, content);
    expect_complaint("not an HDF5 file");
  }
  fs::remove(path_);
  Hdf5File(path_).put_attribute("something", 1);
  expect_complaint("neither a state file");
}

TEST_F(Hdf5Nodes, TruncatedAnywhere) {
  const std::string whole = test::read_text(path_);
  for (int part = 1; part < 50; ++part) {
    write_text(path_, whole.substr(0, whole.size() * part / 50));
    EXPECT_NE(complaint(), "") << part << " / 50";
  }
}

// ---- VTK ----------------------------------------------------------------------------------------------------------

class VtpNodes : public ::testing::Test {
 protected:
  VtpNodes() {
    write_vtp(files_[0], polylines(straight, start, {7, -2, 7}));
    write_vtp(files_[1], polylines(bent(), start, {7, -2, 7}));
  }
  [[nodiscard]] std::string complaint() const {
    return input_error([&] {
      const auto states = open_states(files_);
      for (Index i = 0; i < states->n_increments(); ++i) (void)states->read(i);
    });
  }
  void expect_complaint(const std::string& part) const {
    const std::string message = complaint();
    EXPECT_NE(message.find(part), std::string::npos) << "message: " << message << "\nexpected: " << part;
    EXPECT_NE(message.find(files_[1].string()), std::string::npos) << "message names the file: " << message;
  }
  /// The second file as text with two points on one line, and something else in the place of one part.
  void write_with(const std::string& part, const std::string& other) const {
    std::string text = R"(<VTKFile type="PolyData" version="0.1" byte_order="LittleEndian"><PolyData>
<Piece NumberOfPoints="2" NumberOfLines="1"><Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">
0 0 0 1 0 0</DataArray></Points>
<Lines><DataArray type="Int32" Name="connectivity" format="ascii">0 1</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">2</DataArray></Lines></Piece></PolyData></VTKFile>)";
    if (!part.empty()) text.replace(text.find(part), part.size(), other);
    write_text(files_[1], text);
  }

  TemporaryFolder folder_;
  std::vector<fs::path> files_ = {folder_ / "a.vtp", folder_ / "b.vtp"};
};

/// Labels, whatever their kind and place; family by family the same yarns.
vtkSmartPointer<vtkStringArray> text_labels(const std::vector<const char*>& labels, const char* name) {
  auto array = vtkSmartPointer<vtkStringArray>::New();
  array->SetName(name);
  for (const char* label : labels) array->InsertNextValue(label);
  return array;
}

TEST_F(VtpNodes, LabelsMayBeTexts) {
  const vtkSmartPointer<vtkPolyData> data = polylines(straight, start);
  data->GetCellData()->AddArray(text_labels({"warp, left", "weft", "warp, left"}, "yarn"));
  write_vtp(files_[0], data);
  const auto states = open_states({files_[0]});
  ASSERT_EQ(states->header().mesh.yarns.size(), 2u);
  EXPECT_EQ(states->header().mesh.yarns[0].name, "warp, left");
  EXPECT_EQ(states->header().mesh.yarns[0].n_fibers, 2);
  EXPECT_EQ(states->header().mesh.yarns[1].name, "weft");
  EXPECT_TRUE(states->remarks().empty());
}

TEST_F(VtpNodes, LabelsMayBeAtPointsAndOtherwiseSpelled) {
  const vtkSmartPointer<vtkPolyData> data = polylines(straight, start);
  vtkNew<vtkIntArray> labels;
  labels->SetName("Yarn_ID");
  for (const int label : {4, 4, 4, 3, 3, 4, 4, 4, 4}) labels->InsertNextValue(label);
  data->GetPointData()->AddArray(labels);
  write_vtp(files_[0], data);
  const auto states = open_states({files_[0]});
  ASSERT_EQ(states->header().mesh.yarns.size(), 2u);
  EXPECT_EQ(states->header().mesh.yarns[1].name, "yarn/4");
  EXPECT_EQ(states->remarks(), std::vector<std::string>{"yarns are taken from the array \"Yarn_ID\""});
  labels->SetValue(2, 3);
  write_vtp(files_[1], data);
  expect_complaint("array Yarn_ID: fiber 0 belongs to 4 and to 3");
}

TEST_F(VtpNodes, ArraysThatMayBeLabelsAreNamed) {
  const vtkSmartPointer<vtkPolyData> data = polylines(straight, start);
  data->GetCellData()->AddArray(text_labels({"a", "b", "a"}, "strand"));
  write_vtp(files_[0], data);
  const auto states = open_states({files_[0]});
  EXPECT_EQ(states->header().mesh.yarns.size(), 1u);
  EXPECT_EQ(states->remarks(),
            std::vector<std::string>{"no array \"yarn\", so all fibers are one yarn; there are \"strand\""});
}

/// The same three fibers as `straight`, as segments in disorder, some of them backward, each with points of its own or
/// not.
TEST_F(VtpNodes, SegmentsAreJoined) {
  const std::vector<std::pair<Index, Index>> segments = {{6, 7}, {0, 1}, {3, 4}, {8, 7}, {2, 1}, {5, 6}};
  for (const bool own_points : {false, true}) {
    const vtkSmartPointer<vtkPolyData> data = polylines(straight, {});
    vtkNew<vtkPoints> points;
    for (const auto& [a, b] : segments) {
      const vtkIdType shared[] = {a, b};
      const vtkIdType own[] = {points->InsertNextPoint(straight[a].data()),
                               points->InsertNextPoint(straight[b].data())};
      data->GetLines()->InsertNextCell(2, own_points ? own : shared);
    }
    if (own_points) data->SetPoints(points);
    data->GetCellData()->AddArray(text_labels({"b", "b", "a", "b", "b", "b"}, "yarn"));
    write_vtp(files_[0], data);
    const auto states = open_states({files_[0]});
    EXPECT_EQ(states->header().mesh.first_node, (std::vector<Index>{0, 2, 5, 9}));
    EXPECT_EQ(states->remarks().at(0), "6 lines of two points were joined to 3 fibers");
    const std::vector<Vec3> r = states->read(0).fibers.r;
    EXPECT_EQ(std::vector<Vec3>(r.begin(), r.begin() + 2), (std::vector<Vec3>{{0, 5, 0}, {2, 5, 0}}));
    EXPECT_EQ(states->header().mesh.arc_length, (std::vector<double>{0, 2, 0, 1, 3, 0, 2, 3, 7}));
  }
}

TEST_F(VtpNodes, SegmentsThatAreNoFibers) {
  const auto write = [&](const std::vector<std::pair<Index, Index>>& segments) {
    const vtkSmartPointer<vtkPolyData> data = polylines(straight, {});
    for (const auto& [a, b] : segments) {
      const vtkIdType ids[] = {a, b};
      data->GetLines()->InsertNextCell(2, ids);
    }
    write_vtp(files_[1], data);
  };
  write({{0, 1}, {1, 2}, {1, 3}});
  expect_complaint("3 lines of two points meet at point 1: fibers do not branch");
  write({{0, 1}, {1, 3}, {3, 0}, {5, 6}});
  expect_complaint("form a closed ring");
}

TEST_F(VtpNodes, AUnitIsTakenOrMissed) {
  std::vector<Vec3> large = straight;
  for (Vec3& x : large) x *= 100;
  const vtkSmartPointer<vtkPolyData> data = polylines(large, start);
  write_vtp(files_[0], data);
  EXPECT_NE(open_states({files_[0]})->remarks().at(0).find("the fibers reach over 700 m"), std::string::npos);
  data->GetFieldData()->AddArray(text_labels({"um"}, "unit"));
  write_vtp(files_[0], data);
  const auto states = open_states({files_[0]});
  EXPECT_TRUE(states->remarks().empty());
  EXPECT_NEAR(states->read(0).fibers.r[2].x(), 300e-6, 1e-15);
  data->GetFieldData()->AddArray(text_labels({"parsec per kg"}, "unit"));
  write_vtp(files_[1], data);
  expect_complaint("unit \"parsec per kg\"; must be one of length");
}

TEST_F(VtpNodes, FilesAreStates) {
  const auto states = open_states(files_);
  EXPECT_EQ(states->n_increments(), 2);
  const micro::FiberMesh& mesh = states->header().mesh;
  EXPECT_EQ(mesh.first_node, (std::vector<Index>{0, 2, 5, 9}));
  ASSERT_EQ(mesh.yarns.size(), 2u);
  EXPECT_EQ(mesh.yarns[0].name, "yarn/-2");
  EXPECT_EQ(mesh.yarns[1].name, "yarn/7");
  EXPECT_EQ(mesh.yarns[1].n_fibers, 2);
  const micro::Increment increment = states->read(1);
  EXPECT_EQ(increment.stage, "b");
  expect_bent_tangents(increment.fibers, {1, 1, 0, 1, 3, 0, 2, 3, 7});
  EXPECT_NE(input_error([&] { (void)states->read(2); }), "");
}

/// Points come in any order, vertices before the lines have cell values of their own, yarns are of a family.
TEST_F(VtpNodes, LinesPickTheirPoints) {
  const vtkSmartPointer<vtkPolyData> data = polylines({{2, 0, 0}, {9, 9, 9}, {1, 0, 0}, {0, 0, 0}}, {});
  const vtkIdType line[] = {3, 2, 0}, vertex[] = {1};
  vtkNew<vtkCellArray> vertices;
  vertices->InsertNextCell(1, vertex);
  data->SetVerts(vertices);
  data->GetLines()->InsertNextCell(3, line);
  for (const char* name : {"yarn", "family"}) {
    vtkNew<vtkIntArray> array;
    array->SetName(name);
    array->InsertNextValue(5);
    array->InsertNextValue(1);
    data->GetCellData()->AddArray(array);
  }
  vtkNew<vtkDoubleArray> radius;
  radius->SetName("radius");
  for (const double r : {0.1, 0.2, 0.3, 0.4}) radius->InsertNextValue(r);
  data->GetPointData()->AddArray(radius);
  write_vtp(files_[0], data);
  const auto states = open_states({files_[0]});
  EXPECT_EQ(states->read(0).fibers.r, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}));
  ASSERT_EQ(states->header().mesh.yarns.size(), 1u);
  EXPECT_EQ(states->header().mesh.yarns[0].name, "yarn/1");
  EXPECT_EQ(states->header().mesh.yarns[0].family, micro::YarnFamily::weft);
  EXPECT_EQ(states->header().mesh.radius, std::vector<double>{0.4});
}

TEST_F(VtpNodes, StatesMustHaveTheSameFibers) {
  write_vtp(files_[1], polylines(straight, {0, 2, 5, 9}, {7, -2, 7}));
  expect_complaint("its polylines differ from those of");
  write_vtp(files_[1], polylines(straight, start, {7, -2, -2}));
  expect_complaint("its polylines differ from those of");
}

TEST_F(VtpNodes, LinesThatCannotBe) {
  write_vtp(files_[1], polylines(straight, {}));
  expect_complaint("holds no polylines");
  write_with(">2</DataArray>", ">1</DataArray>");
  expect_complaint("fiber 0 from node 0 to before node 1; a fiber needs at least 2 nodes");
  std::vector<Vec3> bad = straight;
  bad[4].z() = std::numeric_limits<double>::infinity();
  write_vtp(files_[1], polylines(bad, start));
  expect_complaint("Points holds values that are not finite, at node 4");
}

TEST_F(VtpNodes, LabelsMustBeIntegers) {
  const vtkSmartPointer<vtkPolyData> data = polylines(straight, start);
  vtkNew<vtkDoubleArray> labels;
  labels->SetName("yarn");
  for (const double label : {1.0, 2.5, 1.0}) labels->InsertNextValue(label);
  data->GetCellData()->AddArray(labels);
  write_vtp(files_[1], data);
  expect_complaint("cell array yarn: 2.5 in cell 1");
}

TEST_F(VtpNodes, DamagedNumbers) {
  write_with("", "");
  expect_complaint("its polylines differ from those of");  // good as such
  write_with("NumberOfPoints=\"2\"", "NumberOfPoints=\"4000000000000\"");
  expect_complaint("claims to hold 4000000000000 points");
  write_with("NumberOfPoints=\"2\"", "NumberOfPoints=\"-2\"");
  EXPECT_NE(complaint(), "");
  write_with("NumberOfLines=\"1\"", "NumberOfLines=\"4000000000000\"");
  expect_complaint("claims to hold 4000000000000 cells");
  write_with("0 1</DataArray>", "0 2</DataArray>");
  expect_complaint("line 0 has point 2, but there are 2");
  write_with("0 1</DataArray>", "0 -1</DataArray>");
  expect_complaint("line 0 has point -1, but there are 2");
  write_with(">2</DataArray>", ">3</DataArray>");
  expect_complaint("damaged VTK file");
  write_with(">2</DataArray>", ">-3</DataArray>");
  expect_complaint("damaged VTK file");
  write_with(">2</DataArray>", ">2000000000</DataArray>");
  expect_complaint("damaged VTK file");
  write_with("0 0 0 1 0 0", "0 0 0 1");
  expect_complaint("damaged VTK file");
  write_with("Name=\"offsets\"", "Name=\"other\"");
  expect_complaint("damaged VTK file");
}

/// VTK does not survive an array that has not one value a cell; of several files the one that is damaged is named.
TEST_F(VtpNodes, ArraysOfOtherSizesAreNoEndOfTheProgram) {
  write_with("<Points>",
             "<CellData><DataArray type=\"Int32\" Name=\"yarn\" format=\"ascii\"></DataArray></CellData><Points>");
  const auto all = [](const meso::FiberStates& states) {
    return states.n_increments() == 2 ? std::vector<Index>{0, 1} : std::vector<Index>{0};
  };
  const std::string message = input_error([&] { probe_states(files_, all); });
  for (const std::string& part : {files_[1].string() + ": damaged", std::string("one value a cell or point")})
    EXPECT_NE(message.find(part), std::string::npos) << message;
  write_vtp(files_[1], polylines(bent(), start, {7, -2, 7}));
  EXPECT_EQ(input_error([&] { probe_states(files_, all); }), "");
}

TEST_F(VtpNodes, NotAFileOfThisKind) {
  fs::remove(files_[1]);
  expect_complaint("no such file");
  fs::create_directory(files_[1]);
  expect_complaint("not a file");
  fs::remove(files_[1]);
  for (const char* content : {"", "x,y,z\n", "<?xml version=\"1.0\"?><VTKFile type=\"UnstructuredGrid\"/>"}) {
    write_text(files_[1], content);
    expect_complaint("not a VTK XML PolyData file");
  }
}

/// A cut is noticed, or nothing is lost by it: the file ends with arrays of polygons, which it has none of.
TEST_F(VtpNodes, TruncatedAnywhere) {
  const std::vector<Vec3> complete = open_states(files_)->read(1).fibers.r;
  const std::string whole = test::read_text(files_[1]);
  int n_noticed = 0;
  for (int part = 0; part < 50; ++part) {
    write_text(files_[1], whole.substr(0, whole.size() * part / 50));
    if (complaint().empty())
      EXPECT_EQ(open_states(files_)->read(1).fibers.r, complete) << part << " / 50";
    else
      ++n_noticed;
  }
  EXPECT_GT(n_noticed, 45);
}

TEST_F(VtpNodes, FilesOfDifferentKinds) {
  EXPECT_NE(input_error([&] {
              (void)open_states({files_[0], folder_ / "states.h5"});
            }).find("must all be .vtp"),
            std::string::npos);
}

// ---- tables -------------------------------------------------------------------------------------------------------

class TableNodes : public ::testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<meso::FiberStates> states_of(const std::string& text) const {
    write_text(path_, text);
    return open_states({path_});
  }
  void expect_complaint(const std::string& text, const std::string& part) const {
    const std::string message = input_error([&] { (void)states_of(text)->read(0); });
    EXPECT_NE(message.find(part), std::string::npos) << "message: " << message << "\nexpected: " << part;
    EXPECT_NE(message.find(path_.string()), std::string::npos) << message;
  }

  TemporaryFolder folder_;
  fs::path path_ = folder_ / "nodes.csv";
};

/// Whatever separates the fields, and in whatever order the columns are.
TEST_F(TableNodes, LinesAreNodes) {
  for (const std::string text : {"# unit: um\nyarn,fiber,x,y,z\n\"weft, 1\",1,0,0,0\n\"weft, 1\",1,10,0,0.5\n\"weft, "
                                 "1\",2,0,20,0\n\"weft, 1\",2,10,20,0\n",
                                 "\xef\xbb\xbf# unit: um\r\nz;y;x;Fiber;Yarn_Name\r\n0;0;0;1;weft, "
                                 "1\r\n0.5;0;+10;1;weft, 1\r\n0;20;0;2;weft, 1\r\n\r\n0;20;1e1;2;weft, 1",
                                 "#unit: um\nyarn\tfiber\tx\ty\tz\nweft 1\t1\t0\t0\t0\nweft 1\t1\t10\t0\t0.5\nweft "
                                 "1\t2\t0\t20\t0\nweft 1\t2\t10\t20\t0\n",
                                 "# unit: um\n 1 0  0 0\n 1.0 10 0 0.5\n 2 0 20 0\n 2 10 20 0\n",
                                 "# unit: um\n7 1 0 0 0\n7 1 10 0 0.5\n7 2 0 20 0\n7 2 10 20 0\n"}) {
    const auto states = states_of(text);
    EXPECT_EQ(states->header().mesh.first_node, (std::vector<Index>{0, 2, 4})) << text;
    EXPECT_EQ(states->header().mesh.yarns.size(), 1u) << text;
    const std::vector<Vec3> r = states->read(0).fibers.r;
    ASSERT_EQ(r.size(), 4u) << text;
    EXPECT_NEAR((r[1] - Vec3(10e-6, 0, 0.5e-6)).norm(), 0, 1e-20) << text;
    EXPECT_EQ(states->read(0).stage, "nodes");
  }
  for (const char* names : {"Yarn ID,Fiber_ID,Points:0,Points:1,Points:2", "tow,Filament,X,Y,Z"})
    EXPECT_EQ(states_of(names + std::string("\n7,1,0,0,0\n7,1,3,0,0\n"))->read(0).fibers.r[1], Vec3(3, 0, 0)) << names;
  EXPECT_EQ(states_of("yarn,fiber,x,y,z\na,1,0,0,0\na,1,1,0,0\nb,1,0,1,0\nb,1,1,1,0\n")->header().mesh.yarns.size(),
            2u);
}

TEST_F(TableNodes, WhatCannotBeIsToldWithItsLine) {
  expect_complaint("", "holds no fiber nodes");
  expect_complaint("# only\n", "holds no fiber nodes");
  expect_complaint("a,b\n1,2\n", "line 1: no column \"x\"");
  expect_complaint("fiber,x (um),y,z\n",
                   "yarn and radius, a unit in a line \"# unit: um\" before; other columns here: \"x (um)\"");
  expect_complaint(std::string("\xff\xfe"
                               "f\0i\0",
                               6),
                   "line 1: holds a zero byte; must be a table as text in UTF-8");
  expect_complaint(std::string("fiber,x,y,z\n1,0,0,1\0"
                               "5\n",
                               22),
                   "line 2: holds a zero byte");
  expect_complaint("fiber,x,y,z\n1,0,0,1e10\n1,0,0,0\n", "holds 1e+10 m, at node 0; must be at most 1e+09 m");
  expect_complaint("# unit: Ym\nfiber,x,y,z\n1,0,0,1e300\n1,0,0,0\n", "not finite, at node 0");
  expect_complaint("fiber,x,y,z,x\n", "line 1: a second column \"x\"");
  expect_complaint("1 2 3\n", "line 1: 3 numbers; without column names a line holds fiber, x, y, z or");
  expect_complaint("fiber,x,y,z\n1,0,0\n", "line 2: 3 fields, expected 4");
  expect_complaint("fiber,x,y,z\n1,0,0,nan\n", "line 2: \"nan\" is not a finite number");
  expect_complaint("fiber,x,y,z\n1,0,0,1e400\n", "line 2: \"1e400\" is not a finite number");
  expect_complaint("fiber,x,y,z\n1,0,0,0\n1,1,0,0\n2,0,1,0\n2,1,1,0\n1,2,0,0\n", "line 6: fiber 1 again");
  expect_complaint("fiber,x,y,z\n1,0,0,0\n2,1,0,0\n", "a fiber needs at least 2 nodes");
  expect_complaint("fiber,x,y,z\n1,0,0,0\n1,0,0,0\n", "nodes 0 and 1 of fiber 0 coincide");
  expect_complaint("# unit: kg\nfiber,x,y,z\n1,0,0,0\n1,1,0,0\n", "line 1: unit \"kg\"; must be one of length");
  expect_complaint("yarn,fiber,x,y,z\na\x1b,1,0,0,0\n", "line 2 holds \"a\\x1b\"; a yarn's name is a text");
  expect_complaint(std::string(20'000, 'x'), "line 1: longer than 10000 bytes");
}

TEST_F(TableNodes, AFileOfAnotherKindIsToldWhichThereAre) {
  const fs::path other = folder_ / "nodes.stl";
  write_text(other, "solid fibers\n");
  const std::string message = input_error([&] { (void)open_states({other}); });
  for (const char* part : {"not an HDF5 file", ".vtp", ".csv"})
    EXPECT_NE(message.find(part), std::string::npos) << message;
}

TEST(Filters, ThatAreMissingAreCalledByTheirNames) {
  const TemporaryFolder folder;
  const fs::path path = folder / "lzf.h5";
  {
    const Hdf5File file(path);
    const hsize_t size = 4;
    const hid_t space = H5Screate_simple(1, &size, nullptr), properties = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(properties, 1, &size);
    H5Pset_filter(properties, 32000, H5Z_FLAG_OPTIONAL, 0, nullptr);  // lzf, which is not here: data stay as they are
    H5Gclose(H5Gcreate2(file.id(), "fibers", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    H5Dclose(H5Dcreate2(file.id(), "fibers/start", H5T_STD_I32LE, space, H5P_DEFAULT, properties, H5P_DEFAULT));
    H5Pclose(properties), H5Sclose(space);
  }
  const std::string message = input_error([&] { (void)open_states({path}); });
  EXPECT_NE(message.find("dataset fibers/start is compressed with lzf, which cannot be read here"), std::string::npos)
      << message;
}

// ---- the guard ----------------------------------------------------------------------------------------------------

TEST(Probe, TellsOfCrashesAndEndlessLoops) {
  EXPECT_NE(input_error([] { probe("a.h5", [] { raise(SIGSEGV); }); }).find("a.h5: damaged: reading it crashes"),
            std::string::npos);
  const auto endless = [] {
    for (volatile int i = 0;;) i = 1 - i;
  };
  EXPECT_NE(input_error([&] { probe("a.h5", endless, 1); }).find("a.h5: damaged: reading it does not end"),
            std::string::npos);
}

TEST(Probe, TellsOfReadingThatWaitsForEver) {
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_NE(input_error([] {
              probe(
                  "a file", [] { pause(); }, 1);
            }).find("does not end within 5 s"),
            std::string::npos);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(60));
}

TEST(Probe, LeavesErrorsToTheReadingItself) {
  EXPECT_EQ(input_error([] { probe("a.h5", [] { throw InputError("b"); }); }), "");
  EXPECT_EQ(input_error([] { probe("a.h5", [] {}); }), "");
}

TEST(Probe, AllowsLargeFilesMoreTime) {
  const TemporaryFolder folder;
  std::ofstream(folder / "large.h5").close();
  const unsigned small = seconds_to_read(folder / "large.h5");
  std::filesystem::resize_file(folder / "large.h5", 500'000'000);
  EXPECT_EQ(seconds_to_read(folder / "large.h5"), small + 100);
  EXPECT_EQ(seconds_to_read(folder / "missing.h5"), small);
}

}  // namespace
}  // namespace trame::workflows
