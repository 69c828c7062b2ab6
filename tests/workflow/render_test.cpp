/// render_patch: shapes of tubes and cuts, the frame, and the pictures themselves where an X server can be had.

#include <gtest/gtest.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "support/lattice_yarns.h"
#include "support/plain_cell_states.h"
#include "support/process.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"
#include "workflows/picture/continued_cell.h"
#include "workflows/picture/patch_shapes.h"
#include "workflows/picture/picture_frame.h"

namespace trame::workflows {
namespace {

using micro::test::input_error;
using micro::test::LatticeYarns;
using micro::test::mapped;
using test::Outcome;
using trame::test::TemporaryFolder;

double total_area(vtkPolyData* triangles) {
  double area = 0;
  for (vtkIdType i = 0; i < triangles->GetNumberOfCells(); ++i) {
    vtkNew<vtkIdList> ids;
    triangles->GetCellPoints(i, ids);
    EXPECT_EQ(ids->GetNumberOfIds(), 3);
    std::array<Vec3, 3> corner;
    for (int c = 0; c < 3; ++c) corner[c] = Vec3(triangles->GetPoint(ids->GetId(c)));
    area += 0.5 * (corner[1] - corner[0]).cross(corner[2] - corner[0]).norm();
  }
  return area;
}

/// Area of the circle of that radius, m, in µm²; tubes are polygons that lose less than 2 % of it.
double circle(double radius) { return M_PI * radius * radius / (micrometre * micrometre); }

TEST(CutPatch, SectionsOfStraightFibersAreCircles) {
  const LatticeYarns yarns;
  const CutPatch cut = cut_patch(yarns.mesh(), yarns.configuration(), {0, 5.0});
  const double expected = yarns.n_fibers_per_yarn() * circle(yarns.radius);
  EXPECT_LT(total_area(cut.faces), expected);
  EXPECT_GT(total_area(cut.faces), 0.98 * expected);
  EXPECT_EQ(cut.outlines->GetNumberOfLines(), yarns.n_fibers_per_yarn());
}

TEST(CutPatch, SectionsOfInclinedFibersAreEllipses) {
  const LatticeYarns yarns;
  const Mat3 turn = Eigen::AngleAxisd(M_PI / 3, Vec3::UnitZ()).toRotationMatrix();  // fibers at 60 degrees to x
  const CutPatch cut = cut_patch(yarns.mesh(), mapped(yarns.configuration(), turn), {0, 1.0});
  const double expected = yarns.n_fibers_per_yarn() * circle(yarns.radius) / std::cos(M_PI / 3);
  EXPECT_NEAR(total_area(cut.faces), expected, 0.02 * expected);
}

TEST(CutPatch, LeavesTheHalfThatIsLookedAt) {
  const LatticeYarns yarns;
  const CutPatch at_x = cut_patch(yarns.mesh(), yarns.configuration(), {0, 3.0});
  EXPECT_NEAR(at_x.behind->GetBounds()[0], 0, 1);  // µm
  EXPECT_NEAR(at_x.behind->GetBounds()[1], 3.0 / micrometre, 1);
  const CutPatch at_y = cut_patch(yarns.mesh(), yarns.configuration(), {1, 2.0});
  EXPECT_NEAR(at_y.behind->GetBounds()[2], 2.0 / micrometre, 1);
}

TEST(CutPatch, IsAnErrorWhereNoFiberIs) {
  const LatticeYarns yarns;
  const std::string error = input_error([&] { (void)cut_patch(yarns.mesh(), yarns.configuration(), {0, 11.0}); });
  EXPECT_NE(error.find("--at x=1.1e+07um: cuts no fiber"), std::string::npos) << error;
}

TEST(FiberColours, TellFamiliesAndNeighboursApart) {
  const LatticeYarns yarns{.n_yarns = 4};
  const std::vector<Vec3> colours = fiber_colours(yarns.mesh());
  const Index n = yarns.n_fibers_per_yarn();
  for (Index f = 0; f < n; ++f) {
    EXPECT_GT(colours[f].z(), colours[f].x());                 // warp: more blue than red
    EXPECT_GT(colours[n + f].x(), colours[n + f].z());         // weft: the other way round
    EXPECT_GT((colours[f] - colours[2 * n + f]).norm(), 0.1);  // neighbouring warp yarns
  }
  for (Index f = 1; f < n; ++f) EXPECT_GT((colours[f] - colours[f - 1]).norm(), 0.02);
}

ContinuedCell continued(const micro::test::PlainCell& cell, const micro::Copies& copies) {
  return continued_cell(cell.header().mesh, cell.state().fibers, cell.periods, copies);
}

TEST(ContinuedCell, HasFibersWithoutSeams) {
  const auto cell = micro::test::sheared_cell();
  const auto [mesh, fibers] = continued(cell, {2, 3});
  ASSERT_EQ(mesh.n_fibers(), 3 * 2 + 2 * 2);
  for (Index f = 0; f < mesh.n_fibers(); ++f) {
    const bool is_warp = mesh.yarns[mesh.yarn_of_fiber[f]].family == micro::YarnFamily::warp;
    const Index n = is_warp ? 2 : 3, first = mesh.first_node[f], last = mesh.first_node[f + 1] - 1;
    EXPECT_EQ(mesh.n_nodes(f), n * 2 * cell.n_elements + 1);
    EXPECT_LT((fibers.r[last] - fibers.r[first] - n * *cell.periods[is_warp ? 0 : 1]).norm(), 1e-18);
    EXPECT_NEAR(mesh.arc_length[last], n * 400e-6, 1e-15);
    for (Index i = first; i < last; ++i) {
      EXPECT_GT(mesh.arc_length[i + 1], mesh.arc_length[i]);
      EXPECT_LT((fibers.r[i + 1] - fibers.r[i]).norm(), 40e-6);
    }
  }
}

TEST(ContinuedCell, OfAStripHasEndsAcross) {
  const auto [mesh, fibers] = continued(micro::test::strip(), {3, 1});
  ASSERT_EQ(mesh.n_fibers(), 2 + 3 * 2);
  const auto [low, high] =
      std::minmax_element(fibers.r.begin(), fibers.r.end(), [](const Vec3& p, const Vec3& q) { return p.x() < q.x(); });
  EXPECT_NEAR(low->x(), -600e-6, 1e-15);  // the cell is the middle one
  EXPECT_NEAR(high->x(), 600e-6, 1e-15);
}

TEST(ContinuedCell, IsCutWithItsNeighbours) {
  const micro::test::PlainCell cell;
  const auto [mesh, fibers] = continued(cell, {2, 2});
  const auto n_sections = [](const CutPatch& cut) { return cut.outlines->GetNumberOfLines(); };
  EXPECT_EQ(n_sections(cut_patch(cell.header().mesh, cell.state().fibers, {0, 0})), 2);
  EXPECT_EQ(n_sections(cut_patch(mesh, fibers, {0, 0})), 4);
  EXPECT_EQ(n_sections(cut_patch(mesh, fibers, {0, 400e-6})), 4) << "in the next copy";
}

TEST(CellOutline, IsTheParallelogramOfThePeriods) {
  const auto cell = micro::test::sheared_cell();
  const auto outline = cell_outline(cell.header().mesh, cell.state().fibers, cell.periods);
  ASSERT_TRUE(outline);
  const Vec3 a = *cell.periods[0], b = *cell.periods[1];
  const std::array<Vec3, 4> expected = {-0.5 * a - 0.5 * b, 0.5 * a - 0.5 * b, 0.5 * a + 0.5 * b, -0.5 * a + 0.5 * b};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT(((*outline)[i] - expected[i]).norm(), 1e-15) << i;
}

TEST(CellOutline, OfAStripReachesFromEdgeToEdge) {
  const auto cell = micro::test::strip();
  const auto outline = cell_outline(cell.header().mesh, cell.state().fibers, cell.periods);
  ASSERT_TRUE(outline);
  EXPECT_LT(((*outline)[0] - Vec3(-200e-6, -220e-6, 0)).norm(), 1e-15);
  EXPECT_LT(((*outline)[2] - Vec3(200e-6, 220e-6, 0)).norm(), 1e-15);
  const LatticeYarns yarns;
  EXPECT_FALSE(cell_outline(yarns.mesh(), yarns.configuration(), {}));
}

/// Where a point appears, in pixels from the left and the upper edge, by the textbook's pinhole camera.
Vec2 pixel_of(const Frame& frame, const Vec3& point) {
  const Vec3 eye = frame.focal_point + frame.distance * frame.backward;
  const double depth = frame.parallel ? frame.distance : (eye - point).dot(frame.backward);
  const Vec3 right = frame.up.cross(frame.backward);
  const Vec2 seen = frame.distance / depth * Vec2((point - eye).dot(right), (point - eye).dot(frame.up));
  return {0.5 * frame.width + seen.x() / frame.pixel, 0.5 * frame.height - seen.y() / frame.pixel};
}

TEST(FitFrame, FillsTheWidthAndLeavesMarginsAndRoomForTheScaleBar) {
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1 ? 900 : -300, i & 2 ? 400 : -250, i & 4 ? 80 : 0);
  for (const bool parallel : {true, false}) {
    const Frame frame = fit_frame(corners, Vec3(-0.5, -1, 0.8), Vec3::UnitZ(), parallel, 1000);
    Vec2 low = Vec2::Constant(1e9), high = -low;
    for (const Vec3& corner : corners) {
      low = low.cwiseMin(pixel_of(frame, corner));
      high = high.cwiseMax(pixel_of(frame, corner));
    }
    EXPECT_NEAR(low.x(), 25, 1) << parallel;  // margins: 2.5 % of the width
    EXPECT_NEAR(high.x(), 975, 1) << parallel;
    EXPECT_NEAR(low.y(), 25, 1) << parallel;
    EXPECT_NEAR(frame.height - high.y(), 25 + 60, 1) << parallel;  // and the scale bar's 6 %
  }
}

TEST(FitFrame, LimitsTheHeightOfWhatIsUpright) {
  const Frame frame = fit_frame({Vec3::Zero(), Vec3(1, 100, 0)}, Vec3::UnitZ(), Vec3::UnitY(), true, 500);
  EXPECT_NEAR(frame.height, 1000, 1);
  EXPECT_GT(pixel_of(frame, Vec3(1, 100, 0)).y(), 0);
  EXPECT_LT(pixel_of(frame, Vec3::Zero()).y(), frame.height);
}

TEST(ScaleBarLength, IsTheLongestRoundOne) {
  EXPECT_EQ(choose_scale_bar(75).text, "50 µm");
  EXPECT_EQ(choose_scale_bar(50).text, "50 µm");
  EXPECT_EQ(choose_scale_bar(49).text, "20 µm");
  EXPECT_EQ(choose_scale_bar(0.19).text, "0.1 µm");
  EXPECT_EQ(choose_scale_bar(2100).text, "2 mm");
  EXPECT_EQ(choose_scale_bar(1.5e6).text, "1 m");
  EXPECT_DOUBLE_EQ(choose_scale_bar(2100).length, 2000);
}

/// A folder with states.h5: one increment of straight warp fibers.
class RenderPatch : public testing::Test {
 protected:
  RenderPatch() {
    micro::SnapshotHeader header;
    header.mesh = yarns_.mesh();
    micro::Increment increment;
    increment.stage = "start";
    increment.fibers = yarns_.configuration();
    micro::SnapshotWriter(folder_ / "states.h5", header).append(increment);
  }
  Outcome render(std::vector<std::string> arguments, const std::string& display = "DISPLAY=") const {
    arguments.insert(arguments.begin(), {TRAME_RENDER_PATCH, "states.h5"});
    return test::run(folder_.path(), arguments, {display});
  }
  Outcome render_in_xvfb(std::vector<std::string> arguments) const {
    // A server that resets when its client goes may do so while xvfb-run cleans up, which then fails now and then.
    arguments.insert(arguments.begin(),
                     {"xvfb-run", "-a", "-s", "-screen 0 1280x1024x24 -noreset", TRAME_RENDER_PATCH, "states.h5"});
    return test::run(folder_.path(), arguments);
  }

