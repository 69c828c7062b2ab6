/// A number that stands in several places, the report, the tables, summary.json, the quantities of a study, is the same
/// number in all of them. One run of plain_small, with the density of its fibers, and what strain_post makes of its
/// states.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "micro/scene/scene.h"
#include "micro/states/snapshot.h"
#include "support/lattice_yarns.h"
#include "support/process.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"
#include "workflows/accuracy/quantity.h"

namespace trame::test {
namespace {

namespace fs = std::filesystem;
using Row = std::map<std::string, std::string>;

/// Fields of a line between commas, which may be in quotes.
std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields = {""};
  bool quoted = false;
  for (const char c : line)
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      fields.emplace_back();
    else
      fields.back() += c;
  return fields;
}

std::vector<Row> read_csv(const fs::path& file) {
  std::istringstream text(read_text(file));
  std::string line;
  std::getline(text, line);
  const std::vector<std::string> names = split(line);
  std::vector<Row> rows;
  while (std::getline(text, line)) {
    const std::vector<std::string> fields = split(line);
    EXPECT_EQ(fields.size(), names.size()) << line;
    Row& row = rows.emplace_back();
    for (std::size_t i = 0; i < std::min(names.size(), fields.size()); ++i) row[names[i]] = fields[i];
  }
  return rows;
}

double number(const Row& row, const char* column) { return std::stod(row.at(column)); }

/// Cells of the rows of a page's table whose heading is `heading`; a heading that stands in several tables gives a row
/// for each.
std::vector<std::vector<std::string>> rows_of(const std::string& html, const std::string& heading) {
  std::vector<std::vector<std::string>> rows;
  const std::string start = "<tr><th>" + heading + "</th>";
  for (std::size_t at = html.find(start); at != std::string::npos; at = html.find(start, at + 1)) {
    const std::string row = html.substr(at + start.size(), html.find("</tr>", at) - at - start.size());
    static const std::regex cell("<td>(.*?)</td>");
    auto& cells = rows.emplace_back();
    for (std::sregex_iterator match(row.begin(), row.end(), cell), end; match != end; ++match)
      cells.push_back((*match)[1]);
  }
  return rows;
}

/// Expects a text to be the number as that many decimals show it; a table has six digits of it.
void expect_shows(const std::string& text, double value, int decimals, const std::string& what) {
  if (std::isnan(value)) {
    EXPECT_EQ(text, "–") << what;
    return;
  }
  ASSERT_NE(text, "–") << what << ": " << value;
  EXPECT_NEAR(std::stod(text), value, 0.501 * std::pow(10, -decimals) + 1e-5 * std::abs(value)) << what;
}

/// Expects the number that a text begins with to be this one to three digits, or as many as are given.
void expect_begins(const std::string& text, double value, const std::string& what, int digits = 3) {
  ASSERT_FALSE(text.empty()) << what << ": " << value;
  EXPECT_NEAR(std::stod(text), value, 0.501 * std::pow(10, 1 - digits) * std::abs(value) + 1e-300) << what;
}

std::pair<std::string, std::string> arrow(const std::string& text) {
  const std::size_t at = text.find(" → ");
  EXPECT_NE(at, std::string::npos) << text;
  return {text.substr(0, at), text.substr(at + std::string(" → ").size())};
}

/// Where neither an X server nor gnuplot is found: numbers do not need the seconds that pictures take.
const std::vector<std::string> without_pictures = {"PATH=/nowhere", "DISPLAY="};

class SameNumbers : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    std::string scene = read_text(fs::path(TRAME_DATA_DIR) / "scenes/plain_small.toml");
    scene.insert(scene.find("poisson_ratio"), "density = \"1.14 g/cm3\"\n");
    std::ofstream(*folder_ / "plain_small.toml") << scene;
    const Outcome outcome =
        run(folder_->path(), {TRAME_RUN_WORKFLOW, "plain_small.toml", "--out", "run"}, without_pictures);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    told_ = outcome.out;
    const micro::SnapshotReader states(*folder_ / "run/states.h5");
    last_ = states.n_increments() - 1;
    const std::string stage = states.read(last_).stage;
    for (middle_ = last_; states.read(middle_).stage == stage;) --middle_;
    post("weave", 0, middle_);
    post("load", middle_, last_);
    post("whole", 0, last_);
    page_ = read_text(*folder_ / "run/report.html");
  }
  static void TearDownTestSuite() { delete folder_; }

  static void post(const std::string& name, Index from, Index to) {
    const Outcome outcome = run(
        folder_->path(),
        {TRAME_STRAIN_POST, "run/states.h5", "--from", std::to_string(from), "--to", std::to_string(to), "--out", name},
        without_pictures);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    told_by_post_[name] = outcome.out;
  }
  static std::vector<Row> table(const std::string& name, const char* file) { return read_csv(*folder_ / name / file); }
  /// The part of a report about a pair of states.
  static std::string chapter(const std::string& page, Index from, Index to) {
    const std::size_t at = page.find(fmt::format("State A is increment {}, state B increment {}.", from, to));
    EXPECT_NE(at, std::string::npos);
    return page.substr(at, page.find("</section>", at) - at);
  }
  /// The chapters of both reports about this pair: that of the run and that of strain_post.
  static std::vector<std::string> chapters(const std::string& name, Index from, Index to) {
    return {chapter(page_, from, to), chapter(read_text(*folder_ / name / "report.html"), from, to)};
  }
  struct Pair {
    const char* name;
    Index from, to;
  };
  static std::vector<Pair> pairs() { return {{"weave", 0, middle_}, {"load", middle_, last_}}; }

  static TemporaryFolder* folder_;
  static std::string page_, told_;  ///< report and terminal
  static std::map<std::string, std::string> told_by_post_;
  static Index middle_, last_;
};
TemporaryFolder* SameNumbers::folder_ = nullptr;
std::string SameNumbers::page_, SameNumbers::told_;
std::map<std::string, std::string> SameNumbers::told_by_post_;
Index SameNumbers::middle_ = 0, SameNumbers::last_ = 0;

