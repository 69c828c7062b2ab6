/// strain_post from its command line to its files.

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <vtkCellData.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "support/fiber_files.h"
#include "support/lattice_yarns.h"
#include "support/measured.h"
#include "support/process.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"

namespace trame::test {
namespace {

using micro::test::LatticeYarns;
using micro::test::mapped;
namespace fs = std::filesystem;

/// Fields of a line between commas, which may be in quotes.
std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields = {""};
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (c == ',' && !quoted) {
      fields.emplace_back();
    } else if (c != '"') {
      fields.back() += c;
    }
  }
  return fields;
}

/// Lines of a CSV file by the names of their columns.
std::vector<std::map<std::string, std::string>> read_csv(const fs::path& file) {
  std::stringstream text(read_text(file));
  std::string line;
  std::getline(text, line);
  const std::vector<std::string> names = split(line);
  std::vector<std::map<std::string, std::string>> rows;
  while (std::getline(text, line)) {
    const std::vector<std::string> fields = split(line);
    EXPECT_EQ(fields.size(), names.size()) << line;
    auto& row = rows.emplace_back();
    for (std::size_t i = 0; i < std::min(names.size(), fields.size()); ++i) row[names[i]] = fields[i];
  }
  return rows;
}

/// Names and contents of all files in a folder, to see that nothing has changed.
std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files[fs::relative(entry.path(), folder)] = read_text(entry.path());
  return files;
}

/// The states of a run of three yarns: increment i is stretched by 1 + 0.01 i along them, in the stages relax (0, 1)
/// and load (2, 3).
class StrainPost : public ::testing::Test {
 protected:
  static double strain(double stretch) { return 0.5 * (stretch * stretch - 1); }
  static micro::FiberConfiguration state(Index i) {
    return mapped(LatticeYarns{.n_yarns = 3}.configuration(), Vec3(1 + 0.01 * i, 1, 1).asDiagonal());
  }
  static void write_states(const fs::path& file, const std::vector<std::string>& bodies) {
    micro::SnapshotWriter writer(file, {"1", "scene", "", LatticeYarns{.n_yarns = 3}.mesh(), bodies});
    for (Index i = 0; i < 4; ++i) {
      micro::Increment increment;
      increment.stage = i < 2 ? "relax" : "load";
      increment.stage_time = 0.5 * (i % 2 + 1);
      increment.fibers = state(i);
      for (std::size_t b = 0; b < bodies.size(); ++b) {
        const double side = bodies[b].ends_with("start") ? -1 : 1;
        increment.bodies.position.push_back(side * Vec3(0.01 + 0.001 * i, 0.02, 0));
        increment.bodies.rotation.push_back(Mat3::Identity());
        increment.bodies.force.push_back(side * Vec3(3.0 * i, 4.0 * i, 0));
        increment.bodies.moment.push_back(Vec3::Zero());
      }
      writer.append(increment);
    }
  }

  StrainPost() { write_states(folder_ / "states.h5", {}); }
  /// Runs the program in `runs/`, so that what it prints is not among its results. The report has a test of its own.
  Outcome post(std::vector<std::string> arguments) const {
    arguments.emplace_back("--no-report");
    return post_with_report(std::move(arguments));
  }
  Outcome post_with_report(std::vector<std::string> arguments) const {
    fs::create_directories(folder_ / "runs");
    arguments.insert(arguments.begin(), TRAME_STRAIN_POST);
    return run(folder_ / "runs", arguments);
  }
  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }
  void expect_refused(const std::vector<std::string>& arguments, const std::string& part) const {
    const Outcome outcome = post(arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.err.find(part), std::string::npos) << "message: " << outcome.err << "\nexpected: " << part;
  }
  [[nodiscard]] vtkSmartPointer<vtkUnstructuredGrid> read_vtu(const std::string& name) const {
    vtkNew<vtkXMLUnstructuredGridReader> reader;
    reader->SetFileName(path(name).c_str());
    reader->Update();
    return reader->GetOutput();
  }

  TemporaryFolder folder_;
};

