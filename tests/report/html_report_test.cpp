/// report.html: what it says of known states, and that a browser shows all of it.

#include "workflows/report/html_report.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "meso/comparison.h"
#include "support/lattice_yarns.h"
#include "support/process.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"
#include "workflows/report/html.h"
#include "workflows/report/report_data.h"
#include "workflows/report/report_plots.h"
#include "workflows/report/run_facts.h"
#include "workflows/report/scene_settings.h"
#include "workflows/report/section_drawings.h"

namespace trame::workflows {
namespace {

using micro::test::input_error;
using micro::test::LatticeYarns;
using micro::test::mapped;
using test::read_text;
using test::write_text;
using trame::test::TemporaryFolder;

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

bool is_installed(const std::string& program) {
  return std::system(("command -v " + program + " > /dev/null 2>&1").c_str()) == 0;
}

/// Two straight yarns, a warp and a weft beside each other, that are stretched by 2 % and flattened by 4 %.
class HtmlReport : public ::testing::Test {
 protected:
  static inline const Vec3 stretch{1.02, 1.0, 0.96};

  /// Writes the states and returns their file.
  static std::filesystem::path saved(const std::filesystem::path& file) {
    const LatticeYarns yarns{
        .n_yarns = 2, .n_rows = 4, .n_columns = 6, .spacing = 2e-5, .length = 4e-4, .radius = 9.5e-6};
    micro::SnapshotWriter writer(file, {.version = "0.1.0",
                                        .scene_name = "lattice",
                                        .scene_text = "title = \"a < b\"",
                                        .mesh = yarns.mesh(),
                                        .body_names = {}});
    micro::Increment increment;
    increment.stage = "start";
    increment.fibers = yarns.configuration();
    writer.append(increment);
    increment.stage = "pull";
    increment.stage_time = 1;
    increment.fibers = mapped(yarns.configuration(), stretch.asDiagonal());
    increment.solver.max_penetration_over_radius = 0.03;
    increment.solver.proximal = 0.25;
    writer.append(increment);
    return file;
  }

  /// Of the pairs in `pairs_`, with the yarns of `input_`.
  std::string write() {
    const meso::YarnComparer comparer(states_, {.yarns = input_.yarns});
    std::vector<meso::Comparison> comparisons;
    for (const meso::StatePair& pair : pairs_) comparisons.push_back(comparer.compare(pair));
    input_.comparisons.clear();
    for (const meso::Comparison& comparison : comparisons) input_.comparisons.push_back(&comparison);
    return write_report(input_);
  }

  /// The report of all there is.
  [[nodiscard]] std::string report() {
    write_text(folder_ / "curves.csv",
               "stage,stage_time,warp_strain,weft_strain,warp_force_N,weft_force_N\n"
               "\"a, b\",0,0,0,0,0\n\"a, b\",0.5,0.01,0,0.002,0.001\n\"a, b\",1,0.02,0,0.006,0.002\n");
    write_text(folder_ / "summary.json",
               R"({"n_crossings": 4, "n_crossings_ok": 3, "seconds": {"solve": 3, "io": 1, "total": 4}})");
    input_.summary = folder_ / "summary.json";
    input_.curves = folder_ / "curves.csv";
    (void)write();
    return read_text(input_.file);
  }