/// Means of a column over the stations of a yarn.
double station_mean(const std::vector<Row>& sections, const std::string& yarn, const char* column) {
  double sum = 0, n = 0;
  for (const Row& row : sections)
    if (row.at("yarn") == yarn && row.at("place").empty()) {
      sum += number(row, column);
      ++n;
    }
  return sum / n;
}

TEST_F(SameNumbers, OfYarnsInReportsAndTables) {
  for (const auto& [name, from, to] : pairs()) {
    const std::vector<Row> strains = table(name, "strains.csv"), sections = table(name, "sections.csv");
    ASSERT_EQ(strains.size(), 4U);
    for (const std::string& html : chapters(name, from, to))
      for (const Row& row : strains) {
        const std::string& yarn = row.at("yarn");
        const auto rows = rows_of(html, yarn);
        ASSERT_GE(rows.size(), 2U) << yarn;  // sizes and strains; validity
        const std::vector<std::string>& cells = rows[0];
        ASSERT_EQ(cells.size(), 11U) << yarn;
        const auto mean = [&](const char* column) { return station_mean(sections, yarn, column); };
        const auto expect_change = [&](std::size_t cell, const char* a, const char* b, double unit) {
          const auto [in_a, in_b] = arrow(cells[cell]);
          expect_shows(in_a, unit * mean(a), 1, yarn + " " + a);
          expect_shows(in_b, unit * mean(b), 1, yarn + " " + b);
        };
        expect_change(0, "width_A_m", "width_B_m", 1e6);
        expect_change(1, "height_A_m", "height_B_m", 1e6);
        expect_change(2, "fill_A", "fill_B", 100);
        expect_shows(cells[4], 100 * number(row, "E_axial_mean"), 2, yarn);
        expect_shows(cells[5], 100 * number(row, "E_horizontal_mean"), 2, yarn);
        expect_shows(cells[6], 100 * number(row, "E_vertical_mean"), 2, yarn);
        expect_shows(cells[7], 100 * number(row, "gamma_max_mean"), 2, yarn);
        expect_shows(cells[8], 100 * mean("E_axial_side"), 2, yarn);
        expect_shows(cells[9], 100 * mean("E_axial_centre"), 2, yarn);
        const double side = mean("E_axial_side"), centre = mean("E_axial_centre");
        expect_shows(cells[10], std::abs(centre) > 0.01 * std::abs(side) ? side / centre : std::nan(""), 2, yarn);
      }
  }
}