  LatticeYarns yarns_;
  TemporaryFolder folder_;
};

TEST_F(RenderPatch, SaysWhatToDoWithoutAnXServer) {
  for (const char* display : {"DISPLAY=", "DISPLAY=:64999"}) {
    const Outcome outcome = render({"--out", "a.png"}, display);
    EXPECT_EQ(outcome.exit_code, 2) << display << outcome.err;
    EXPECT_NE(outcome.err.find("xvfb-run -a render_patch"), std::string::npos) << outcome.err;
  }
}

TEST_F(RenderPatch, NamesTheOptionThatIsWrong) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"--out", "a.jpg"}, "--out a.jpg"},
      {{"--out", "none/a.png"}, "--out none/a.png"},
      {{"--out", "a.png", "--increment", "1"}, "--increment 1"},
      {{"--out", "a.png", "--increment", "weave"}, "--increment weave"},
      {{"--out", "a.png", "--view", "side"}, "--view"},
      {{"--out", "a.png", "--view", "cut", "--at", "z=0um"}, "--at z=0um"},
      {{"--out", "a.png", "--view", "cut", "--at", "x=5 kg"}, "--at x=5 kg"},
      {{"--out", "a.png", "--width", "10"}, "--width"},
      {{}, "--out"},
      {{"--picture", "side", "0", "300", "a.png"}, "--picture side"},
      {{"--picture", "top", "7", "300", "a.png"}, "--picture 7"},
      {{"--picture", "top", "0", "10", "a.png"}, "--picture: width 10"},
      {{"--picture", "top", "0", "300", "a.jpg"}, "--picture a.jpg"}};
  for (const auto& [arguments, mention] : cases) {
    const Outcome outcome = render(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << mention;
    EXPECT_NE(outcome.err.find(mention), std::string::npos) << mention << "\nin: " << outcome.err;
    EXPECT_EQ(outcome.err.find("X server"), std::string::npos) << outcome.err;
  }
}

