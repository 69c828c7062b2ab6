#include "workflows/picture/patch_shapes.h"

#include <fmt/format.h>
#include <vtkAppendPolyData.h>
#include <vtkCellArray.h>
#include <vtkClipPolyData.h>
#include <vtkContourTriangulator.h>
#include <vtkCutter.h>
#include <vtkNew.h>
#include <vtkPlane.h>
#include <vtkPointData.h>
#include <vtkStripper.h>
#include <vtkTransform.h>
#include <vtkTransformPolyDataFilter.h>
#include <vtkTubeFilter.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "micro/core/error.h"

namespace trame::workflows {
namespace {

using micro::FiberConfiguration;
using micro::FiberMesh;
using Shape = vtkSmartPointer<vtkPolyData>;

constexpr int n_pieces = 2;                // straight pieces between two nodes
constexpr double palest = 0.62;            // share of white in what is farthest behind a cut
constexpr double outline_darkness = 0.55;  // share of black in outlines

/// Point at t ∈ [0, 1] between nodes n and n + 1: the cubic with the nodes' positions and tangents, which is the rod's
/// own curve and smooth from element to element for enriched beams.
Vec3 between_nodes(const FiberMesh& mesh, const FiberConfiguration& fibers, Index n, double t) {
  const double h = mesh.arc_length[n + 1] - mesh.arc_length[n];
  return (1 - t) * (1 - t) * (1 + 2 * t) * fibers.r[n] + t * t * (3 - 2 * t) * fibers.r[n + 1] +
         h * t * (1 - t) * ((1 - t) * fibers.tangent[n] - t * fibers.tangent[n + 1]);
}

Shape centre_line(const FiberMesh& mesh, const FiberConfiguration& fibers, Index fiber) {
  vtkNew<vtkPoints> points;
  const auto add = [&](const Vec3& x) { points->InsertNextPoint((x / micrometre).eval().data()); };
  const Index first = mesh.first_node[fiber], last = mesh.first_node[fiber + 1] - 1;
  for (Index n = first; n < last; ++n)
    for (int i = 0; i < n_pieces; ++i) add(between_nodes(mesh, fibers, n, static_cast<double>(i) / n_pieces));
  add(fibers.r[last]);
  vtkNew<vtkCellArray> lines;
  lines->InsertNextCell(points->GetNumberOfPoints());
  for (vtkIdType i = 0; i < points->GetNumberOfPoints(); ++i) lines->InsertCellPoint(i);
  auto line = Shape::New();
  line->SetPoints(points);
  line->SetLines(lines);
  return line;
}

/// Gives every point the colour `colour_at(point)`.
template <class ColourAt>
void paint(vtkPolyData* shape, ColourAt&& colour_at) {
  vtkNew<vtkUnsignedCharArray> colours;
  colours->SetName(colour_array);
  colours->SetNumberOfComponents(3);
  colours->SetNumberOfTuples(shape->GetNumberOfPoints());
  for (vtkIdType i = 0; i < shape->GetNumberOfPoints(); ++i) {
    const Vec3 colour = 255 * colour_at(Vec3(shape->GetPoint(i)));
    for (int c = 0; c < 3; ++c) colours->SetTypedComponent(i, c, static_cast<unsigned char>(std::lround(colour[c])));
  }
  shape->GetPointData()->AddArray(colours);
}

/// Sides of a tube: in a large patch a fiber is but a few pixels wide.
int n_sides(const FiberMesh& mesh) { return mesh.n_fibers() > 200 ? 12 : 24; }

Shape fiber_tube(const FiberMesh& mesh, const FiberConfiguration& fibers, Index fiber) {
  vtkNew<vtkTubeFilter> tube;
  tube->SetInputData(centre_line(mesh, fibers, fiber));
  tube->SetRadius(mesh.radius[fiber] / micrometre);
  tube->SetNumberOfSides(n_sides(mesh));
  tube->CappingOn();
  tube->Update();
  return tube->GetOutput();
}

Vec3 mix(double share, const Vec3& a, const Vec3& b) { return (1 - share) * a + share * b; }

/// Lowest and highest coordinate of a shape along `axis`.
std::array<double, 2> extent(vtkPolyData* shape, int axis) {
  const double* bounds = shape->GetBounds();
  return {bounds[2 * axis], bounds[2 * axis + 1]};
}

Shape clipped(vtkPolyData* tube, vtkPlane* plane) {
  vtkNew<vtkClipPolyData> clip;
  clip->SetInputData(tube);
  clip->SetClipFunction(plane);
  clip->Update();
  return clip->GetOutput();
}

/// The closed lines in which the plane meets a tube.
Shape outline(vtkPolyData* tube, vtkPlane* plane) {
  vtkNew<vtkCutter> cutter;
  cutter->SetInputData(tube);
  cutter->SetCutFunction(plane);
  cutter->GenerateTrianglesOff();
  vtkNew<vtkStripper> loops;
  loops->SetInputConnection(cutter->GetOutputPort());
  loops->SetMaximumLength(100'000);  // the most it takes: a loop in one piece, even of a fiber that lies in the plane
  loops->Update();
  return loops->GetOutput();
}

Shape filled(vtkPolyData* loops) {
  vtkNew<vtkContourTriangulator> triangulator;
  triangulator->SetInputData(loops);
  triangulator->Update();
  return triangulator->GetOutput();
}

Shape joined(const std::vector<Shape>& shapes) {
  vtkNew<vtkAppendPolyData> append;
  for (const Shape& shape : shapes) append->AddInputData(shape);
  append->Update();
  return append->GetOutput();
}

std::vector<Shape> uncoloured_tubes(const FiberMesh& mesh, const FiberConfiguration& fibers) {
  std::vector<Shape> tubes;
  for (Index f = 0; f < mesh.n_fibers(); ++f) tubes.push_back(fiber_tube(mesh, fibers, f));
  return tubes;
}

/// Range of the tubes along `axis`, with the plane's position checked against it.
std::array<double, 2> checked_extent(const std::vector<Shape>& tubes, const CutPlane& plane) {
  std::array<double, 2> all = extent(tubes.front(), plane.axis);
  bool cuts = false;
  const double position = plane.position / micrometre;
  for (const Shape& tube : tubes) {
    const auto [low, high] = extent(tube, plane.axis);
    all = {std::min(all[0], low), std::max(all[1], high)};
    cuts = cuts || (low < position && position < high);
  }
  if (!cuts)
    throw InputError(fmt::format("--at {}={:g}um: cuts no fiber; fibers lie between {:g}um and {:g}um",
                                 plane.axis == 0 ? 'x' : 'y', position, all[0], all[1]));
  return all;
}

}  // namespace

std::vector<Vec3> fiber_colours(const FiberMesh& mesh) {
  static const std::array<Vec3, 3> family_colour = {Vec3(0.16, 0.42, 0.70), Vec3(0.92, 0.56, 0.18),
                                                    Vec3(0.30, 0.60, 0.44)};
  std::vector<Vec3> colours(mesh.n_fibers());
  std::array<int, 3> n_yarns_so_far{};
  for (const micro::Yarn& yarn : mesh.yarns) {
    const auto family = static_cast<std::size_t>(yarn.family);
    const double yarn_white = n_yarns_so_far[family]++ % 2 == 0 ? 0.0 : 0.22;
    for (Index i = 0; i < yarn.n_fibers; ++i) {
      const double golden = std::fmod(0.6180339887 * i, 1.0);  // spreads over 0…1, far from one fiber to the next
      colours[yarn.first_fiber + i] = mix(yarn_white + 0.16 * golden, family_colour[family], Vec3::Ones());
    }
  }
  return colours;
}

Shape fiber_tubes(const FiberMesh& mesh, const FiberConfiguration& fibers) {
  const std::vector<Vec3> colours = fiber_colours(mesh);
  const std::vector<Shape> tubes = uncoloured_tubes(mesh, fibers);
  for (Index f = 0; f < mesh.n_fibers(); ++f) paint(tubes[f], [&](const Vec3&) { return colours[f]; });
  return joined(tubes);
}

namespace {

Shape in_micrometres(const Shape& shape) {
  vtkNew<vtkTransform> scale;
  scale->Scale(1 / micrometre, 1 / micrometre, 1 / micrometre);
  vtkNew<vtkTransformPolyDataFilter> filter;
  filter->SetInputData(shape);
  filter->SetTransform(scale);
  filter->Update();
  return filter->GetOutput();
}

/// What `shape_of_surface` makes of each of the surfaces, in one colour.
template <class ShapeOf>
Shape joined_surfaces(const std::vector<micro::PlacedSurface>& surfaces, const Vec3& colour,
                      ShapeOf&& shape_of_surface) {
  std::vector<Shape> shapes = {Shape::New()};
  for (const micro::PlacedSurface& surface : surfaces)
    if (Shape shape = shape_of_surface(surface)) shapes.push_back(shape);
  for (const Shape& shape : shapes) paint(shape, [&](const Vec3&) { return colour; });
  return joined(shapes);
}

}  // namespace

vtkSmartPointer<vtkPolyData> surface_shapes(const std::vector<micro::PlacedSurface>& surfaces,
                                            const Eigen::AlignedBox3d& around) {
  return joined_surfaces(surfaces, Vec3::Constant(0.72), [&](const micro::PlacedSurface& surface) -> Shape {
    return surface.surface.shape == micro::SurfaceShape::plane ? nullptr : in_micrometres(shape_of(surface, around));
  });
}

vtkSmartPointer<vtkPolyData> surface_outlines(const std::vector<micro::PlacedSurface>& surfaces,
                                              const Eigen::AlignedBox3d& around, const CutPlane& plane) {
  const Vec3 origin = plane.position / micrometre * Vec3::Unit(plane.axis), ahead = view_direction(plane);
  vtkNew<vtkPlane> vtk_plane;
  vtk_plane->SetOrigin(origin.data());
  vtk_plane->SetNormal(ahead.data());
  return joined_surfaces(surfaces, Vec3::Constant(0.2), [&](const micro::PlacedSurface& surface) -> Shape {
    vtkNew<vtkCutter> cutter;
    cutter->SetInputData(in_micrometres(shape_of(surface, around)));
    cutter->SetCutFunction(vtk_plane);
    cutter->Update();
    return cutter->GetOutput();
  });
}

Vec3 view_direction(const CutPlane& plane) { return plane.axis == 0 ? Vec3(-1, 0, 0) : Vec3(0, 1, 0); }

CutPatch cut_patch(const FiberMesh& mesh, const FiberConfiguration& fibers, const CutPlane& plane) {
  const std::vector<Vec3> colours = fiber_colours(mesh);
  const std::vector<Shape> tubes = uncoloured_tubes(mesh, fibers);
  const auto [low, high] = checked_extent(tubes, plane);
  const Vec3 ahead = view_direction(plane), origin = plane.position / micrometre * Vec3::Unit(plane.axis);
  const double depth = ahead[plane.axis] > 0 ? high - origin[plane.axis] : origin[plane.axis] - low;
  vtkNew<vtkPlane> vtk_plane;
  vtk_plane->SetOrigin(origin.data());
  vtk_plane->SetNormal(ahead.data());

  std::vector<Shape> behind, faces, outlines;
  for (Index f = 0; f < mesh.n_fibers(); ++f) {
    behind.push_back(clipped(tubes[f], vtk_plane));
    outlines.push_back(outline(tubes[f], vtk_plane));
    faces.push_back(filled(outlines.back()));
    paint(behind.back(), [&](const Vec3& x) {
      return mix(palest * std::sqrt(std::clamp(ahead.dot(x - origin) / depth, 0.0, 1.0)), colours[f], Vec3::Ones());
    });
    paint(faces.back(), [&](const Vec3&) { return colours[f]; });
    paint(outlines.back(), [&](const Vec3&) { return mix(outline_darkness, colours[f], Vec3::Zero()); });
  }
  return {joined(behind), joined(faces), joined(outlines)};
}

}  // namespace trame::workflows
