/// One simulation of plain_small, as a user runs it, and everything that it leaves.

#include <gtest/gtest.h>
#include <hdf5.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "support/process.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"

namespace trame::test {
namespace {

namespace fs = std::filesystem;

constexpr int n_fibers = 2 * 7 + 2 * 8;  // of plain_small.toml: two warp yarns of 7 and two weft yarns of 8

struct CurveRow {
  std::string stage;
  double stage_time = 0, warp_strain = 0, weft_strain = 0, warp_force = 0, weft_force = 0;
};

struct Range {
  double low = 0, high = 0;
};

class FullRun : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    outcome_ = new Outcome(run(folder_->path(), {TRAME_RUN_WORKFLOW, "plain_small", "--out", "out"}));
  }
  static void TearDownTestSuite() {
    delete outcome_;
    delete folder_;
  }
  static fs::path out() { return *folder_ / "out"; }
  static nlohmann::json summary() { return nlohmann::json::parse(read_text(out() / "summary.json")); }

  static TemporaryFolder* folder_;
  static Outcome* outcome_;
};
TemporaryFolder* FullRun::folder_ = nullptr;
Outcome* FullRun::outcome_ = nullptr;

std::vector<CurveRow> read_curves(const fs::path& file) {
  std::istringstream lines(read_text(file));
  std::string line;
  std::getline(lines, line);
  EXPECT_TRUE(line.starts_with("stage,stage_time,warp_strain,weft_strain,warp_force_N,weft_force_N,")) << line;
  std::vector<CurveRow> rows;
  while (std::getline(lines, line)) {
    CurveRow row;
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line);
    fields >> row.stage >> row.stage_time >> row.warp_strain >> row.weft_strain >> row.warp_force >> row.weft_force;
    EXPECT_TRUE(fields) << line;
    if (row.stage_time > 0) rows.push_back(row);  // without the starts of stages
  }
  return rows;
}