TEST_F(SameNumbers, OfContinuaInReportsAndTables) {
  for (const auto& [name, from, to] : pairs())
    for (const std::string& html : chapters(name, from, to))
      for (const Row& row : table(name, "continuum.csv")) {
        const std::string& yarn = row.at("yarn");
        const auto rows = rows_of(html, yarn);
        const auto found = std::find_if(rows.begin(), rows.end(), [](const auto& cells) { return cells.size() == 6; });
        ASSERT_NE(found, rows.end()) << yarn;
        EXPECT_NE((*found)[0].find(row.at("verdict").substr(0, row.at("verdict").find(':'))), std::string::npos);
        expect_shows((*found)[1], number(row, "non_affine_95_d"), 2, yarn);
        expect_shows((*found)[2], number(row, "non_affine_share"), 2, yarn);
        expect_shows((*found)[3], 100 * number(row, "exchanged_neighbours"), 1, yarn);
        expect_shows((*found)[4], 100 * number(row, "inverted"), 1, yarn);
        expect_shows((*found)[5], 100 * number(row, "mesh_difference"), 1, yarn);
      }
}

/// Each band that a report lists is a line of bands.csv, and the counts are those of its lines: simple shear in the
/// middle rows of a yarn of 12 × 12 fibers.
TEST(SameNumbersOfBands, InReportAndTable) {
  const TemporaryFolder folder;
  const micro::test::LatticeYarns yarns{.n_rows = 12, .n_columns = 12, .n_elements = 6, .length = 12};
  {
    micro::SnapshotWriter writer(folder / "band.h5", {"1", "scene", "", yarns.mesh(), {}});
    micro::Increment increment;
    increment.fibers = yarns.configuration();
    writer.append(increment);
    const double middle = 5.5 * std::sqrt(0.75);
    for (Vec3& r : increment.fibers.r) r.y() += 0.3 * std::clamp(r.z() - middle, -1.3, 1.3);
    writer.append(increment);
  }
  ASSERT_EQ(run(folder.path(), {TRAME_STRAIN_POST, "band.h5", "--out", "out"}, without_pictures).exit_code, 0);
  const std::vector<Row> bands = read_csv(folder / "out/bands.csv");
  const std::string html = read_text(folder / "out/report.html");
  const std::map<std::string, std::string> components = {{"E<sub>axial</sub>", "E_axial"},
                                                         {"E<sub>horizontal</sub>", "E_horizontal"},
                                                         {"E<sub>vertical</sub>", "E_vertical"},
                                                         {"γ<sub>max</sub>", "gamma_max"}};
  std::map<std::string, int> listed;
  std::set<std::string> stations;
  for (const auto& cells : rows_of(html, "warp/1")) {
    if (cells.size() != 8) continue;
    const std::string station = cells[0].substr(0, cells[0].find(':')), component = components.at(cells[1]);
    const auto is_shown = [&](const Row& row) {
      const auto shows = [&](std::size_t cell, const char* column, double unit, int decimals) {
        const double value = unit * number(row, column);
        return std::abs(std::stod(cells[cell]) - value) <= 0.501 * std::pow(10, -decimals) + 1e-5 * std::abs(value);
      };
      return row.at("station") == station && row.at("component") == component && row.at("significant") == "1" &&
             shows(2, "angle_deg", 1, 0) && shows(3, "thickness_d", 1, 1) && shows(4, "length_d", 1, 1) &&
             shows(5, "aspect", 1, 1) && shows(6, "share_of_section", 100, 0) && shows(7, "p_value", 100, 1);
    };
    EXPECT_TRUE(std::any_of(bands.begin(), bands.end(), is_shown)) << cells[0] << " " << cells[1];
    ++listed[component];
    stations.insert(station);
  }
  EXPECT_EQ(stations, (std::set<std::string>{"1", "4", "7", "10"})) << "those that are shown";
  EXPECT_GE(listed["gamma_max"], 4);
  for (const auto& [shown, component] : components) {
    const std::regex line("<li>" + shown + ": ([0-9]+) bands, of these [0-9]+ with a direction, and ([0-9]+) other");
    std::smatch match;
    ASSERT_TRUE(std::regex_search(html, match, line)) << component;
    const auto count = [&](const char* significant) {
      return std::count_if(bands.begin(), bands.end(), [&](const Row& row) {
        return row.at("component") == component && row.at("significant") == significant &&
               stations.contains(row.at("station"));
      });
    };
    EXPECT_EQ(std::stol(match[1]), count("1")) << component;
    EXPECT_EQ(std::stol(match[2]), count("0")) << component;
  }
}