TEST_F(RenderPatch, RefusesCopiesOfWhatIsNotPeriodic) {
  for (const char* copies : {"2x2", "1x3", "much"}) {
    const Outcome outcome = render({"--out", "a.png", "--copies", copies});
    EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
    EXPECT_NE(outcome.err.find(std::string("--copies ") + copies), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.err.find("X server"), std::string::npos) << outcome.err;
  }
}

struct Pixels {
  int n_coloured = 0, left = 1 << 30, right = -1;  ///< of those that are neither grey nor white
  int longest_dark_run = 0;                        ///< in a row, of the scale bar's grey
};

Pixels look_at(const std::filesystem::path& png) {
  vtkNew<vtkPNGReader> reader;
  reader->SetFileName(png.c_str());
  reader->Update();
  vtkImageData* image = reader->GetOutput();
  Pixels pixels;
  for (int y = 0; y < image->GetDimensions()[1]; ++y)
    for (int x = 0, run = 0; x < image->GetDimensions()[0]; ++x) {
      const auto* rgb = static_cast<unsigned char*>(image->GetScalarPointer(x, y, 0));
      const auto [low, high] = std::minmax({rgb[0], rgb[1], rgb[2]});
      run = high < 60 && high - low < 5 ? run + 1 : 0;
      pixels.longest_dark_run = std::max(pixels.longest_dark_run, run);
      if (high - low < 20) continue;
      ++pixels.n_coloured;
      pixels.left = std::min(pixels.left, x);
      pixels.right = std::max(pixels.right, x);
    }
  return pixels;
}

