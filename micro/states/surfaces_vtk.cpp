#include "micro/states/surfaces_vtk.h"

#include <vtkAppendPolyData.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCubeSource.h>
#include <vtkLineSource.h>
#include <vtkMatrix4x4.h>
#include <vtkPlaneSource.h>
#include <vtkPoints.h>
#include <vtkSphereSource.h>
#include <vtkTransform.h>
#include <vtkTransformPolyDataFilter.h>
#include <vtkTubeFilter.h>
#include <vtkXMLPolyDataWriter.h>

#include <algorithm>
#include <optional>

#include "micro/core/error.h"
#include "micro/core/name_table.h"
#include "micro/scene/stages.h"
#include "micro/states/vtk_series.h"

namespace trame::micro {

namespace {

using Shape = vtkSmartPointer<vtkPolyData>;

constexpr int n_sides = 96;      // of what is round
constexpr double beyond = 0.05;  // of the fibers' extent, each way

Shape joined(const std::vector<Shape>& parts) {
  vtkNew<vtkAppendPolyData> append;
  for (const Shape& part : parts) append->AddInputData(part);
  append->Update();
  return append->GetOutput();
}

Shape sphere(const Vec3& center, double radius) {
  vtkNew<vtkSphereSource> source;
  source->SetCenter(center.x(), center.y(), center.z());
  source->SetRadius(radius);
  source->SetThetaResolution(n_sides);
  source->SetPhiResolution(n_sides / 2);
  source->Update();
  return source->GetOutput();
}

/// The square of a plane that the box of `size` about `middle` may stand before.
Shape plane(const Surface& s, const Vec3& middle, double size) {
  const Vec3 foot = middle - s.direction * s.direction.dot(middle - s.center), u = s.direction.unitOrthogonal(),
             v = s.direction.cross(u);
  const Vec3 corner = foot - 0.5 * size * (u + v), along_u = corner + size * u, along_v = corner + size * v;
  vtkNew<vtkPlaneSource> source;
  source->SetOrigin(corner.x(), corner.y(), corner.z());
  source->SetPoint1(along_u.x(), along_u.y(), along_u.z());
  source->SetPoint2(along_v.x(), along_v.y(), along_v.z());
  source->Update();
  return source->GetOutput();
}

Shape cylinder(const Surface& s, const Vec3& middle, double size) {
  const bool ends = s.half_length > 0;
  const Vec3 center = ends ? s.center : Vec3(s.center + s.direction * s.direction.dot(middle - s.center)),
             half = (ends ? s.half_length : 0.5 * size) * s.direction, first = center - half, last = center + half;
  vtkNew<vtkLineSource> line;
  line->SetPoint1(first.x(), first.y(), first.z());
  line->SetPoint2(last.x(), last.y(), last.z());
  vtkNew<vtkTubeFilter> tube;
  tube->SetInputConnection(line->GetOutputPort());
  tube->SetRadius(s.radius);
  tube->SetNumberOfSides(n_sides);
  tube->Update();
  if (!ends) return tube->GetOutput();
  return joined({tube->GetOutput(), sphere(first, s.radius), sphere(last, s.radius)});
}

Shape box(const Surface& s) {
  vtkNew<vtkCubeSource> source;
  source->SetCenter(s.center.x(), s.center.y(), s.center.z());
  source->SetXLength(2 * s.half_size.x());
  source->SetYLength(2 * s.half_size.y());
  source->SetZLength(2 * s.half_size.z());
  source->Update();
  return source->GetOutput();
}

Shape mesh(const Surface& s) {
  const Triangles& t = s.mesh->triangles();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vec3& p : t.points) points->InsertNextPoint(Vec3(s.center + s.unit * p).data());
  vtkNew<vtkCellArray> cells;
  for (const auto& [a, b, c] : t.corners) cells->InsertNextCell({a, b, c});
  Shape shape = Shape::New();
  shape->SetPoints(points);
  shape->SetPolys(cells);
  return shape;
}

Shape in_frame_of_body(const Surface& s, const Vec3& middle, double size) {
  switch (s.shape) {
    case SurfaceShape::plane: return plane(s, middle, size);
    case SurfaceShape::cylinder: return cylinder(s, middle, size);
    case SurfaceShape::sphere: return sphere(s.center, s.radius);
    case SurfaceShape::box: return box(s);
    case SurfaceShape::mesh: return mesh(s);
  }
  return Shape::New();
}

/// A plane that touches as its stage begins, and what waits for another stage, is there from then on.
bool is_there_in(const SurfaceSpec& spec, const Scene& scene, const std::string& stage) {
  if (spec.from_stage.empty()) return true;  // before the first stage, too
  const std::size_t now = stage_number(scene, stage);
  return now < scene.stages.size() && now >= first_stage(scene, spec);
}

std::optional<Scene> scene_of(const SnapshotHeader& header) {
  try {
    return parse_scene(header.scene_text, header.scene_name);
  } catch (const InputError&) {
    return std::nullopt;  // of another version, or of no run
  }
}

std::vector<PlacedSurface> surfaces_in(const Scene& scene, const SnapshotHeader& header, const Increment& increment) {
  std::vector<PlacedSurface> placed;
  const NameTable names(header.body_names);
  for (const BodySpec& body : scene.bodies) {
    const std::optional<Index> b = names.find(body.name);
    if (!b || *b >= static_cast<Index>(increment.bodies.position.size())) continue;
    for (const SurfaceSpec& spec : body.surfaces)
      if (is_there_in(spec, scene, increment.stage))
        placed.push_back({*b, spec.surface, increment.bodies.position[*b], increment.bodies.rotation[*b]});
  }
  return placed;
}

/// Box of all copies. The surfaces of a cell are planes that lie level: they need no copies.
Eigen::AlignedBox3d extent_of_copies(const SnapshotHeader& header, const Increment& increment, const Copies& copies) {
  const Periods periods = periods_of(header, increment);
  const Eigen::AlignedBox3d cell = extent_of(header.mesh, increment.fibers);
  Eigen::AlignedBox3d extent = cell;
  for (const CopyNumber& number : copy_numbers(copies)) {
    const Vec3 by = displacement_of(number, periods);
    extent.extend(Eigen::AlignedBox3d(cell.min() + by, cell.max() + by));
  }
  return extent;
}

}  // namespace