TEST_F(SameNumbers, OfYarnsInTheSummaryAndTables) {
  const nlohmann::json summary = nlohmann::json::parse(read_text(*folder_ / "run/summary.json"));
  const std::vector<Row> strains = table("whole", "strains.csv");
  ASSERT_EQ(summary["yarns"].size(), strains.size());
  for (std::size_t y = 0; y < strains.size(); ++y) {
    const nlohmann::json& yarn = summary["yarns"][y];
    EXPECT_EQ(yarn["name"], strains[y].at("yarn"));
    EXPECT_EQ(yarn["n_tets"], std::stol(strains[y].at("n_tets")));
    EXPECT_EQ(yarn["n_flagged"], std::stol(strains[y].at("n_flagged")));
    for (const char* column : {"E_axial_mean", "E_axial_min", "E_axial_max"})
      EXPECT_EQ(fmt::format("{:.9g}", yarn[column].get<double>()), strains[y].at(column)) << column;
  }
}

TEST_F(SameNumbers, OfCertificatesAndEnergiesInTheReportAndSummary) {
  const nlohmann::json summary = nlohmann::json::parse(read_text(*folder_ / "run/summary.json"));
  const nlohmann::json& energy = summary.at("energy");
  const auto found = [&](const char* certificate) {
    const auto rows = rows_of(page_, certificate);
    EXPECT_EQ(rows.size(), 1U) << certificate;
    return rows.at(0).at(0);
  };
  const double work = energy.at("external_work");
  expect_begins(found("Penetration"), 100 * summary.at("max_penetration_over_radius").get<double>(), "penetration", 2);
  expect_begins(found("Force imbalance"), 100 * summary.at("force_imbalance").get<double>(), "force", 2);
  expect_begins(found("Moment imbalance"), 100 * summary.at("moment_imbalance").get<double>(), "moment", 2);
  expect_begins(found("Energy balance"), 100 * energy.at("imbalance").get<double>() / std::abs(work), "balance", 2);
  EXPECT_EQ(found("Crossing order"),
            fmt::format("{} of {}", summary.at("n_crossings_ok").get<int>(), summary.at("n_crossings").get<int>()));
  const std::regex told(
      "against the external work, (\\S+) µJ[^.]*\\. (\\S+) µJ are stored, (\\S+) µJ rubbed off, (\\S+) µJ\\s+damped, "
      "(\\S+) µJ released");
  std::smatch match;
  ASSERT_TRUE(std::regex_search(page_, match, told));
  const std::array keys = {"external_work", "stored", "friction", "damping", "release"};
  for (std::size_t k = 0; k < keys.size(); ++k)
    expect_begins(match[k + 1], 1e6 * energy.at(keys[k]).get<double>(), keys[k]);
}

/// Shear zones are a line each in zones.csv, and a count with their share of the yarn in the terminal.
TEST_F(SameNumbers, OfZonesInTheTableAndTheTerminal) {
  for (const char* name : {"weave", "load", "whole"}) {
    const std::vector<Row> zones = table(name, "zones.csv");
    const std::string& told = told_by_post_.at(name);
    for (const Row& yarn : table(name, "strains.csv")) {
      int n = 0;
      double share = 0;
      for (const Row& zone : zones)
        if (zone.at("yarn") == yarn.at("yarn")) {
          ++n;
          share += 100 * number(zone, "volume_fraction");
        }
      const std::regex line(yarn.at("yarn") + " .* ([0-9]+) \\(([0-9.]+)\\)\n");
      std::smatch match;
      ASSERT_TRUE(std::regex_search(told, match, line)) << yarn.at("yarn") << " in\n" << told;
      EXPECT_EQ(std::stoi(match[1]), n) << yarn.at("yarn");
      EXPECT_NEAR(std::stod(match[2]), share, 0.051) << yarn.at("yarn");
    }
  }
}

