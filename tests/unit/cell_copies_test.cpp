#include "micro/states/cell_copies.h"

#include <gtest/gtest.h>
#include <vtkCellData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkXMLPolyDataReader.h>

#include "micro/states/fibers_vtk.h"
#include "tests/support/messages.h"
#include "tests/support/plain_cell_states.h"
#include "tests/support/temporary_folder.h"

namespace trame::micro {
namespace {

using test::PlainCell;
using trame::test::expect_mentions;
using trame::test::input_error;
using trame::test::TemporaryFolder;

TEST(CellCopies, PeriodsAreThoseThatFibersComeBackBy) {
  const PlainCell sheared = test::sheared_cell(), strip = test::strip();
  EXPECT_EQ(periods_of(sheared.header(), sheared.state()), sheared.periods);
  EXPECT_EQ(periods_of(strip.header(), strip.state()), strip.periods);
  // A body of that name is no period where fibers do not come back by its position.
  Increment elsewhere = sheared.state();
  elsewhere.bodies.position[1] += Vec3(1e-6, 0, 0);
  EXPECT_EQ(is_periodic(periods_of(sheared.header(), elsewhere)), (std::array<bool, 2>{true, false}));
}

TEST(CellCopies, AreNumberedAroundTheCellItself) {
  EXPECT_EQ(copy_numbers({1, 1}), (std::vector<CopyNumber>{{0, 0}}));
  EXPECT_EQ(copy_numbers({2, 2}), (std::vector<CopyNumber>{{0, 0}, {1, 0}, {0, 1}, {1, 1}}));
  EXPECT_EQ(copy_numbers({3, 1}), (std::vector<CopyNumber>{{-1, 0}, {0, 0}, {1, 0}}));
  EXPECT_EQ(copy_range(4), (std::array<Index, 2>{-1, 2}));
}

TEST(CellCopies, AreReadAsTwoNumbers) {
  EXPECT_EQ(parse_copies("2x3"), (Copies{2, 3}));
  EXPECT_EQ(parse_copies("100x1"), (Copies{100, 1}));
  for (const char* text :
       {"", "2", "x", "2x", "x2", "0x1", "-1x2", "2x2x2", "2 x 2", "1.5x1", "101x1", "99999999999x1"})
    expect_mentions(input_error([&] { (void)parse_copies(text); }), {"--copies", text, "1 … 100", "such as 2x2"});
}

TEST(CellCopies, AreRefusedAlongWhatHasEnds) {
  const auto error = [](Copies copies, std::array<bool, 2> periodic) {
    return input_error([&] { check_copies(copies, periodic); });
  };
  EXPECT_EQ(error({1, 1}, {false, false}), "");
  EXPECT_EQ(error({2, 2}, {true, true}), "");
  EXPECT_EQ(error({5, 1}, {true, false}), "");
  expect_mentions(error({2, 2}, {false, false}), {"--copies 2x2", "periodic", "1x1"});
  expect_mentions(error({2, 2}, {true, false}), {"--copies 2x2", "along its warp alone", "end with x1"});
  expect_mentions(error({2, 1}, {false, true}), {"--copies 2x1", "along its weft alone", "begin with 1x"});
}

TEST(CellCopies, ThatAreShownGoOnBothWays) {
  EXPECT_EQ(copies_to_show({true, true}), (Copies{2, 2}));
  EXPECT_EQ(copies_to_show({true, false}), (Copies{3, 1}));
  EXPECT_EQ(copies_to_show({false, true}), (Copies{1, 3}));
  EXPECT_EQ(copies_to_show({false, false}), (Copies{1, 1}));
}

/// A reference state and the cell of a test, written as VTK files.
struct Written {
  Written(const PlainCell& cell, const Copies& copies) : state(cell.state()) {
    const PlainCell reference{
        .periods = {Vec3(400e-6, 0, 0), cell.periods[1] ? std::optional(Vec3(0, 400e-6, 0)) : std::nullopt}};
    at_start = reference.state();
    FibersVtkWriter writer(cell.header(), at_start, folder / "vtk", copies);
    writer.append(0, at_start);
    writer.append(1, state);
    reader->SetFileName((folder / "vtk/fibers_0001.vtp").c_str());
    reader->Update();
  }
  [[nodiscard]] vtkPolyData* data() const { return reader->GetOutput(); }