std::vector<PlacedSurface> surfaces_of(const SnapshotHeader& header, const Increment& increment) {
  const std::optional<Scene> scene = scene_of(header);
  return scene ? surfaces_in(*scene, header, increment) : std::vector<PlacedSurface>();
}

Eigen::AlignedBox3d extent_of(const FiberMesh& mesh, const FiberConfiguration& fibers) {
  Eigen::AlignedBox3d extent;
  for (const Vec3& r : fibers.r) extent.extend(r);
  const Vec3 radius = Vec3::Constant(*std::max_element(mesh.radius.begin(), mesh.radius.end()));
  return {extent.min() - radius, extent.max() + radius};
}

vtkSmartPointer<vtkPolyData> shape_of(const PlacedSurface& placed, const Eigen::AlignedBox3d& around) {
  const Mat3& r = placed.rotation;
  const Vec3 middle = r.transpose() * (around.center() - placed.position);
  const double size = (1 + 2 * beyond) * around.sizes().maxCoeff();
  vtkNew<vtkMatrix4x4> matrix;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) matrix->SetElement(i, j, r(i, j));
    matrix->SetElement(i, 3, placed.position[i]);
  }
  vtkNew<vtkTransform> pose;
  pose->SetMatrix(matrix);
  vtkNew<vtkTransformPolyDataFilter> move;
  move->SetInputData(in_frame_of_body(placed.surface, middle, size));
  move->SetTransform(pose);
  move->SetOutputPointsPrecision(vtkAlgorithm::DOUBLE_PRECISION);
  move->Update();
  return move->GetOutput();
}

void write_surfaces_vtk(const SnapshotReader& states, const std::filesystem::path& folder, const Copies& copies) {
  const SnapshotHeader& header = states.header();
  const std::optional<Scene> scene = scene_of(header);
  const auto has_any = [](const BodySpec& body) { return !body.surfaces.empty(); };
  if (!scene || std::none_of(scene->bodies.begin(), scene->bodies.end(), has_any)) return;
  VtkSeries series(folder, "surfaces", "vtp");
  for (Index i = 0; i < states.n_increments(); ++i) {
    const Increment increment = states.read(i);
    const Eigen::AlignedBox3d around = extent_of_copies(header, increment, copies);
    vtkNew<vtkAppendPolyData> all;
    all->AddInputData(vtkSmartPointer<vtkPolyData>::New());  // there may be none yet
    for (const PlacedSurface& placed : surfaces_in(*scene, header, increment)) {
      const Shape shape = shape_of(placed, around);
      add_array(shape->GetCellData(), "body", std::vector<Index>(shape->GetNumberOfCells(), placed.body));
      all->AddInputData(shape);
    }
    all->Update();
    add_load(all->GetOutput(), increment.stage, increment.stage_time);
    vtkNew<vtkXMLPolyDataWriter> writer;
    writer->SetInputData(all->GetOutput());
    series.add(i, writer);
  }
}

}  // namespace trame::micro