/// Curves by direction in the order of a report: for each component one of the middle warp yarn, and of the weft yarn.
/// A curve without any value is left out.
TEST_F(SameNumbers, OfOrientationInReportsAndTables) {
  static const std::regex curve("<path d=\"M([^\"]*)Z\" fill=\"[^\"]*\" fill-opacity=\"0.2\"");
  static const std::regex point("(-?[0-9.]+) (-?[0-9.]+)");
  for (const auto& [name, from, to] : pairs()) {
    std::vector<std::vector<double>> expected;
    const std::vector<Row> rows = table(name, "orientation.csv");
    for (const char* component : {"E_axial", "E_horizontal", "E_vertical", "gamma_max"})
      for (const char* yarn : {"warp/2", "weft/2"})
        for (const Row& row : rows) {
          if (row.at("yarn") != yarn || row.at("component") != component) continue;
          std::vector<double> values;
          for (int angle = -75; angle <= 90; angle += 15)
            values.push_back(number(row, (std::to_string(angle) + "_deg").c_str()));
          if (std::any_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); }))
            expected.push_back(values);
        }
    for (const std::string& html : chapters(name, from, to)) {
      const std::size_t start = html.find("<h3>Directions in which the strain hangs together</h3>");
      ASSERT_EQ(start == std::string::npos, expected.empty());
      if (expected.empty()) continue;
      const std::string dials = html.substr(start);
      std::vector<std::vector<double>> radii;
      for (std::sregex_iterator match(dials.begin(), dials.end(), curve), end; match != end; ++match) {
        const std::string path = (*match)[1];
        auto& one = radii.emplace_back();
        for (std::sregex_iterator at(path.begin(), path.end(), point); at != end; ++at)
          one.push_back(std::hypot(std::stod((*at)[1]), std::stod((*at)[2])));
      }
      ASSERT_EQ(radii.size(), expected.size());
      double largest_radius = 0, largest_value = 0;
      for (std::size_t c = 0; c < radii.size(); ++c) {
        ASSERT_EQ(radii[c].size(), 2 * expected[c].size()) << "both ends of a direction";
        for (const double r : radii[c]) largest_radius = std::max(largest_radius, r);
        for (const double x : expected[c]) largest_value = std::max(largest_value, x);  // also where it is NaN
      }
      ASSERT_GT(largest_value, 0.2) << "else the scale is another one";
      for (std::size_t c = 0; c < radii.size(); ++c)
        for (std::size_t k = 0; k < radii[c].size(); ++k) {
          const double value = expected[c][k % expected[c].size()], shown = value > 0 ? value : 0;
          EXPECT_NEAR(radii[c][k] / largest_radius, shown / largest_value, 4e-3) << "curve " << c << ", point " << k;
        }
    }
  }
}

/// Expects each row of a report's table of branches to be a line of branches.csv. Returns how many there are, and how
/// many close a loop.
std::pair<int, int> expect_branches(const std::string& html, const std::vector<Row>& branches,
                                    const std::map<std::string, std::array<double, 4>>& factors) {
  int n = 0, n_loops = 0;
  for (const Row& row : branches) {
    const auto factor = factors.find(row.at("motion_unit") + " " + row.at("reaction_unit"));
    if (factor == factors.end()) continue;
    const auto& [motion, reaction, stiffness, work] = factor->second;
    for (const auto& cells : rows_of(html, row.at("curve"))) {
      if (cells.size() != 8 || cells[0] != row.at("stage") || cells[1] != row.at("branch")) continue;
      const std::string what = row.at("curve") + ", " + row.at("stage");
      const auto [from, to] = arrow(cells[2]);
      const auto [start, end] = arrow(cells[3]);
      const auto small = [](double x, double other) { return std::abs(x) <= 1e-6 * std::abs(other); };
      const auto expect_end = [&](const std::string& text, const char* own, const char* other, double unit) {
        const double value = number(row, own);
        expect_begins(text, small(value, number(row, other)) ? 0 : unit * value, what, 4);
      };
      expect_end(from, "start_motion", "end_motion", motion);
      expect_end(to, "end_motion", "start_motion", motion);
      expect_end(start, "start_reaction", "end_reaction", reaction);
      expect_end(end, "end_reaction", "start_reaction", reaction);
      expect_begins(cells[4], stiffness * number(row, "initial_stiffness"), what);
      expect_begins(cells[5], stiffness * number(row, "tangent_stiffness"), what);
      EXPECT_EQ(cells[6].empty(), row.at("work").empty());
      EXPECT_EQ(cells[7].empty(), row.at("loop_work").empty());
      if (!row.at("work").empty()) expect_begins(cells[6], work * number(row, "work"), what);
      if (!row.at("loop_work").empty()) expect_begins(cells[7], work * number(row, "loop_work"), what);
      n_loops += !row.at("loop_work").empty();
      ++n;
    }
  }
  return {n, n_loops};
}

