/// \file
/// Surfaces as meshes for ParaView: their points are where the signed distance vanishes.

#include "micro/states/surfaces_vtk.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <vtkXMLPolyDataReader.h>

#include "micro/solve/system.h"
#include "tests/support/meshes.h"
#include "tests/support/rod_scene.h"
#include "tests/support/run_scene.h"

namespace trame::micro {
namespace {

TEST(SurfacesVtk, PointsAreOnTheSurface) {
  const Eigen::AlignedBox3d around(Vec3(-1, -2, -1), Vec3(3, 2, 1));
  const Vec3 leaning = Vec3(1, 2, 2) / 3;
  for (const Surface& surface :
       {Surface{SurfaceShape::plane, Vec3(0.1, 0, 0), leaning},
        Surface{SurfaceShape::sphere, Vec3(1, 0, 0), leaning, 2},
        Surface{SurfaceShape::cylinder, Vec3(1, 0, 0), leaning, 0.5},
        Surface{SurfaceShape::cylinder, Vec3(1, 0, 0), leaning, 0.5, 1},
        Surface{.shape = SurfaceShape::box, .center = Vec3(0, 1, 0), .half_size = Vec3(1, 2, 3)},
        Surface{.shape = SurfaceShape::mesh,
        .center = Vec3(0, 1, 0),
        .mesh = test::mesh_of(test::sphere_corners(1, 1)),
        .unit = 0.5}}) {
    const PlacedSurface placed{0, surface, Vec3(0.3, 0.2, -0.1), rotation_matrix({0.3, -0.2, 0.9})};
    const auto shape = shape_of(placed, around);
    ASSERT_GT(shape->GetNumberOfPoints(), 3);
    int n_on = 0;
    for (vtkIdType i = 0; i < shape->GetNumberOfPoints(); ++i) {
      const Vec3 x = placed.rotation.transpose() * (Vec3(shape->GetPoint(i)) - placed.position);
      const double distance = view(surface, x).distance;
      EXPECT_LT(distance, 1e-6) << i;  // rounded ends have halves of spheres within
      n_on += std::abs(distance) < 1e-6 ? 1 : 0;
    }
    EXPECT_GT(n_on, shape->GetNumberOfPoints() / 2 - 2);
  }
}

TEST(SurfacesVtk, SeriesHasThemFromTheirStageOn) {
  const trame::test::TemporaryFolder folder;
  const Scene scene = parse_scene(trame::test::rod_scene(R"([[body]]
name = "ball"
position = ["2 mm", "0 mm", "1.2 mm"]
[[body.surface]]
shape = "sphere"
radius = "1 mm"
from_stage = "later"
[[stage]]
name = "first"
increments = 1
[[stage]]
name = "later"
increments = 1
)"),
                                  "s.toml");
  SimulateOptions options;
  options.states = folder / "states.h5";
  options.n_threads = 1;
  ASSERT_EQ(simulate(scene, options).status, SimulationSummary::Status::done);
  write_surfaces_vtk(SnapshotReader(options.states), folder / "vtk");
  for (int i = 0; i < 3; ++i) {
    vtkNew<vtkXMLPolyDataReader> reader;
    reader->SetFileName((folder / fmt::format("vtk/surfaces_{:04}.vtp", i)).c_str());
    reader->Update();
    const vtkIdType n = reader->GetOutput()->GetNumberOfPoints();
    EXPECT_EQ(n > 0, i == 2) << i;
    if (n == 0) continue;
    double bounds[6];
    reader->GetOutput()->GetBounds(bounds);
    EXPECT_NEAR(bounds[4], 0.2e-3, 1e-8);
    EXPECT_NEAR(bounds[5], 2.2e-3, 1e-8);
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "vtk/surfaces.pvd"));
}

}  // namespace
}  // namespace trame::micro