  TemporaryFolder folder;
  Increment at_start, state;
  vtkNew<vtkXMLPolyDataReader> reader;
};

TEST(CellCopiesInVtk, AreShiftedByThePeriodsOfTheirState) {
  const PlainCell cell = test::sheared_cell();
  const Written written(cell, {2, 3});
  const std::vector<Vec3>& r = written.state.fibers.r;
  const auto n_nodes = static_cast<vtkIdType>(r.size());
  vtkPolyData* data = written.data();
  ASSERT_EQ(data->GetNumberOfPoints(), 6 * n_nodes);
  ASSERT_EQ(data->GetNumberOfLines(), 6 * 4);
  vtkDataArray* copy = data->GetCellData()->GetArray("copy");
  ASSERT_NE(copy, nullptr);
  ASSERT_EQ(copy->GetNumberOfComponents(), 2);
  EXPECT_STREQ(copy->GetComponentName(0), "warp");
  const std::vector<CopyNumber> numbers = {{0, -1}, {1, -1}, {0, 0}, {1, 0}, {0, 1}, {1, 1}};
  for (vtkIdType c = 0; c < 6; ++c) {
    const auto [i, j] = numbers[c];
    const Vec3 by = i * *cell.periods[0] + j * *cell.periods[1];
    const Vec3 before = i * Vec3(400e-6, 0, 0) + j * Vec3(0, 400e-6, 0);
    for (vtkIdType f = 0; f < 4; ++f) {
      EXPECT_EQ(copy->GetTuple2(4 * c + f)[0], i);
      EXPECT_EQ(copy->GetTuple2(4 * c + f)[1], j);
      EXPECT_EQ(data->GetCellData()->GetArray("fiber")->GetTuple1(4 * c + f), f);
      EXPECT_EQ(data->GetCell(4 * c + f)->GetPointId(0), n_nodes * c + n_nodes / 4 * f);
    }
    for (vtkIdType n = 0; n < n_nodes; ++n) {
      EXPECT_EQ(Vec3(data->GetPoint(c * n_nodes + n)), Vec3(r[n] + by));
      const Vec3 moved = r[n] + by - written.at_start.fibers.r[n] - before;
      EXPECT_LT((Vec3(data->GetPointData()->GetArray("displacement")->GetTuple3(c * n_nodes + n)) - moved).norm(),
                1e-10);
      EXPECT_FLOAT_EQ(data->GetPointData()->GetArray("radius")->GetTuple1(c * n_nodes + n), 20e-6);
    }
  }
  EXPECT_NE(data->GetFieldData()->GetAbstractArray("load"), nullptr);
}

TEST(CellCopiesInVtk, CloseTheSeams) {
  const PlainCell cell = test::sheared_cell();
  const Written written(cell, {2, 2});
  vtkPolyData* data = written.data();
  const auto end_of = [&](vtkIdType fiber) {
    return Vec3(data->GetPoint(data->GetCell(fiber)->GetPointId(data->GetCell(fiber)->GetNumberOfPoints() - 1)));
  };
  const auto start_of = [&](vtkIdType fiber) { return Vec3(data->GetPoint(data->GetCell(fiber)->GetPointId(0))); };
  for (const vtkIdType warp : {0, 1}) EXPECT_LT((end_of(warp) - start_of(4 + warp)).norm(), 1e-18);
  for (const vtkIdType weft : {2, 3}) EXPECT_LT((end_of(weft) - start_of(8 + weft)).norm(), 1e-18);
}

TEST(CellCopiesInVtk, OfAStripGoOneWay) {
  const Written written(test::strip(), {3, 1});
  const auto n_nodes = static_cast<vtkIdType>(written.state.fibers.r.size());
  ASSERT_EQ(written.data()->GetNumberOfPoints(), 3 * n_nodes);
  EXPECT_EQ(Vec3(written.data()->GetPoint(0)), Vec3(written.state.fibers.r[0] - Vec3(400e-6, 0, 0)));
  EXPECT_EQ(written.data()->GetCellData()->GetArray("copy")->GetTuple2(0)[0], -1);
  expect_mentions(input_error([] { (void)Written(test::strip(), {1, 2}); }), {"--copies 1x2", "along its warp alone"});
}

TEST(CellCopiesInVtk, OneIsTheCellAsItIs) {
  const Written written(test::sheared_cell(), one_cell);
  EXPECT_EQ(written.data()->GetNumberOfLines(), 4);
  ASSERT_NE(written.data()->GetCellData()->GetArray("copy"), nullptr);
  EXPECT_EQ(written.data()->GetCellData()->GetArray("copy")->GetTuple2(3)[1], 0);
}

TEST(CellCopiesInVtk, AreRefusedOfWhatIsNotPeriodic) {
  const PlainCell patch{.periods = {std::nullopt, std::nullopt}};
  expect_mentions(input_error([&] { (void)Written(patch, {2, 2}); }), {"--copies 2x2", "1x1"});
  const Written written(PlainCell{.periods = {std::nullopt, std::nullopt}}, one_cell);
  EXPECT_EQ(written.data()->GetCellData()->GetArray("copy"), nullptr);
}

}  // namespace
}  // namespace trame::micro