TEST_F(SameNumbers, OfBranchesInTheReportAndTable) {
  const auto branches = read_csv(*folder_ / "run/branches.csv");
  EXPECT_EQ(expect_branches(page_, branches, {{"1 N/m", {100, 1, 1e-3, 1}}}), (std::pair{2, 0})) << "warp and weft";
}

/// A fiber that is pulled, and let go in steps of another size: the steps leave a loop.
TEST(SameNumbersOfBranches, OfALoopInTheReportAndTable) {
  const TemporaryFolder folder;
  std::ofstream(folder / "fiber.toml") << R"(title = "to and fro"
[material.m]
model = "isotropic"
young_modulus = "1 GPa"
poisson_ratio = 0
[fiber_type.f]
material = "m"
diameter = "20 um"
[[bundle]]
name = "b"
fiber_type = "f"
fibers = 3
points = [["0 mm", "0 mm", "0 mm"], ["1 mm", "0 mm", "0 mm"]]
elements = 4
[effects]
contact = "none"
[[body]]
name = "left"
[[body.tie]]
fibers = "b"
end = "start"
[[body]]
name = "right"
[[body.tie]]
fibers = "b"
end = "end"
[[stage]]
name = "pull"
increments = 2
[[stage.drive]]
bodies = "right"
dof = "x"
displacement = "100 um"
[[stage]]
name = "let go"
increments = 3
[[stage.drive]]
bodies = "right"
dof = "x"
displacement = "-90 um"
)";
  const Outcome outcome = run(folder.path(), {TRAME_RUN_WORKFLOW, "fiber.toml", "--out", "run"}, without_pictures);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto [n, n_loops] = expect_branches(read_text(folder / "run/report.html"),
                                            read_csv(folder / "run/branches.csv"), {{"m N", {1e6, 1e3, 1, 1e6}}});
  EXPECT_EQ(n, 2);
  EXPECT_EQ(n_loops, 1);
}

