#include "micro/states/fibers_vtk.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vtkCellData.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkXMLPolyDataReader.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <iterator>

#include "micro/core/error.h"
#include "tests/support/lattice_yarns.h"
#include "tests/support/temporary_folder.h"

namespace trame::micro {
namespace {

using test::LatticeYarns;
using trame::test::TemporaryFolder;

/// One fiber of radius of curvature `radius` in its own plane: nodes on a circle, arc lengths that of the circle.
std::vector<Vec3> circle(const FiberMesh& mesh, double radius) {
  std::vector<Vec3> r;
  for (const double s : mesh.arc_length)
    r.emplace_back(radius * std::sin(s / radius), 0, radius * (1 - std::cos(s / radius)));
  return r;
}

TEST(FiberTension, UniformStretchIsExact) {
  const LatticeYarns yarns;
  const FiberMesh mesh = yarns.mesh();
  const auto reference = yarns.configuration();
  const auto current = test::mapped(reference, Mat3(Vec3(1.02, 0.9, 1).asDiagonal()));
  for (const double tension : fiber_tension(mesh, reference.r, current.r))
    EXPECT_NEAR(tension, 7.0 * 0.5 * (1.02 * 1.02 - 1), 1e-12);
}

TEST(FiberTension, RotationGivesNone) {
  const LatticeYarns yarns;
  const auto reference = yarns.configuration();
  const Mat3 rotation = Eigen::AngleAxisd(1.1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (const double tension : fiber_tension(yarns.mesh(), reference.r, test::mapped(reference, rotation).r))
    EXPECT_NEAR(tension, 0, 1e-13);
}

TEST(FiberTension, CurvedReferenceIsFreeOfTension) {
  const FiberMesh mesh = LatticeYarns{.n_rows = 1, .n_columns = 1}.mesh();
  const auto bent = circle(mesh, 8.0);
  for (const double tension : fiber_tension(mesh, bent, bent)) EXPECT_EQ(tension, 0);
}

/// x = s + a s²/2 gives E = a s + a² s²/2: for small a linear along the fiber, which the nodes must show without steps.
TEST(FiberTension, LinearStrainIsReproduced) {
  const LatticeYarns yarns{.n_rows = 1, .n_columns = 1};
  const FiberMesh mesh = yarns.mesh();
  const auto reference = yarns.configuration().r;
  auto current = reference;
  const double a = 1e-6;
  for (Vec3& r : current) r.x() += 0.5 * a * r.x() * r.x();
  const auto tension = fiber_tension(mesh, reference, current);
  for (std::size_t n = 0; n < tension.size(); ++n) EXPECT_NEAR(tension[n], 7.0 * a * mesh.arc_length[n], 1e-9);
}

TEST(FiberCurvature, CircleConvergesQuadratically) {
  const double radius = 8.0;
  const auto worst = [&](Index n_elements) {
    const FiberMesh mesh = LatticeYarns{.n_rows = 1, .n_columns = 1, .n_elements = n_elements}.mesh();
    double error = 0;
    for (const double curvature : fiber_curvature(mesh, circle(mesh, radius)))
      error = std::max(error, std::abs(curvature * radius - 1));
    return error;
  };
  EXPECT_LT(worst(20), 0.01);
  EXPECT_NEAR(worst(20) / worst(40), 4, 0.2);
}

TEST(FiberContactForce, LumpedToTheNearestNodePerLength) {
  const LatticeYarns yarns{.n_rows = 1, .n_columns = 2};  // 11 nodes a fiber, 1 m apart
  const FiberMesh mesh = yarns.mesh();
  ContactRecord contacts;
  contacts.fiber_a = {0, 0, 0};
  contacts.fiber_b = {1, 1, 1};
  contacts.s_a = {2.4, 0.0, 10.0};
  contacts.s_b = {2.6, 0.2, 9.9};
  contacts.normal_force = {3, 5, 7};
  std::vector<double> expected(22, 0.0);
  expected[2] = expected[11 + 3] = 3;
  expected[0] = expected[11] = 5 / 0.5;  // an end node has half the length
  expected[10] = expected[21] = 7 / 0.5;
  EXPECT_EQ(fiber_contact_force(mesh, contacts), expected);
}

class FibersVtk : public ::testing::Test {
 protected:
  FibersVtk() {
    SnapshotWriter states(folder_ / "states.h5", {"1", "scene", "", yarns_.mesh(), {}});
    for (int i = 0; i < 3; ++i) {
      Increment increment;
      increment.stage = i == 0 ? "separate" : "relax";
      increment.stage_time = 0.25 * i;
      increment.fibers = test::mapped(yarns_.configuration(), Mat3(Vec3(1 + 0.01 * i, 1, 1).asDiagonal()));
      states.append(increment);
    }
  }
  LatticeYarns yarns_{.n_yarns = 2};
  TemporaryFolder folder_;
};

TEST_F(FibersVtk, EveryIncrementReadsBack) {
  const SnapshotReader states(folder_ / "states.h5");
  EXPECT_EQ(write_fibers_vtk(states, folder_ / "vtk"), folder_ / "vtk/fibers.pvd");
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName((folder_ / "vtk/fibers_0002.vtp").c_str());
  reader->Update();
  vtkPolyData* data = reader->GetOutput();
  ASSERT_EQ(data->GetNumberOfPoints(), 264);
  ASSERT_EQ(data->GetNumberOfLines(), 24);
  EXPECT_EQ(data->GetCell(23)->GetNumberOfPoints(), 11);
  const FiberConfiguration fibers = states.read_fibers(2);
  for (vtkIdType n = 0; n < 264; ++n) EXPECT_EQ(Vec3(data->GetPoint(n)), fibers.r[n]);
  vtkPointData* points = data->GetPointData();
  for (const char* name : {"radius", "displacement", "tension", "curvature", "contact_force"})
    ASSERT_NE(points->GetArray(name), nullptr) << name;
  EXPECT_FLOAT_EQ(points->GetArray("radius")->GetTuple1(100), 0.475f);
  EXPECT_FLOAT_EQ(points->GetArray("tension")->GetTuple1(5), 7 * 0.5 * (1.02 * 1.02 - 1));
  EXPECT_FLOAT_EQ(points->GetArray("displacement")->GetTuple3(10)[0], 0.2);
  EXPECT_EQ(data->GetCellData()->GetArray("fiber")->GetTuple1(23), 23);
  EXPECT_EQ(data->GetCellData()->GetArray("yarn")->GetTuple1(12), 1);
  EXPECT_EQ(data->GetCellData()->GetArray("family")->GetTuple1(12), 1);
  auto* load = vtkStringArray::SafeDownCast(data->GetFieldData()->GetAbstractArray("load"));
  ASSERT_NE(load, nullptr);
  EXPECT_EQ(load->GetValue(0), "relax");
  EXPECT_EQ(data->GetFieldData()->GetArray("stage_time")->GetTuple1(0), 0.5);
}

TEST_F(FibersVtk, SeriesListsWhatIsWrittenSoFar) {
  const SnapshotReader states(folder_ / "states.h5");
  FibersVtkWriter writer(states.header(), states.read(0), folder_ / "stream");
  writer.append(0, states.read(0));
  writer.append(2, states.read(2));
  std::ifstream stream(folder_ / "stream/fibers.pvd");
  const std::string pvd{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_NE(pvd.find("<DataSet timestep=\"0\" part=\"0\" file=\"fibers_0000.vtp\"/>"), std::string::npos) << pvd;
  EXPECT_NE(pvd.find("<DataSet timestep=\"2\" part=\"0\" file=\"fibers_0002.vtp\"/>"), std::string::npos) << pvd;
  EXPECT_EQ(pvd.find("fibers_0001"), std::string::npos) << pvd;
}

TEST_F(FibersVtk, FolderThatCannotBeMade) {
  const SnapshotReader states(folder_ / "states.h5");
  EXPECT_NE(test::input_error([&] { write_fibers_vtk(states, folder_ / "states.h5/vtk"); }).find("cannot be created"),
            std::string::npos);
}

TEST(FibersVtkOnAFullDisk, AreWholeOrAbsent) {
  const TemporaryFolder folder;
  const LatticeYarns yarns{.n_elements = 40};
  {
    SnapshotWriter writer(folder / "states.h5", {"1", "scene", "", yarns.mesh(), {}});
    for (int i = 0; i < 3; ++i) {
      Increment increment;
      increment.stage = "pull";
      increment.fibers = test::mapped(yarns.configuration(), Mat3(Vec3(1 + 0.1 * i, 1, 1).asDiagonal()));
      writer.append(increment);
    }
  }
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{4000, 4000};  // less than a file of the series
    setrlimit(RLIMIT_FSIZE, &limit);
    try {
      write_fibers_vtk(SnapshotReader(folder / "states.h5"), folder / "vtk");
    } catch (const WriteError&) {
      _exit(3);
    } catch (...) {
    }
    _exit(1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 3);
  EXPECT_TRUE(std::filesystem::is_empty(folder / "vtk")) << "neither cut files nor a list of them";
}

}  // namespace
}  // namespace trame::micro