  TemporaryFolder folder_;
  meso::RunStates states_{saved(folder_ / "states.h5")};
  std::vector<meso::StatePair> pairs_ = {{0, 1}};
  ReportInput input_{.states = states_, .comparisons = {}, .file = folder_ / "report.html", .draw_patch = false};
};

TEST_F(HtmlReport, ShowsStrainsAndSizesOfAnAffineStretch) {
  const std::string html = report();
  // Green-Lagrange: (1.02² − 1) / 2 = 2.02 %, 0 and (0.96² − 1) / 2 = −3.92 %; γ_max is the difference of the outer
  // two. Fibers at the sides are stretched as much as those in the centre.
  EXPECT_EQ(count(html, "<td>2.02</td><td>0.00</td><td>-3.92</td><td>5.94</td><td>2.02</td><td>2.02</td><td>1.00</td>"),
            2U)
      << "of both yarns";
  // Four rows 20 µm · √3/2 apart and a diameter of 19 µm, whose centres come nearer by 4 %; the sections do too.
  EXPECT_EQ(count(html, "<td>71.0 → 68.1</td>"), 2U) << "height of both yarns";
  EXPECT_EQ(count(html, "badge good\">" + escaped(text(meso::ContinuumVerdict::holds))), 2U) << "an affine map";
}

TEST_F(HtmlReport, ShowsCertificatesAndTimes) {
  const std::string html = report();
  EXPECT_TRUE(holds(html, "<td>3 of 4</td><td>all</td><td><span class=\"badge fair\">")) << "a crossing is wrong";
  EXPECT_TRUE(holds(html, "<td>3 % of R</td><td>≤ 5 % of R</td><td><span class=\"badge good\">"));
  EXPECT_TRUE(holds(html, "<td>0.25</td><td>0</td><td><span class=\"badge fair\">")) << "damped: not an equilibrium";
  EXPECT_TRUE(holds(html, ">solve 75 %<"));
  EXPECT_TRUE(holds(html, ">io 25 %<"));
}

TEST_F(HtmlReport, EscapesTextsOfTheScene) {
  const std::string html = report();
  EXPECT_TRUE(holds(html, "<pre>title = &quot;a &lt; b&quot;</pre>"));
  EXPECT_FALSE(holds(html, "a < b"));
}

TEST_F(HtmlReport, NeedsNothingButItself) {
  const std::string html = report();
  EXPECT_FALSE(holds(html, "<script"));
  EXPECT_FALSE(holds(html, "<link"));
  EXPECT_FALSE(std::regex_search(html, std::regex("(src|href)=\"(?!data:|#)"))) << "every source is inside";
}

TEST_F(HtmlReport, SaysWhatIsMissing) {
  EXPECT_EQ(write(), "") << "nothing that was asked for";
  const std::string html = read_text(input_.file);
  EXPECT_TRUE(holds(html, "There are no pictures of the patch"));
  EXPECT_TRUE(holds(html, "not known")) << "crossing order";
  EXPECT_FALSE(holds(html, "Curves of what is driven"));
}

TEST_F(HtmlReport, ShowsCurvesOfTheSidesWithTheirStiffness) {
  const std::string html = report();
  EXPECT_TRUE(holds(html,
                    "<td>a, b</td><td>loading</td><td>0 → 2 %</td><td>0 → 0.006 N</td><td>0.0002 kN</td>"
                    "<td>0.0004 kN</td><td>5e-05 N</td>"))
      << "0.002 N and 0.004 N per percent; without a scene nothing is known of widths";
  EXPECT_TRUE(holds(html, "weft sides, over the warp strain"));
  EXPECT_EQ(holds(html, "alt=\"force on a side (N) over strain of the sides (%)\""), is_installed("gnuplot"));
}

TEST_F(HtmlReport, ComparesAStateWithItself) {
  pairs_ = {{0, 0}};
  (void)write();
  EXPECT_TRUE(holds(read_text(input_.file), "<td>71.0 → 71.0</td>"));
}

TEST_F(HtmlReport, RefusesWhatThereIsNot) {
  const auto error_of = [&] { return input_error([&] { (void)write(); }); };
  pairs_ = {{0, 1}, {1, 2}};
  EXPECT_TRUE(holds(error_of(), "state B = 2: allowed are 0 … 1"));
  pairs_.clear();
  EXPECT_TRUE(holds(error_of(), "no pair of states"));
  pairs_ = {{0, 1}};
  input_.yarns = {"warp/7"};
  EXPECT_TRUE(holds(error_of(), "warp/7"));
  input_.yarns = {};
  input_.summary = folder_ / "none.json";
  EXPECT_TRUE(holds(error_of(), "none.json: cannot be read"));
  write_text(input_.summary, "[1");
  EXPECT_TRUE(holds(error_of(), "none.json: not the summary of a run"));
  input_.summary.clear();
  input_.curves = folder_ / "bad.csv";
  write_text(input_.curves, "stage\npull,1\n");
  EXPECT_TRUE(holds(error_of(), "bad.csv: not curves of a run: its columns must begin with stage,stage_time"));
  write_text(input_.curves, "stage,stage_time,warp_strain\npull,1\n");
  EXPECT_TRUE(holds(error_of(), "bad.csv, line 2"));
  input_.curves.clear();
  EXPECT_FALSE(std::filesystem::exists(input_.file)) << "nothing is left behind";
  input_.file = folder_ / "none" / "report.html";
  try {
    (void)write();
    FAIL() << "must not be written";
  } catch (const WriteError& error) {
    EXPECT_TRUE(holds(error.what(), "report.html: cannot be written"));
  }
}

TEST_F(HtmlReport, TellsEachPairOfStatesByItself) {
  pairs_ = {{0, 1}, {1, 0}};
  (void)write();
  const std::string html = read_text(input_.file);
  EXPECT_EQ(count(html, "<td>71.0 → 68.1</td>"), 2U);
  EXPECT_EQ(count(html, "<td>68.1 → 71.0</td>"), 2U);
  for (int i = 1; holds(html, fmt::format("href=\"#part-{}\"", i)); ++i)
    EXPECT_EQ(count(html, fmt::format("<section id=\"part-{}\">", i)), 1U) << "the list of contents leads there";
}

TEST(RunThatHasNotReachedItsEnd, IsToldWithItsPlace) {
  const std::string scene = R"([material.m]
model = "isotropic"
young_modulus = "1 GPa"
poisson_ratio = 0
[fiber_type.f]
material = "m"
diameter = "20 um"
[[fiber]]
name = "a"
fiber_type = "f"
points = [["0 mm", "0 mm", "0 mm"], ["1 mm", "0 mm", "0 mm"]]
elements = 2
[effects]
contact = "none"
[[stage]]
name = "pull"
[[stage]]
name = "let go"
)";
  micro::SnapshotHeader header{
      .version = "0.1.0", .scene_name = "s", .scene_text = scene, .mesh = {}, .body_names = {}};
  const auto told = [&](const std::string& stage, double time) {
    micro::Increment last;
    last.stage = stage;
    last.stage_time = time;
    return what_is_missing(scene_of(header), last);
  };
  EXPECT_TRUE(holds(told("pull", 0.4), "at 40 % of stage pull, with 1 of 2 stages not begun"));
  EXPECT_TRUE(holds(told("pull", 1), "with 1 of 2 stages not begun"));
  EXPECT_TRUE(holds(told("let go", 0.5), "at 50 % of stage let go, and"));
  EXPECT_EQ(told("let go", 1), "");
  header.version.clear();
  EXPECT_EQ(told("pull", 0.4), "") << "states from elsewhere have no end to reach";
}

/// Two single fibers, one of them tied to a body that is pulled by 20 µm with 3 mN, and the other one longer.
class ReportOfFibers : public ::testing::Test {
 protected:
  static micro::SnapshotHeader header() {
    LatticeYarns yarns{.n_yarns = 2, .n_rows = 1, .n_columns = 1, .spacing = 2e-5, .length = 1e-3, .radius = 1e-5};
    micro::SnapshotHeader header{"0.1.0", "fibers", "", yarns.mesh(), {"clamp", "pull_er\n'"}};
    for (micro::Yarn& yarn : header.mesh.yarns) yarn.family = micro::YarnFamily::free;
    return header;
  }
  static std::filesystem::path saved(const std::filesystem::path& file) {
    const LatticeYarns yarns{
        .n_yarns = 2, .n_rows = 1, .n_columns = 1, .spacing = 2e-5, .length = 1e-3, .radius = 1e-5};
    micro::SnapshotWriter writer(file, header());
    for (const double t : {0.0, 0.5, 1.0}) {
      micro::Increment state;
      state.stage = "pull";
      state.stage_time = t;
      state.fibers = mapped(yarns.configuration(), Vec3(1 + 0.02 * t, 1, 1).asDiagonal());
      state.bodies.position = {Vec3::Zero(), Vec3(1e-3 + 2e-5 * t, 0, 0)};
      state.bodies.rotation = {Mat3::Identity(), Eigen::AngleAxisd(t, Vec3::UnitX()).toRotationMatrix()};
      state.bodies.force = {Vec3(-3e-3 * t, 0, 0), Vec3(3e-3 * t, 1e-12, 0)};
      state.bodies.moment = {Vec3::Zero(), Vec3(5e-9 * t, 0, 0)};
      state.bodies.motion = {Vec3::Zero(), Vec3(2e-5 * t, 0, 0)};
      state.bodies.turn = {Vec3::Zero(), Vec3(t, 0, 0)};
      writer.append(state);
    }
    return file;
  }