TEST_F(RenderPatch, DrawsACutToScale) {
  if (std::system("command -v xvfb-run >/dev/null") != 0) GTEST_SKIP() << "needs xvfb-run";
  const Outcome outcome = render_in_xvfb({"--out", "cut.png", "--view", "cut", "--at", "x=5m", "--width", "1000"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  const Pixels pixels = look_at(folder_ / "cut.png");
  // Four staggered columns of fibers side by side: (3 + ½) spacings and a diameter.
  const double metre = (pixels.right - pixels.left + 1) / (3.5 + 2 * yarns_.radius);
  const double area = 12 * M_PI * yarns_.radius * yarns_.radius;
  EXPECT_NEAR(pixels.n_coloured / (metre * metre), area, 0.03 * area);
  EXPECT_NEAR(pixels.longest_dark_run, 0.5 * metre, 2);  // a fifth of the picture is 0.94 m
}

TEST_F(RenderPatch, DrawsTheOtherViews) {
  if (std::system("command -v xvfb-run >/dev/null") != 0) GTEST_SKIP() << "needs xvfb-run";
  for (const std::string view : {"top", "perspective"}) {
    const Outcome outcome = render_in_xvfb({"--out", view + ".png", "--view", view, "--width", "400"});
    ASSERT_EQ(outcome.exit_code, 0) << view << outcome.out << outcome.err;
    const Pixels pixels = look_at(folder_ / (view + ".png"));
    EXPECT_NEAR(pixels.left, 10, 2) << view;  // margins of 2.5 %
    EXPECT_NEAR(pixels.right, 389, 2) << view;
  }
}

/// Width over which a cell's picture is coloured, and length of the line around it, in pixels.
class RenderCell : public RenderPatch {
 protected:
  std::array<int, 2> widths(const micro::test::PlainCell& cell, std::vector<std::string> arguments) {
    std::filesystem::remove(folder_ / "states.h5");
    micro::SnapshotWriter(folder_ / "states.h5", cell.header()).append(cell.state());
    arguments.insert(arguments.end(), {"--view", "top", "--width", "1000", "--out", "cell.png"});
    const Outcome outcome = render_in_xvfb(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
    const Pixels pixels = look_at(folder_ / "cell.png");
    return {pixels.right - pixels.left + 1, pixels.longest_dark_run};
  }
};

TEST_F(RenderCell, DrawsCopiesAndALineAroundTheCell) {
  if (std::system("command -v xvfb-run >/dev/null") != 0) GTEST_SKIP() << "needs xvfb-run";
  const auto expect = [](const std::array<int, 2>& widths, double all, double cell) {
    EXPECT_NEAR(widths[0], all, 6);
    EXPECT_NEAR(widths[1], cell, 6);
  };
  // What is seen takes 950 of 1000 pixels; scale bars are below 200.
  expect(widths({}, {}), 950, 950 / 2.);
  expect(widths({}, {"--copies", "1x1"}), 950, 950);
  expect(widths(micro::test::strip(), {}), 950, 950 / 3.);
  // The cell begins at -275 µm, its fibers at -242.5 µm, and those of the copies end at 792.5 µm.
  const double pixel = (792.5 + 275) / 950;
  expect(widths(micro::test::sheared_cell(), {}), (792.5 + 242.5) / pixel, 420 / pixel);
}

/// Needs ParaView, which does not install beside VTK's headers on Debian 12: data/paraview/README.md.
TEST_F(RenderPatch, DrawsSeveralPicturesAtOnceAsOneByOne) {
  if (std::system("command -v xvfb-run >/dev/null") != 0) GTEST_SKIP() << "needs xvfb-run";
  const Outcome both = render_in_xvfb(
      {"--picture", "top", "0", "300", "top.png", "--picture", "perspective", "last", "400", "perspective.png"});
  ASSERT_EQ(both.exit_code, 0) << both.err;
  ASSERT_EQ(render_in_xvfb({"--view", "perspective", "--width", "400", "--out", "alone.png"}).exit_code, 0);
  const auto bytes = [&](const char* file) { return test::read_text(folder_ / file); };
  EXPECT_FALSE(bytes("top.png").empty());
  EXPECT_EQ(bytes("perspective.png"), bytes("alone.png"));
}

TEST(ParaViewStudy, TraceShowsAllViews) {
  const char* pvbatch = std::getenv("TRAME_PVBATCH");
  if (pvbatch == nullptr) GTEST_SKIP() << "TRAME_PVBATCH must name ParaView's pvbatch";
  const TemporaryFolder folder;
  const Outcome made = test::run(folder.path(), {TRAME_RUN_WORKFLOW, "plain_small", "--out", "out"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const std::string trace = std::string(TRAME_DATA_DIR) + "/paraview/trame_views.py";
  const Outcome outcome = test::run(
      folder.path(), {"xvfb-run", "-a", "-s", "-screen 0 1280x1024x24 -noreset", pvbatch, trace, "out", "pictures"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  for (const char* view :
       {"fibers", "fibers_cut", "horizontal", "horizontal_cut", "vertical_cut", "shear_cut", "axial_cut"}) {
    const Pixels pixels = look_at(folder.path() / "pictures" / (std::string(view) + ".png"));
    EXPECT_GT(pixels.n_coloured, 10'000) << view;  // of 1.4 million
    EXPECT_GT(pixels.left, 0) << view << ": cropped";
    EXPECT_LT(pixels.right, 1599) << view << ": cropped";
  }
  const Outcome wrong = test::run(folder.path(), {pvbatch, trace, "none", "pictures"});
  EXPECT_NE(wrong.exit_code, 0);
  EXPECT_NE((wrong.out + wrong.err).find("fibers.pvd: is not there"), std::string::npos) << wrong.out << wrong.err;
}

}  // namespace
}  // namespace trame::workflows