/// The data files of a .pvd collection, in its order.
std::vector<fs::path> pvd_files(const fs::path& pvd) {
  static const std::regex entry(R"re(<DataSet\b[^>]*\bfile="([^"]*)")re");
  const std::string text = read_text(pvd);
  std::vector<fs::path> files;
  for (std::sregex_iterator match(text.begin(), text.end(), entry), end; match != end; ++match)
    files.push_back(pvd.parent_path() / (*match)[1].str());
  return files;
}

template <class Reader>
vtkSmartPointer<vtkDataSet> read_with(const fs::path& file) {
  const auto reader = vtkSmartPointer<Reader>::New();
  reader->SetFileName(file.c_str());
  reader->Update();
  return reader->GetOutput();
}

vtkSmartPointer<vtkDataSet> read_vtk(const fs::path& file) {
  return file.extension() == ".vtp" ? read_with<vtkXMLPolyDataReader>(file)
                                    : read_with<vtkXMLUnstructuredGridReader>(file);
}

/// Expects every component of the named array to be a number within `range`.
void expect_array(vtkDataSetAttributes* data, const char* name, int n_components, Range range) {
  vtkDataArray* array = data->GetArray(name);
  ASSERT_NE(array, nullptr) << name;
  ASSERT_EQ(array->GetNumberOfComponents(), n_components) << name;
  ASSERT_GT(array->GetNumberOfTuples(), 0) << name;
  for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i)
    for (int c = 0; c < n_components; ++c) {
      const double value = array->GetComponent(i, c);
      ASSERT_TRUE(value >= range.low && value <= range.high) << name << "[" << i << "] = " << value;
    }
}

/// Sizes of a dataset of a state file; empty where it is missing.
std::vector<hsize_t> dataset_shape(hid_t file, const char* path) {
  const hid_t set = H5Dopen2(file, path, H5P_DEFAULT);
  if (set < 0) return {};
  const hid_t space = H5Dget_space(set);
  std::vector<hsize_t> shape(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
  H5Sget_simple_extent_dims(space, shape.data(), nullptr);
  H5Sclose(space);
  H5Dclose(set);
  return shape;
}

std::vector<double> read_doubles(hid_t file, const char* path) {
  std::size_t n = 1;
  for (const hsize_t extent : dataset_shape(file, path)) n *= extent;
  std::vector<double> values(n);
  const hid_t set = H5Dopen2(file, path, H5P_DEFAULT);
  EXPECT_GE(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0) << path;
  H5Dclose(set);
  return values;
}

TEST_F(FullRun, EndsWellAndTellsWhereTheResultsAre) {
  EXPECT_EQ(outcome_->exit_code, 0) << outcome_->out << outcome_->err;
  for (const char* text :
       {"30 fibers", "Results in out", "vtk/fibers.pvd", "vtk/yarns.pvd", "summary.json", "report.html"})
    EXPECT_NE(outcome_->out.find(text), std::string::npos) << text;
}

TEST_F(FullRun, SummaryIsThatOfASoundRun) {
  const nlohmann::json json = summary();
  EXPECT_EQ(json.at("status"), "done");
  EXPECT_EQ(json.at("scene"), "plain_small");
  EXPECT_EQ(json.at("n_fibers"), n_fibers);
  EXPECT_GT(json.at("n_contact_elements_max"), 0);
  EXPECT_EQ(json.at("crossing_order_ok"), true);
  EXPECT_EQ(json.at("n_crossings"), 4);
  EXPECT_GT(json.at("max_penetration_over_radius"), 0.0);
  EXPECT_LT(json.at("max_penetration_over_radius"), 0.1);
  EXPECT_LT(json.at("force_imbalance"), 1e-2);
  EXPECT_GT(json.at("energy").at("stored"), 0.0);
  EXPECT_GE(json.at("energy").at("friction"), 0.0);
  EXPECT_GT(json.at("seconds").at("factorization"), 0.0);
  EXPECT_GT(json.at("seconds").at("meso"), 0.0);
  EXPECT_GT(json.at("seconds").at("total"), json.at("seconds").at("factorization"));
}

TEST_F(FullRun, CurvesFollowTheLoadPathToTwoPercent) {
  const std::vector<CurveRow> rows = read_curves(out() / "curves.csv");
  ASSERT_EQ(rows.size(), summary().at("n_increments").get<std::size_t>());
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double earlier = rows[i].stage == rows[i - 1].stage ? rows[i - 1].stage_time : 0;
    EXPECT_GT(rows[i].stage_time, earlier) << i;
  }
  const CurveRow& last = rows.back();
  EXPECT_EQ(last.stage, "load");
  EXPECT_DOUBLE_EQ(last.stage_time, 1);
  EXPECT_NEAR(last.warp_strain, 0.02, 1e-8);
  EXPECT_NEAR(last.weft_strain, 0, 1e-8);
  EXPECT_GT(last.warp_force, 0);
}

/// The energy that fibers hold, and that is rubbed off, damped or released, is what came in, within 2 % of the work of
/// weaving and pulling. (The rest is the error of the steps.)
TEST_F(FullRun, EnergyBalanceCloses) {
  const nlohmann::json energy = summary().at("energy");
  EXPECT_LT(std::abs(energy.at("imbalance").get<double>()), 0.02 * energy.at("external_work").get<double>());
}

TEST_F(FullRun, AnotherRunStartsWhereAStageEndedAndGivesTheSameForces) {
  const std::string states = (out() / "states.h5").string();
  const Outcome again = run(folder_->path(), {TRAME_SIMULATE_FIBERS, "plain_small", "--start-from", states, "--after",
                                              "settle", "--out", "again"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  std::vector<CurveRow> load;
  for (const CurveRow& row : read_curves(out() / "curves.csv"))
    if (row.stage == "load") load.push_back(row);
  const std::vector<CurveRow> rows = read_curves(*folder_ / "again/curves.csv");
  ASSERT_EQ(rows.size(), load.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_NEAR(rows[i].warp_strain, load[i].warp_strain, 1e-8);
    // Contact geometry is that of the saved state from the start, so forces agree to the tolerance of an increment
    // only.
    EXPECT_NEAR(rows[i].warp_force, load[i].warp_force, 5e-3 * load.back().warp_force) << i;
    EXPECT_NEAR(rows[i].weft_force, load[i].weft_force, 5e-3 * load.back().weft_force) << i;
  }
  // What weaving has lost is not an error of the load.
  const auto lost_in_load = [](const nlohmann::json& results) {
    return results.at("error_estimate").at("a_posteriori").at("steps").get<double>();
  };
  EXPECT_NEAR(lost_in_load(nlohmann::json::parse(read_text(*folder_ / "again/summary.json"))), lost_in_load(summary()),
              5e-3);
}

TEST_F(FullRun, StartsFromNothingElseThanAFinishedStageOfTheSameFibers) {
  const std::string states = (out() / "states.h5").string();
  const auto refusal = [&](const std::vector<std::string>& arguments) {
    std::vector<std::string> command = {TRAME_SIMULATE_FIBERS};
    command.insert(command.end(), arguments.begin(), arguments.end());
    const Outcome outcome = run(folder_->path(), command);
    EXPECT_EQ(outcome.exit_code, 2);
    return outcome.err;
  };
  const auto names = [](const std::string& message, const char* text) {
    return message.find(text) != std::string::npos;
  };
  const std::string no_stage = refusal({"plain_small", "--start-from", states, "--after", "knit", "--out", "b"});
  EXPECT_TRUE(names(no_stage, "--after knit") && names(no_stage, "separate, relax, settle")) << no_stage;
  const std::string last = refusal({"plain_small", "--start-from", states, "--after", "load", "--out", "b"});
  EXPECT_TRUE(names(last, "--after load")) << last;
  const std::string other = refusal({"twill_small", "--start-from", states, "--after", "settle", "--out", "b"});
  EXPECT_TRUE(names(other, "another scene") && names(other, "numbers of fibers")) << other;
  const std::string itself =
      refusal({"plain_small", "--start-from", states, "--after", "settle", "--out", out().string(), "--overwrite"});
  EXPECT_TRUE(names(itself, "written over")) << itself;
  const std::string half = refusal({"plain_small", "--start-from", states, "--out", "b"});
  EXPECT_TRUE(names(half, "--after")) << half;
  EXPECT_FALSE(fs::exists(*folder_ / "b"));
  EXPECT_TRUE(fs::exists(states));
}

TEST_F(FullRun, PictureOfTheCurvesIsThereWhereGnuplotIs) {
  EXPECT_NE(read_text(out() / "curves.gp").find("curves.svg"), std::string::npos);
  if (run(folder_->path(), {"gnuplot", "--version"}).exit_code != 0) GTEST_SKIP() << "gnuplot is not installed";
  EXPECT_NE(read_text(out() / "curves.svg").find("</svg>"), std::string::npos);
}

TEST_F(FullRun, StatesHoldEveryNodeOfEveryIncrement) {
  const hid_t file = H5Fopen((out() / "states.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  const auto n_nodes = summary().at("n_nodes").get<hsize_t>();
  const auto n_saved = static_cast<hsize_t>(read_doubles(file, "n_increments").at(0));
  EXPECT_GE(n_saved, 2u);  // the reference state is one
  for (const char* path : {"fibers/r", "fibers/g1", "fibers/g2", "fibers/tangent"})
    EXPECT_EQ(dataset_shape(file, path), (std::vector<hsize_t>{n_saved, n_nodes, 3})) << path;
  for (const double coordinate : read_doubles(file, "fibers/r")) ASSERT_LT(std::abs(coordinate), 0.1);  // m
  for (const double force : read_doubles(file, "contacts/normal_force")) ASSERT_GE(force, 0);
  H5Fclose(file);
}

TEST_F(FullRun, FibersOpenInVtk) {
  const std::vector<fs::path> files = pvd_files(out() / "vtk/fibers.pvd");
  ASSERT_GE(files.size(), 2u);
  for (const fs::path& file : {files.front(), files.back()}) {
    const vtkSmartPointer<vtkDataSet> data = read_vtk(file);
    ASSERT_NE(data, nullptr) << file;
    EXPECT_EQ(data->GetNumberOfPoints(), summary().at("n_nodes").get<vtkIdType>());
    expect_array(data->GetPointData(), "radius", 1, {5e-6, 20e-6});
    expect_array(data->GetPointData(), "tension", 1, {-1, 1});
    expect_array(data->GetPointData(), "curvature", 1, {0, 1e6});
    expect_array(data->GetPointData(), "contact_force", 1, {0, 1e6});
    expect_array(data->GetPointData(), "displacement", 3, {-0.01, 0.01});
    expect_array(data->GetCellData(), "fiber", 1, {0, n_fibers - 1});
    expect_array(data->GetCellData(), "yarn", 1, {0, 3});
  }
}

TEST_F(FullRun, YarnsOpenInVtkWithStrainsThatMakeSense) {
  const std::vector<fs::path> files = pvd_files(out() / "vtk/yarns.pvd");
  ASSERT_GE(files.size(), 1u);
  const vtkSmartPointer<vtkDataSet> data = read_vtk(files.back());
  ASSERT_GT(data->GetNumberOfCells(), 0);
  expect_array(data->GetCellData(), "yarn", 1, {0, 3});
  expect_array(data->GetCellData(), "flagged", 1, {0, 2});
  vtkDataArray* flagged = data->GetCellData()->GetArray("flagged");
  for (const char* name : {"E_axial", "E_horizontal", "E_vertical", "gamma_max", "det_F"}) {
    vtkDataArray* strain = data->GetCellData()->GetArray(name);
    ASSERT_NE(strain, nullptr) << name;
    for (vtkIdType cell = 0; cell < data->GetNumberOfCells(); ++cell)
      EXPECT_EQ(std::isnan(strain->GetComponent(cell, 0)), flagged->GetComponent(cell, 0) > 0) << name << " " << cell;
  }
}

TEST_F(FullRun, SummaryKnowsTheYarns) {
  const nlohmann::json yarns = summary().at("yarns");
  ASSERT_EQ(yarns.size(), 4u);
  for (const nlohmann::json& yarn : yarns) {
    EXPECT_GT(yarn.at("n_tets"), 0);
    EXPECT_LE(yarn.at("E_axial_min"), yarn.at("E_axial_mean"));
    EXPECT_LE(yarn.at("E_axial_mean"), yarn.at("E_axial_max"));
  }
}

}  // namespace
}  // namespace trame::test