  TemporaryFolder folder_;
  meso::RunStates states_{saved(folder_ / "states.h5")};
  std::filesystem::path file_ = folder_ / "report.html";
};

TEST_F(ReportOfFibers, TellsOfBodiesAndElongationsInsteadOfYarns) {
  const meso::YarnComparer comparer(states_);
  const meso::Comparison comparison = comparer.compare({0, 2});
  (void)write_report({.states = states_, .comparisons = {&comparison}, .file = file_, .draw_patch = false});
  const std::string html = read_text(file_);
  EXPECT_TRUE(holds(html, "There are no pictures of the fibers"));
  EXPECT_TRUE(holds(html, "<td>(20, 0, 0)</td><td>57.3</td><td>(3, 0, 0)</td><td>(5, 0, 0)</td>"))
      << "1 rad; no round-off";
  EXPECT_EQ(count(html, "<td>2.000</td><td>2.000</td><td>2.000</td>"), 2U) << "both fibers are 2 % longer";
  EXPECT_EQ(holds(html, "alt=\"force along the axis (mN) over motion of the body (µm)\""), is_installed("gnuplot"))
      << "whatever their names";
  EXPECT_TRUE(holds(html, "<td>0 → 20 µm</td><td>0 → 3 mN</td><td>150 N/m</td><td>150 N/m</td><td>0.03 µJ</td>"));
  EXPECT_TRUE(holds(html, "<td>0 → 57.3 °</td><td>0 → 0.005 µN m</td>"));
  for (const char* absent : {"Crossing order", "Sections of yarns", "Shear bands", "weaving", "loom"})
    EXPECT_FALSE(holds(html, absent)) << absent;
}

TEST_F(ReportOfFibers, BeginsWithTheWarnings) {
  const meso::YarnComparer comparer(states_);
  const meso::Comparison comparison = comparer.compare({0, 2});
  write_text(folder_ / "summary.json",
             R"({"status": "gave_up", "message": "stage <b>", "warnings": ["it is unstable", "fibers lie deep"]})");
  (void)write_report({.states = states_,
                      .comparisons = {&comparison},
                      .file = file_,
                      .summary = folder_ / "summary.json",
                      .draw_patch = false});
  const std::string html = read_text(file_);
  const std::string::size_type contents = html.find("<nav>");
  for (const char* text : {"<b>Warning:</b> the solver gave up: stage &lt;b&gt;.", "<b>Warning:</b> it is unstable.",
                           "<b>Warning:</b> fibers lie deep."})
    EXPECT_LT(html.find(text), contents) << text;

  write_text(folder_ / "summary.json", R"({"status": "done", "message": "", "warnings": []})");
  (void)write_report({.states = states_,
                      .comparisons = {&comparison},
                      .file = file_,
                      .summary = folder_ / "summary.json",
                      .draw_patch = false});
  EXPECT_FALSE(holds(read_text(file_), "Warning"));
}

TEST_F(ReportOfFibers, OfStatesWithoutYarnsIsRefused) {
  micro::SnapshotHeader none{"0.1.0", "none", "", {}, {}};
  {
    micro::SnapshotWriter writer(folder_ / "none.h5", none);
    writer.append({});
  }
  const meso::RunStates states(folder_ / "none.h5");
  EXPECT_TRUE(holds(input_error([&] { (void)write_report({.states = states, .comparisons = {}, .file = file_}); }),
                    "none.h5: holds no yarn"));
}

/// States that have nothing but the names of their stages.
class NamedStages : public meso::FiberStates {
 public:
  explicit NamedStages(std::vector<std::string> stages) : stages_(std::move(stages)) {}
  [[nodiscard]] std::string name() const override { return "stages"; }
  [[nodiscard]] const micro::SnapshotHeader& header() const override { return header_; }
  [[nodiscard]] Index n_increments() const override { return static_cast<Index>(stages_.size()); }
  [[nodiscard]] micro::Increment read(Index i) const override {
    micro::Increment state;
    state.stage = stages_[i];
    return state;
  }