TEST_F(StrainPost, FromTheFirstStateToTheLastBesideTheStates) {
  const Outcome outcome = post({path("states.h5")});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("from increment 0 to 3"), std::string::npos);
  const auto rows = read_csv(folder_ / "strains/strains.csv");
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[1].at("yarn"), "weft/1");
  for (const auto& row : rows) {
    EXPECT_EQ(row.at("increment"), "3");
    EXPECT_EQ(row.at("n_tets"), "360");  // 12 triangles, 10 layers of prisms, 3 tetrahedra in each
    EXPECT_EQ(row.at("n_flagged"), "0");
    EXPECT_NEAR(std::stod(row.at("E_axial_mean")), strain(1.03), 1e-9);
    EXPECT_NEAR(std::stod(row.at("E_axial_deviation")), 0, 1e-9);
    EXPECT_NEAR(std::stod(row.at("E_axial_median")), strain(1.03), 1e-9);
    EXPECT_NEAR(std::stod(row.at("E_axial_quantile_95")), strain(1.03), 1e-9);
    EXPECT_EQ(row.at("n_inverted"), "0");
    EXPECT_NEAR(std::stod(row.at("E_horizontal_max")), 0, 1e-9);
    EXPECT_NEAR(std::stod(row.at("E_vertical_min")), 0, 1e-9);
    EXPECT_NEAR(std::stod(row.at("gamma_max_mean")), strain(1.03), 1e-9);
    EXPECT_NEAR(std::stod(row.at("det_F_mean")), 1.03, 1e-9);
  }
  const auto grid = read_vtu("strains/yarns_0003.vtu");
  ASSERT_EQ(grid->GetNumberOfCells(), 3 * 360);
  EXPECT_NEAR(grid->GetCellData()->GetArray("E_axial")->GetTuple1(500), strain(1.03), 1e-7);
  EXPECT_EQ(grid->GetFieldData()->GetArray("from")->GetTuple1(0), 0);
  EXPECT_NE(read_text(folder_ / "strains/yarns.pvd").find("yarns_0003.vtu"), std::string::npos);
}

