#include <gtest/gtest.h>
#include <vtkCellData.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <cmath>

#include "tests/support/analyse.h"
#include "tests/support/lattice_yarns.h"
#include "tests/support/temporary_folder.h"

namespace trame::meso {
namespace {

using micro::test::input_error;
using micro::test::LatticeYarns;
using test::analyse;
using test::Analysis;
using trame::test::TemporaryFolder;

/// States of three yarns: increment i is stretched by 1 + 0.01 i along them and by 1 − 0.02 i in height.
class Analyse : public ::testing::Test {
 protected:
  static Mat3 map(Index i) { return Vec3(1 + 0.01 * i, 1, 1 - 0.02 * i).asDiagonal(); }
  static double strain(double stretch) { return 0.5 * (stretch * stretch - 1); }

  Analyse() {
    micro::SnapshotWriter writer(folder_ / "states.h5", {"1", "scene", "", yarns_.mesh(), {}});
    for (Index i = 0; i < 4; ++i) {
      micro::Increment increment;
      increment.stage = i < 2 ? "relax" : "load";
      increment.stage_time = 0.5 * (i % 2 + 1);
      increment.fibers = micro::test::mapped(yarns_.configuration(), map(i));
      writer.append(increment);
    }
  }
  LatticeYarns yarns_{.n_yarns = 3};
  TemporaryFolder folder_;
};

TEST_F(Analyse, EveryYarnInEveryIncrement) {
  const RunStates states(folder_ / "states.h5");
  std::vector<YarnStrain> rows;
  const auto collect = [&](const std::vector<YarnStrain>& state) {
    rows.insert(rows.end(), state.begin(), state.end());
  };
  const Analysis analysis = analyse(states, {.n_threads = 2, .on_state = collect});
  ASSERT_EQ(analysis.meshes.size(), 3u);
  ASSERT_EQ(rows.size(), 12u);
  ASSERT_EQ(analysis.strains.size(), 3u);
  EXPECT_EQ(analysis.strains[0].increment, 3) << "the last one is kept";
  ASSERT_EQ(analysis.fields.size(), 3u);
  EXPECT_EQ(analysis.fields[2].strain.E.size(), analysis.meshes[2].tets.size());
  EXPECT_EQ(analysis.n_tets, 3 * 3 * 12 * 10);
  for (Index i = 0; i < 4; ++i)
    for (Index y = 0; y < 3; ++y) {
      const YarnStrain& row = rows[3 * i + y];
      EXPECT_EQ(row.increment, i);
      EXPECT_EQ(row.yarn, y);
      EXPECT_EQ(row.n_tets, 3 * 12 * 10);
      EXPECT_EQ(row.n_flagged, 0);
      EXPECT_NEAR(row.axial.mean, strain(1 + 0.01 * i), 1e-12);
      EXPECT_NEAR(row.axial.max, row.axial.mean, 1e-12);
      EXPECT_NEAR(row.axial.quantile_05, row.axial.mean, 1e-12);
      EXPECT_NEAR(row.axial.deviation, 0, 1e-12);
      EXPECT_NEAR(row.horizontal.min, 0, 1e-12);
      EXPECT_NEAR(row.vertical.mean, strain(1 - 0.02 * i), 1e-12);
      EXPECT_NEAR(row.det_F.mean, (1 + 0.01 * i) * (1 - 0.02 * i), 1e-12);
    }
}

TEST_F(Analyse, ChosenStatesAndYarns) {
  const RunStates states(folder_ / "states.h5");
  const Analysis analysis = analyse(states, {.from = 1, .to = {3}, .yarns = {"warp/*"}, .mesh = MeshKind::swept});
  ASSERT_EQ(analysis.strains.size(), 2u);
  EXPECT_EQ(analysis.strains[0].yarn, 0);
  EXPECT_EQ(analysis.strains[1].yarn, 2);
  EXPECT_NEAR(analysis.strains[1].axial.mean, strain(1.03 / 1.01), 1e-12);
  EXPECT_NEAR(analysis.strains[1].vertical.mean, strain(0.94 / 0.98), 1e-12);
}

TEST_F(Analyse, VtkReadsBack) {
  const RunStates states(folder_ / "states.h5");
  (void)analyse(states, {.from = 1, .to = {2, 3}, .vtk_folder = folder_ / "vtk"});
  EXPECT_TRUE(std::filesystem::exists(folder_ / "vtk/yarns.pvd"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "vtk/yarns_0002.vtu"));
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName((folder_ / "vtk/yarns_0003.vtu").c_str());
  reader->Update();
  vtkUnstructuredGrid* grid = reader->GetOutput();
  ASSERT_EQ(grid->GetNumberOfCells(), 3 * 3 * 12 * 10);
  ASSERT_EQ(grid->GetNumberOfPoints(), 3 * 12 * 11);
  vtkCellData* cells = grid->GetCellData();
  for (const char* name :
       {"E_axial", "E_horizontal", "E_vertical", "E_axial_horizontal", "E_axial_vertical", "E_horizontal_vertical",
        "E_I", "E_II", "E_III", "gamma_max", "det_F", "flagged", "yarn", "family", "shear_zone", "shear_contrast"})
    ASSERT_NE(cells->GetArray(name), nullptr) << name;
  vtkPointData* points = grid->GetPointData();
  for (const char* name :
       {"E_axial", "E_horizontal", "E_vertical", "E_axial_horizontal", "E_axial_vertical", "E_horizontal_vertical",
        "E_I", "E_II", "E_III", "gamma_max", "det_F", "flagged", "D2_min"}) {
    ASSERT_NE(points->GetArray(name), nullptr) << name;
    EXPECT_EQ(points->GetArray(name)->GetNumberOfTuples(), grid->GetNumberOfPoints()) << name;
  }
  const double axial = strain(1.03 / 1.01), vertical = strain(0.94 / 0.98);
  for (const vtkIdType c : {0, 500, 1079}) {
    EXPECT_NEAR(cells->GetArray("E_axial")->GetTuple1(c), axial, 1e-8);
    EXPECT_NEAR(cells->GetArray("E_III")->GetTuple1(c), vertical, 1e-8);
    EXPECT_NEAR(cells->GetArray("gamma_max")->GetTuple1(c), axial - vertical, 1e-8);
    EXPECT_EQ(cells->GetArray("yarn")->GetTuple1(c), c / 360);
    EXPECT_EQ(cells->GetArray("shear_zone")->GetTuple1(c), 0) << "uniform";
    EXPECT_EQ(cells->GetArray("family")->GetTuple1(c), c / 360 == 1 ? 1 : 0);
  }
  for (const vtkIdType p : {0, 200, 395}) EXPECT_NEAR(points->GetArray("E_axial")->GetTuple1(p), axial, 1e-8);
  EXPECT_LT(points->GetArray("D2_min")->GetTuple1(200), 1e-20) << "affine";
  EXPECT_TRUE(std::isnan(points->GetArray("D2_min")->GetTuple1(0))) << "the end of a corner fiber has 5 neighbours";
  const Vec3 point(grid->GetPoint(10));
  EXPECT_NEAR(point.x(), 10.3, 1e-12);
  EXPECT_NEAR(grid->GetPointData()->GetArray("displacement")->GetTuple3(10)[0], 0.2, 1e-6);
  EXPECT_EQ(vtkStringArray::SafeDownCast(grid->GetFieldData()->GetAbstractArray("load"))->GetValue(0), "load");
  EXPECT_EQ(grid->GetFieldData()->GetArray("from")->GetTuple1(0), 1);
}

TEST_F(Analyse, BadChoices) {
  const RunStates states(folder_ / "states.h5");
  EXPECT_NE(input_error([&] {
              (void)analyse(states, {.yarns = {"weft/7"}});
            }).find("no yarn is called \"weft/7\"; there are: warp/1 weft/1 warp/2"),
            std::string::npos);
  EXPECT_THROW((void)analyse(states, {.from = 4}), InputError);
  EXPECT_THROW((void)analyse(states, {.to = {0, -1}}), InputError);
}

TEST(AnalyseThinYarns, GiveNoStrainsButSayWhy) {
  const TemporaryFolder folder;
  const LatticeYarns yarns{.n_yarns = 2, .n_rows = 1, .n_columns = 2};
  micro::Increment increment;
  increment.fibers = yarns.configuration();
  micro::SnapshotWriter(folder / "states.h5", {"1", "scene", "", yarns.mesh(), {}}).append(increment);
  const RunStates states(folder / "states.h5");
  const Analysis analysis = analyse(states, {.vtk_folder = folder / "vtk"});
  EXPECT_TRUE(analysis.strains.empty());
  EXPECT_EQ(analysis.meshes[1].status, MeshStatus::too_few_fibers);
  EXPECT_TRUE(std::filesystem::exists(folder / "vtk/yarns_0000.vtu"));
}

}  // namespace
}  // namespace trame::meso