 private:
  std::vector<std::string> stages_;
  micro::SnapshotHeader header_;
};

TEST(PairsOfRun, PartTheLastStageFromWhatLedToIt) {
  using Pairs = std::vector<std::pair<Index, Index>>;
  const auto pairs = [](const std::vector<std::string>& stages) {
    Pairs result;
    for (const meso::StatePair& pair : pairs_of_run(NamedStages(stages))) result.emplace_back(pair.from, pair.to);
    return result;
  };
  EXPECT_EQ(pairs({"start", "weave", "weave", "load", "load"}), (Pairs{{0, 2}, {2, 4}}));
  EXPECT_EQ(pairs({"start", "load", "load"}), (Pairs{{0, 2}})) << "one stage";
  EXPECT_EQ(pairs({"load", "load"}), (Pairs{{0, 1}})) << "a reference that has the stage's name";
  EXPECT_EQ(pairs({"start"}), (Pairs{{0, 0}})) << "nothing but the reference";
}

TEST(Certificates, AreHeldAgainstTheScene) {
  micro::SnapshotHeader header;
  header.version = "0.1.0";
  header.scene_text = R"(
[material.m]
model = "isotropic"
young_modulus = "3 GPa"
poisson_ratio = 0.3
[fiber_type.f]
material = "m"
diameter = "19 um"
[[bundle]]
name = "b"
fiber_type = "f"
points = [["0 mm", "0 mm", "0 mm"], ["1 mm", "0 mm", "0 mm"]]
fibers = 3
elements = 4
[contact]
target_penetration = 0.08
[solver]
force_tolerance = 1e-5
[[stage]]
name = "s"
)";
  micro::Increment state;
  state.solver.max_penetration_over_radius = 0.07;
  state.solver.force_imbalance = 2e-3;
  const std::string html = certificates_html({}, scene_of(header), state, {});
  EXPECT_TRUE(holds(html, "<td>7 % of R</td><td>≤ 8 % of R</td><td><span class=\"badge good\">")) << html;
  EXPECT_TRUE(holds(html, "<td>0.2 %</td><td>≤ 0.1 %</td><td><span class=\"badge fair\">")) << html;
  EXPECT_TRUE(holds(certificates_html({}, {}, state, {}), "<td>≤ 5 % of R</td>")) << "without a scene";
}