/// A lattice of fibers of radius 0.475, 3 rows of 4, that is stretched from A to B and nothing else.
TEST_F(StrainPost, SectionsAndValidityOfEachYarn) {
  const Outcome outcome = post({path("states.h5"), "--yarns", "warp/*", "--out", path("out")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto sections = read_csv(folder_ / "out/sections.csv");
  ASSERT_EQ(sections.size(), 2u * 12u);
  for (const std::size_t k : {0, 11, 13}) {
    const auto& row = sections[k];
    EXPECT_EQ(row.at("yarn"), k < 12 ? "warp/1" : "warp/2");
    EXPECT_EQ(row.at("station"), std::to_string(k % 12));
    EXPECT_NEAR(std::stod(row.at("fraction")), (double(k % 12) + 0.5) / 12, 1e-5);
    EXPECT_EQ(row.at("n_fibers_B"), "12");
    EXPECT_NEAR(std::stod(row.at("width_A_m")), 3.5 + 2 * 0.475, 1e-5);
    EXPECT_NEAR(std::stod(row.at("height_B_m")), std::sqrt(3.0) + 2 * 0.475, 1e-5);
    EXPECT_TRUE(row.at("shape_B") == "lens" || row.at("shape_B") == "ellipse") << row.at("shape_B");
    EXPECT_NEAR(std::stod(row.at("E_axial_side")), strain(1.03), 1e-5);
    EXPECT_NEAR(std::stod(row.at("side_to_centre")), 1, 1e-5);
  }
  const auto continuum = read_csv(folder_ / "out/continuum.csv");
  ASSERT_EQ(continuum.size(), 2u);
  EXPECT_EQ(continuum[1].at("yarn"), "warp/2");
  EXPECT_EQ(continuum[1].at("verdict"), "continuum holds");
  EXPECT_NEAR(std::stod(continuum[1].at("mesh_difference")), 0, 1e-6);
  EXPECT_NE(outcome.out.find("continuum holds"), std::string::npos);
  EXPECT_TRUE(read_csv(folder_ / "out/bands.csv").empty()) << "a uniform strain has none";
  EXPECT_TRUE(read_csv(folder_ / "out/zones.csv").empty());
}

/// Simple shear by 0.3 in the middle rows of a yarn of 12 × 12 fibers: one band along each section, one zone in all.
TEST_F(StrainPost, BandsAndZonesOfALocalisedShear) {
  const LatticeYarns yarns{.n_rows = 12, .n_columns = 12, .n_elements = 6, .length = 12};
  {
    micro::SnapshotWriter writer(folder_ / "band.h5", {"1", "scene", "", yarns.mesh(), {}});
    micro::Increment increment;
    increment.fibers = yarns.configuration();
    writer.append(increment);
    const double middle = 5.5 * std::sqrt(0.75);
    for (Vec3& r : increment.fibers.r) r.y() += 0.3 * std::clamp(r.z() - middle, -1.3, 1.3);
    writer.append(increment);
  }
  const Outcome outcome = post({path("band.h5"), "--mesh", "swept", "--out", path("out")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::map<std::string, int> stations;
  for (const auto& row : read_csv(folder_ / "out/bands.csv")) {
    if (row.at("component") != "gamma_max" || row.at("significant") != "1") continue;
    EXPECT_LT(std::abs(std::stod(row.at("angle_deg"))), 3);
    EXPECT_NEAR(std::stod(row.at("thickness_d")), 2.6, 0.15 * 2.6);
    EXPECT_LE(std::stod(row.at("p_value")), 0.01);
    ++stations[row.at("station")];
  }
  EXPECT_EQ(stations.size(), 12u);
  for (const auto& [station, n] : stations) EXPECT_EQ(n, 1) << station;
  for (const auto& row : read_csv(folder_ / "out/orientation.csv"))
    if (row.at("component") == "gamma_max") {
      EXPECT_GT(std::stod(row.at("0_deg")), 0.5) << "along the band";
      EXPECT_LT(std::stod(row.at("90_deg")), std::stod(row.at("0_deg")) - 0.5) << "across it";
    }
  const auto zones = read_csv(folder_ / "out/zones.csv");
  ASSERT_EQ(zones.size(), 1u);
  EXPECT_NEAR(std::stod(zones[0].at("extent_1_d")), 12, 1);
  EXPECT_GT(std::abs(std::stod(zones[0].at("normal_z"))), 0.99);
  const auto grid = read_vtu("out/yarns_0001.vtu");
  EXPECT_EQ(grid->GetCellData()->GetArray("shear_zone")->GetRange()[1], 1);
}

TEST_F(StrainPost, ReportOpensWithoutTheStates) {
  const Outcome outcome = post_with_report({path("states.h5"), "--out", path("out")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::string report = read_text(folder_ / "out/report.html");
  EXPECT_NE(report.find("</html>"), std::string::npos);
  EXPECT_NE(report.find("weft/1"), std::string::npos);
}

TEST_F(StrainPost, StatesByNumberOrStageAndYarnsByPattern) {
  const Outcome outcome = post({path("states.h5"), "--from", "relax", "--to", "2", "--yarns", "*/2", "weft/?", "--out",
                                path("out"), "--threads", "1"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto rows = read_csv(folder_ / "out/strains.csv");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].at("yarn"), "weft/1");
  EXPECT_EQ(rows[1].at("yarn"), "warp/2");
  EXPECT_NEAR(std::stod(rows[0].at("E_axial_mean")), strain(1.02 / 1.01), 1e-9);
  EXPECT_EQ(read_vtu("out/yarns_0002.vtu")->GetFieldData()->GetArray("from")->GetTuple1(0), 1);
}

TEST_F(StrainPost, EveryStateAsATimeSeries) {
  EXPECT_EQ(post({path("states.h5"), "--from", "1", "--every", "--out", path("out")}).exit_code, 0);
  const auto rows = read_csv(folder_ / "out/strains.csv");
  ASSERT_EQ(rows.size(), 9u);
  for (int k = 0; k < 9; ++k) EXPECT_EQ(rows[k].at("increment"), std::to_string(1 + k / 3));
  const std::string series = read_text(folder_ / "out/yarns.pvd");
  for (const char* file : {"yarns_0001.vtu", "yarns_0002.vtu", "yarns_0003.vtu"}) {
    EXPECT_TRUE(fs::exists(folder_ / "out" / file));
    EXPECT_NE(series.find(file), std::string::npos);
  }
  EXPECT_FALSE(fs::exists(folder_ / "out/yarns_0000.vtu"));
}

class StrainPostStudy : public StrainPost {
 protected:
  /// Peak memory of a series of so many increments, or of a longer one before it; MB.
  [[nodiscard]] double peak_of_series(Index n) const {
    const std::string file = path(std::to_string(n) + ".h5"), out = path("out" + std::to_string(n));
    {
      micro::SnapshotWriter writer(file, {"1", "scene", "", LatticeYarns{}.mesh(), {}});
      micro::Increment increment;
      for (Index i = 0; i < n; ++i) {
        increment.fibers = mapped(LatticeYarns{}.configuration(), Vec3(1 + 1e-5 * i, 1, 1).asDiagonal());
        writer.append(increment);
      }
    }
    EXPECT_EQ(post({file, "--every", "--out", out}).exit_code, 0);
    EXPECT_EQ(read_csv(fs::path(out) / "strains.csv").size(), std::size_t(n));
    rusage used{};
    getrusage(RUSAGE_CHILDREN, &used);
    return 1e-3 * double(used.ru_maxrss);
  }
};

TEST_F(StrainPostStudy, MemoryDoesNotGrowWithTheNumberOfIncrements) {
  const double few = peak_of_series(100), many = peak_of_series(2000);
  micro::test::measured(fmt::format("peak memory {:.1f} MB for 100 increments, {:.1f} MB for 2000", few, many));
  EXPECT_LT(many - few, 20) << "a state and its strains take 0.15 MB";
}

TEST_F(StrainPost, BothMeshesAreComparedInTheTable) {
  const Outcome outcome = post({path("states.h5"), "--mesh", "both", "--out", path("out")});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const char* part : {"delaunay", "swept", "difference"})
    EXPECT_NE(outcome.out.find(part), std::string::npos) << outcome.out;
  for (const std::string mesh : {"delaunay", "swept"}) {
    EXPECT_EQ(read_csv(folder_ / "out" / mesh / "strains.csv").size(), 3u);
    EXPECT_EQ(read_vtu("out/" + mesh + "/yarns_0003.vtu")->GetNumberOfCells(), 3 * 360);
  }
  EXPECT_FALSE(fs::exists(folder_ / "out/strains.csv"));
  for (const char* file : {"sections.csv", "continuum.csv", "delaunay/bands.csv", "swept/zones.csv"})
    EXPECT_TRUE(fs::exists(folder_ / "out" / file)) << file;
}

TEST_F(StrainPost, OverwriteTakesAwayItsOwnResultsOnly) {
  ASSERT_EQ(post({path("states.h5"), "--mesh", "both", "--every", "--out", path("out")}).exit_code, 0);
  write_text(folder_ / "out/notes.txt", "mine");
  write_text(folder_ / "out/swept/yarns_mine.vtu", "mine");
  const auto before = contents(folder_ / "out");
  expect_refused({path("states.h5"), "--out", path("out")}, "the folder is not empty");
  EXPECT_EQ(contents(folder_ / "out"), before);
  ASSERT_EQ(post({path("states.h5"), "--out", path("out"), "--overwrite"}).exit_code, 0);
  std::vector<std::string> names;
  for (const auto& [name, text] : contents(folder_ / "out")) names.push_back(name);
  EXPECT_EQ(names, (std::vector<std::string>{"bands.csv", "continuum.csv", "notes.txt", "orientation.csv",
                                             "sections.csv", "strains.csv", "swept/yarns_mine.vtu", "yarns.pvd",
                                             "yarns_0003.vtu", "zones.csv"}));
}

TEST_F(StrainPost, BadOptionsLeaveFilesAlone) {
  ASSERT_EQ(post({path("states.h5"), "--out", path("out")}).exit_code, 0);
  write_text(folder_ / "file", "");
  const auto before = contents(folder_ / "out");
  const auto with = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {path("states.h5"), "--out", path("out"), "--overwrite"});
    return options;
  };
  expect_refused(with({"--from", "4"}), "--from 4: allowed are 0 … 3");
  expect_refused(with({"--to", "-1"}), "--to -1: allowed are 0 … 3");
  expect_refused(with({"--to", "99999999999999999999"}), "allowed are 0 … 3");
  expect_refused(with({"--to", "weave"}), "--to weave: neither a number nor the name of a stage");
  expect_refused(with({"--to", ""}), "neither a number nor the name of a stage");
  expect_refused(with({"--from", "3", "--to", "1", "--every"}), "state A (3) is after state B (1)");
  expect_refused(with({"--yarns", "fill/*"}), "no yarn is called \"fill/*\"; there are: warp/1 weft/1 warp/2");
  expect_refused(with({"--mesh", "hexahedra"}), "--mesh");
  expect_refused(with({"--threads", "-1"}), "--threads");
  expect_refused(with({"--frm", "1"}), "--frm");
  expect_refused({path("states.h5"), "--out", path("file")}, "not a folder");
  expect_refused({}, "states");
  EXPECT_EQ(contents(folder_ / "out"), before);
}

TEST_F(StrainPost, BadFilesAreNamedAndMakeNoResults) {
  write_text(folder_ / "text.h5", "stage,force\n");
  write_text(folder_ / "text.vtp", "stage,force\n");
  for (const char* file : {"text.h5", "text.vtp", "missing.h5", "missing.vtp", "runs"})
    expect_refused({path(file), "--out", path("out")}, path(file) + ": ");
  fs::resize_file(folder_ / "states.h5", fs::file_size(folder_ / "states.h5") / 2);
  expect_refused({path("states.h5"), "--out", path("out")}, path("states.h5") + ": truncated or damaged");
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

/// A text whose length in the file's heap of texts is damaged may crash the library that reads it, but not the program.
TEST_F(StrainPost, DamagedHeapOfTexts) {
  {
    Hdf5File nodes(folder_ / "nodes.h5");
    nodes.put("fibers/start", std::vector<int>{0, 2});
    nodes.put("increments/0/position", std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}});
    nodes.put("yarns/name", std::vector<const char*>{"a name"});
  }
  std::string bytes = read_text(folder_ / "nodes.h5");
  const std::size_t heap = bytes.find("GCOL");
  ASSERT_NE(heap, std::string::npos);
  bytes[heap + 16 + 8 + 5] =
      0x7f;  // size of the first object, 8 bytes at 8 in its header, which follows 16 of the heap's
  write_text(folder_ / "nodes.h5", bytes);
  expect_refused({path("nodes.h5"), "--list"}, path("nodes.h5") + ": ");
}

TEST_F(StrainPost, ListsStatesAndYarns) {
  const Outcome outcome = post({path("states.h5"), "--list"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const char* part : {"increment", "relax", "load", "0.500", "contacts", "warp/2", "12"})
    EXPECT_NE(outcome.out.find(part), std::string::npos) << part << "\nin: " << outcome.out;
  EXPECT_EQ(outcome.out.find("force"), std::string::npos) << "there are no bodies";
  EXPECT_FALSE(fs::exists(folder_ / "strains"));
}

TEST_F(StrainPost, ListsTheLargestForceOnABody) {
  write_states(folder_ / "body.h5", {"tip"});
  const Outcome outcome = post({path("body.h5"), "--list"});
  EXPECT_NE(outcome.out.find("largest force (N)"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("1.500e+01"), std::string::npos) << "|(9, 12, 0)| in increment 3: " << outcome.out;
}

TEST_F(StrainPost, NodesFromElsewhereGiveTheSameStrains) {
  const micro::FiberMesh mesh = LatticeYarns{.n_yarns = 3}.mesh();
  {
    Hdf5File nodes(folder_ / "nodes.h5");
    nodes.put("fibers/start", std::vector<int>(mesh.first_node.begin(), mesh.first_node.end()));
    for (const Index i : {0, 1}) {
      nodes.put("increments/" + std::to_string(i) + "/position", state(2 * i).r);
      write_vtp(folder_ / ("state" + std::to_string(2 * i) + ".vtp"),
                polylines(state(2 * i).r, mesh.first_node, {mesh.yarn_of_fiber.begin(), mesh.yarn_of_fiber.end()}));
    }
    nodes.put("fibers/yarn", std::vector<int>(mesh.yarn_of_fiber.begin(), mesh.yarn_of_fiber.end()));
  }
  ASSERT_EQ(post({path("states.h5"), "--to", "2", "--out", path("run")}).exit_code, 0);
  ASSERT_EQ(post({path("nodes.h5"), "--out", path("hdf5")}).exit_code, 0);
  ASSERT_EQ(post({path("state0.vtp"), path("state2.vtp"), "--to", "state2", "--out", path("vtp")}).exit_code, 0);
  const auto expected = read_csv(folder_ / "run/strains.csv");
  for (const char* other : {"hdf5", "vtp"}) {
    const auto rows = read_csv(folder_ / other / "strains.csv");
    ASSERT_EQ(rows.size(), 3u);
    for (int y = 0; y < 3; ++y) {
      EXPECT_EQ(rows[y].at("yarn"), "yarn/" + std::to_string(y));
      EXPECT_EQ(rows[y].at("n_tets"), expected[y].at("n_tets"));
      EXPECT_NEAR(std::stod(rows[y].at("E_axial_mean")), std::stod(expected[y].at("E_axial_mean")), 1e-9);
    }
  }
  const Outcome list = post({path("state0.vtp"), path("state2.vtp"), "--list"});
  EXPECT_NE(list.out.find("state2"), std::string::npos);
  EXPECT_EQ(list.out.find("contacts"), std::string::npos) << "nothing is known of them";
}

TEST_F(StrainPost, HelpTellsWhatItReadsAndItsExitCodes) {
  const Outcome outcome = post({"--help"});
  EXPECT_EQ(outcome.exit_code, 0);
  for (const char* part : {"--list", "delaunay|swept|both", ".vtp", "Exit codes"})
    EXPECT_NE(outcome.out.find(part), std::string::npos) << part;
}

}  // namespace
}  // namespace trame::test