/// Facts of the fabric: in summary.json, at the head of the report, in the terminal, and in the report of strain_post.
TEST_F(SameNumbers, OfTheFabricInTheSummaryTheReportsAndTheTerminal) {
  struct Fact {
    const char *key, *name, *unit;
    double scale;
    int decimals;
  };
  const std::vector<Fact> of_fabric = {{"areal_density_kg_m2", "areal density", "g/m²", 1e3, 1},
                                       {"thickness_m", "thickness, crown to crown", "µm", 1e6, 1},
                                       {"outline_thickness_m", "thickness, with free edges", "µm", 1e6, 1},
                                       {"cover_factor", "cover factor, of widths", "%", 100, 1},
                                       {"projected_cover", "cover, projected", "%", 100, 1},
                                       {"volume_fraction", "fiber volume fraction", "%", 100, 1}};
  const std::vector<Fact> of_systems = {{"sett_per_m", "sett", "per cm", 1e-2, 2},
                                        {"linear_density_kg_m", "linear density of a yarn", "tex", 1e6, 3},
                                        {"crimp", "crimp", "%", 100, 2},
                                        {"take_up", "take-up", "%", 100, 2},
                                        {"width_m", "width of a yarn", "µm", 1e6, 1},
                                        {"height_m", "height of a yarn", "µm", 1e6, 1},
                                        {"cover", "cover", "%", 100, 1},
                                        {"areal_density_kg_m2", "areal density", "g/m²", 1e3, 1}};
  const nlohmann::json fabric = nlohmann::json::parse(read_text(*folder_ / "run/summary.json")).at("fabric");
  const std::string post = read_text(*folder_ / "load/report.html");
  const auto shown = [](const nlohmann::json& value, const Fact& fact) {
    return fmt::format("{:.{}f}", fact.scale * value.get<double>(), fact.decimals);
  };
  /// The row of a table in both reports, and the line of the terminal: name, unit, then these numbers.
  const auto expect_row = [&](const Fact& fact, const std::vector<std::string>& numbers, std::size_t of_pages) {
    for (const std::string* page : std::array<const std::string*, 2>{&page_, &post}) {
      const auto rows = rows_of(*page, fact.name);
      ASSERT_GT(rows.size(), of_pages) << fact.name;
      std::vector<std::string> cells = rows[of_pages];
      EXPECT_EQ(cells.front(), fact.unit);
      cells.erase(cells.begin());
      if (cells.front().empty()) cells.erase(cells.begin());
      EXPECT_EQ(cells, numbers) << fact.name;
      EXPECT_LT(page->find(fact.name), page->find("<nav>")) << "at the head";
    }
    const std::regex line(fmt::format("\n  {} +{} +{} *\n", fact.name, fact.unit, fmt::join(numbers, " +")));
    EXPECT_TRUE(std::regex_search(told_, line)) << fact.name << " in\n" << told_;
  };
  for (const Fact& fact : of_fabric) expect_row(fact, {shown(fabric.at(fact.key), fact)}, 0);
  for (const Fact& fact : of_systems) {
    std::vector<std::string> numbers;
    for (const char* system : {"warp", "weft"}) {
      const nlohmann::json& facts = fabric.at(system);
      numbers.push_back(shown(facts.at(fact.key), fact));
      const std::string deviation = std::string(fact.key) + "_deviation";
      if (facts.contains(deviation)) numbers.back() += " ± " + shown(facts.at(deviation), fact);
    }
    // "areal density" is a row of the fabric, too.
    expect_row(fact, numbers, std::string(fact.key) == "areal_density_kg_m2" ? 1 : 0);
  }
  EXPECT_GT(fabric.at("areal_density_kg_m2"), 0.01);
  EXPECT_GT(fabric.at("warp").at("crimp"), 0.001);
}

/// What a study measures of a run is what the run says of itself.
TEST_F(SameNumbers, OfQuantitiesInTheStudyTablesAndSummary) {
  const micro::SnapshotReader states(*folder_ / "run/states.h5");
  const micro::Scene scene = micro::parse_scene(states.header().scene_text, "states.h5");
  std::map<std::string, double> quantities;
  for (const workflows::Quantity& quantity : workflows::read_quantities(scene, *folder_ / "run"))
    quantities[quantity.name] = quantity.value;
  const nlohmann::json summary = nlohmann::json::parse(read_text(*folder_ / "run/summary.json"));
  EXPECT_EQ(quantities.at("stored_energy_J"), summary["energy"]["stored"].get<double>());
  EXPECT_EQ(quantities.at("friction_energy_J"), summary["energy"]["friction"].get<double>());
  EXPECT_EQ(quantities.at("thickness_m"), summary["fabric"]["thickness_m"].get<double>());
  const std::vector<Row> curves = read_csv(*folder_ / "run/curves.csv"), sections = table("load", "sections.csv");
  for (const std::string family : {"warp", "weft"}) {
    EXPECT_EQ(quantities.at(family + "_crimp"), summary["fabric"][family]["crimp"].get<double>());
    EXPECT_NEAR(quantities.at(family + "_force_at_2%_N"), number(curves.back(), (family + "_force_N").c_str()), 1e-9);
    double side = 0, centre = 0;
    for (const char* yarn : {"/1", "/2"}) {
      side += station_mean(sections, family + yarn, "E_axial_side");
      centre += station_mean(sections, family + yarn, "E_axial_centre");
    }
    EXPECT_NEAR(quantities.at(family + "_side_to_centre"), side / centre, 1e-5);
  }
}

}  // namespace
}  // namespace trame::test