TEST_F(HtmlReport, SaysWhyThePatchIsMissing) {
  const char* path = std::getenv("PATH");
  const std::string before = path == nullptr ? "" : path;
  unsetenv("DISPLAY");
  setenv("PATH", folder_.path().c_str(), 1);  // without xvfb-run
  input_.draw_patch = true;
  const std::string lacks = write();
  setenv("PATH", before.c_str(), 1);
  EXPECT_TRUE(holds(lacks, "xvfb-run")) << lacks;
  EXPECT_TRUE(holds(read_text(input_.file), "There are no pictures of the patch: no X server answers"));
}

/// A script, only here, writes down what the browser made of the page with all there can be in it.
TEST_F(HtmlReport, LoadsAllPicturesInABrowser) {
  if (!is_installed("chromium")) GTEST_SKIP() << "chromium is not installed: apt-get install chromium";
  unsetenv("DISPLAY");
  input_.draw_patch = is_installed("xvfb-run");
  std::string html = report();
  const std::string probe =
      "<p id=\"probe\"></p><script>window.onload = () => { const all = [...document.images];"
      "document.getElementById('probe').textContent = 'images ' + all.length + ', loaded ' +"
      "all.filter(i => i.complete && i.naturalWidth > 0).length + ', drawings ' +"
      "[...document.querySelectorAll('svg')].filter(s => s.getBoundingClientRect().width > 0).length + '.'; };"
      "</script>";
  const std::size_t end = html.rfind("</body>");
  ASSERT_NE(end, std::string::npos);
  write_text(folder_ / "probed.html", html.insert(end, probe));
  const test::Outcome outcome =
      test::run(folder_.path(),
                {"chromium", "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom",
                 "--user-data-dir=" + (folder_ / "profile").string(), "file://" + (folder_ / "probed.html").string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  // Curves and histograms; the patch in two states, in perspective, from above, and cut open.
  const int n_pictures = (is_installed("gnuplot") ? 2 : 0) + (input_.draw_patch ? 6 : 0);
  EXPECT_TRUE(holds(outcome.out, fmt::format("images {0}, loaded {0}, drawings {1}.", n_pictures, count(html, "<svg"))))
      << outcome.err;
}

TEST(StrainMap, EnclosesBandsBySolidOrDottedLines) {
  meso::YarnCut cut;
  cut.pixel = 1e-6;
  cut.inside = meso::Mask::Constant(3, 3, true);
  const meso::Picture values = meso::Picture::Constant(3, 3, 0.1);
  meso::SectionBands bands;
  bands.cut = std::make_shared<const meso::YarnCut>(cut);
  bands.bands = {{.significant = true}, {.significant = false}};
  bands.region = Eigen::ArrayXX<Index>::Zero(3, 3);
  bands.region(1, 1) = 1;                       // one pixel: four sides
  bands.region(2, 0) = bands.region(2, 1) = 2;  // two pixels: six
  const Window window{.low = {-1e-6, -1e-6}, .high = {3e-6, 3e-6}, .pixels = 100};
  const std::string svg = strain_map_svg(cut, values, {ColourMap::sequential, 0, 0.2}, meso::Section(), window, bands);
  const std::size_t rim = svg.find("<g stroke=\"#fff\""), line = svg.find("<g stroke=\"#111\"", rim);
  const std::size_t dashed = svg.find("stroke-dasharray", line);
  ASSERT_NE(dashed, std::string::npos);
  EXPECT_EQ(count(svg.substr(line, dashed - line), "L"), 4U);
  EXPECT_EQ(count(svg.substr(dashed), "L"), 6U);
  EXPECT_EQ(count(svg.substr(rim, line - rim), "L"), 10U) << "both have a rim";
  EXPECT_EQ(count(svg, "<path fill="), 1U) << "one shade";
}

TEST(Base64, AgreesWithTheExamplesOfRfc4648) {
  for (const auto& [bytes, expected] : {std::pair{"", ""},
                                        {"f", "Zg=="},
                                        {"fo", "Zm8="},
                                        {"foo", "Zm9v"},
                                        {"foob", "Zm9vYg=="},
                                        {"fooba", "Zm9vYmE="},
                                        {"foobar", "Zm9vYmFy"}})
    EXPECT_EQ(base64(bytes), expected);
  EXPECT_EQ(base64("\xff\xfe\xfd"), "//79");
}

TEST(ColourScale, HasZeroInTheMiddleWhereThereAreSigns) {
  const ColourScale both = scale_for({-0.3, 0.1, std::nan("")}, ColourMap::diverging);
  EXPECT_EQ(both.low, -both.high);
  EXPECT_EQ(colour(ColourMap::diverging, 0.5), "#dddddd") << "no strain is grey";
  EXPECT_EQ(scale_for({0.1, 0.2}, ColourMap::sequential).low, 0);
}

TEST(DirectionCurves, ReachOutAlongTheirLargestValues) {
  DirectionCurve curve{"#123456", {}};
  EXPECT_EQ(count(direction_curves_svg({curve}, 0.5, 0.05), "<path"), 1U);
  curve.values[8] = 0.5;  // −75° + 8 · 15° = 45°: up and to the right, y down, and opposite
  const std::string svg = direction_curves_svg({curve}, 0.5, 0.05);
  EXPECT_TRUE(holds(svg, "L63.6 -63.6")) << svg;
  EXPECT_TRUE(holds(svg, "L-63.6 63.6")) << svg;
  curve.values[0] = std::nan("");
  EXPECT_EQ(direction_curves_svg({curve}, 0.5, 0.05), svg) << "a thin yarn has no pairs of places one above the other";
  curve.values.fill(std::nan(""));
  EXPECT_EQ(direction_curves_svg({curve}, 0.5, 0.05), "");
}

TEST(Rose, PointsWhereTheBandsDo) {
  EXPECT_TRUE(rose_svg({}).empty());
  // One sector and its opposite for one direction; −90° and 90° are the same.
  EXPECT_EQ(count(rose_svg({{.angle = 45, .area = 3}}), "<path"), 2U);
  EXPECT_EQ(count(rose_svg({{.angle = 90, .area = 3}, {.angle = -89, .area = 1}}), "<path"), 2U);
  EXPECT_EQ(count(rose_svg({{.angle = 45, .area = 3}, {.angle = -45, .area = 3}}), "<path"), 4U);
}

}  // namespace
}  // namespace trame::workflows
