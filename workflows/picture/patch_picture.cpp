#include "workflows/picture/patch_picture.h"

#include <fmt/format.h>
#include <vtkActor.h>
#include <vtkActor2D.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkImageShrink3D.h>
#include <vtkLight.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkPNGWriter.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty.h>
#include <vtkProperty2D.h>
#include <vtkRenderState.h>
#include <vtkRenderStepsPass.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSSAOPass.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkTextureObject.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>
#include <vtk_glew.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "micro/core/whole_file.h"
#include "workflows/picture/continued_cell.h"
#include "workflows/picture/picture_frame.h"

namespace trame::workflows {
namespace {

constexpr int oversampling = 2;      // pixels drawn for a pixel written, each way
constexpr double longest_bar = 0.2;  // of the picture's width
/// Of a drawn pixel; blurred over 4 × 4 pixels and shrunk, a written pixel sees many more. Their number is what a
/// picture costs where the processor draws.
constexpr int n_occlusion_samples = 24;
const Vec3 ink(0.15, 0.15, 0.15);

std::vector<Vec3> points_of(const std::vector<vtkPolyData*>& shapes) {
  std::vector<Vec3> points;
  for (vtkPolyData* shape : shapes)
    for (vtkIdType i = 0; i < shape->GetNumberOfPoints(); ++i) points.emplace_back(shape->GetPoint(i));
  return points;
}

vtkNew<vtkActor> actor_of(vtkPolyData* shape) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(shape);
  mapper->SetScalarModeToUsePointFieldData();
  mapper->SelectColorArray(colour_array);
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  return actor;
}

void add_tubes(vtkRenderer* renderer, vtkPolyData* tubes, double ambient) {
  const auto actor = actor_of(tubes);
  actor->GetProperty()->SetAmbient(ambient);
  actor->GetProperty()->SetDiffuse(1.1 - ambient);
  actor->GetProperty()->SetSpecular(0.12);
  actor->GetProperty()->SetSpecularPower(25);
  renderer->AddActor(actor);
}

/// Flat colours, unlit, moved toward the camera by `lift` so that they win over what lies in the same plane.
void add_flat(vtkRenderer* renderer, vtkPolyData* shape, const Vec3& lift) {
  const auto actor = actor_of(shape);
  actor->GetProperty()->LightingOff();
  actor->GetProperty()->SetLineWidth(1.0F * oversampling);
  actor->SetPosition(lift.x(), lift.y(), lift.z());
  renderer->AddActor(actor);
}

/// A light that moves with the camera; `direction` is where it comes from, in the camera's x, y, z.
void add_light(vtkRenderer* renderer, const Vec3& direction, double intensity) {
  vtkNew<vtkLight> light;
  light->SetLightTypeToCameraLight();
  light->SetPosition(direction.x(), direction.y(), direction.z());
  light->SetFocalPoint(0, 0, 0);
  light->SetIntensity(intensity);
  renderer->AddLight(light);
}

void set_camera(vtkRenderer* renderer, const Frame& frame) {
  vtkCamera* camera = renderer->GetActiveCamera();
  const Vec3 position = frame.focal_point + frame.distance * frame.backward;
  const double half_height = 0.5 * frame.height * frame.pixel;
  camera->SetFocalPoint(frame.focal_point.data());
  camera->SetPosition(position.data());
  camera->SetViewUp(frame.up.data());
  camera->SetParallelProjection(frame.parallel);
  camera->SetParallelScale(half_height);
  camera->SetViewAngle(360 / M_PI * std::atan(half_height / frame.distance));
  renderer->ResetCameraClippingRange();
}

/// VTK's ambient occlusion keeps positions in 16 bits, of which steps of 1/2000 of the camera's distance remain: as
/// much as a fiber's radius, seen from where a whole patch fits into the picture. This one keeps them in 32 bits.
class OcclusionPass : public vtkSSAOPass {
 public:
  static OcclusionPass* New();
  vtkTypeMacro(OcclusionPass, vtkSSAOPass);

  void Render(const vtkRenderState* state) override {
    auto* window = vtkOpenGLRenderWindow::SafeDownCast(state->GetRenderer()->GetRenderWindow());
    if (PositionTexture == nullptr) make_position_texture(window);
    vtkSSAOPass::Render(state);
  }

 private:
  void make_position_texture(vtkOpenGLRenderWindow* window) {
    PositionTexture = vtkTextureObject::New();
    PositionTexture->SetContext(window);
    PositionTexture->SetFormat(GL_RGBA);
    PositionTexture->SetInternalFormat(GL_RGBA32F);
    PositionTexture->SetDataType(GL_FLOAT);
    PositionTexture->SetWrapS(vtkTextureObject::ClampToEdge);
    PositionTexture->SetWrapT(vtkTextureObject::ClampToEdge);
    const int* size = window->GetSize();
    PositionTexture->Allocate2D(size[0], size[1], 4, VTK_FLOAT);
  }
};
vtkStandardNewMacro(OcclusionPass);

/// Darkens crevices, as far as light from a distance of `radius` is kept out.
void add_ambient_occlusion(vtkRenderer* renderer, double radius) {
  vtkNew<vtkRenderStepsPass> steps;
  vtkNew<OcclusionPass> occlusion;
  occlusion->SetDelegatePass(steps);
  occlusion->SetRadius(radius);
  occlusion->SetBias(0.05 * radius);
  occlusion->SetKernelSize(n_occlusion_samples);
  occlusion->BlurOn();
  renderer->SetPass(occlusion);
}

void add_scale_bar(vtkRenderer* renderer, const Frame& frame) {
  const double width = oversampling * frame.width;
  const ScaleBar bar = choose_scale_bar(longest_bar * frame.width * frame.pixel);
  const double length = oversampling * bar.length / frame.pixel, thickness = 0.004 * width;
  const double left = picture_margin * width, bottom = picture_margin * width;
  vtkNew<vtkPoints> corners;
  for (const Vec2& corner : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)})
    corners->InsertNextPoint(left + corner.x() * length, bottom + corner.y() * thickness, 0);
  vtkNew<vtkCellArray> cells;
  const std::array<vtkIdType, 4> quad = {0, 1, 2, 3};
  cells->InsertNextCell(4, quad.data());
  vtkNew<vtkPolyData> rectangle;
  rectangle->SetPoints(corners);
  rectangle->SetPolys(cells);
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(rectangle);
  vtkNew<vtkActor2D> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(ink.x(), ink.y(), ink.z());
  renderer->AddActor2D(actor);

  vtkNew<vtkTextActor> text;
  text->SetInput(bar.text.c_str());
  text->GetTextProperty()->SetFontSize(static_cast<int>(0.024 * width));
  text->GetTextProperty()->SetColor(ink.x(), ink.y(), ink.z());
  text->GetTextProperty()->SetVerticalJustificationToBottom();
  text->SetPosition(left, bottom + 2 * thickness);
  renderer->AddActor2D(text);
}

void write_png(vtkRenderWindow* window, const std::filesystem::path& file) {
  vtkNew<vtkWindowToImageFilter> image;
  image->SetInput(window);
  image->ReadFrontBufferOff();
  vtkNew<vtkImageShrink3D> shrink;
  shrink->SetInputConnection(image->GetOutputPort());
  shrink->SetShrinkFactors(oversampling, oversampling, 1);
  shrink->MeanOn();
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputConnection(shrink->GetOutputPort());
  writer->WriteToMemoryOn();
  writer->Write();
  vtkUnsignedCharArray* png = writer->GetResult();
  micro::write_whole_file(
      file, {reinterpret_cast<const char*>(png->GetPointer(0)), static_cast<std::size_t>(png->GetNumberOfValues())});
}

double mean_radius(const micro::FiberMesh& mesh) {
  double sum = 0;
  for (const double radius : mesh.radius) sum += radius;
  return sum / mesh.n_fibers() / micrometre;
}

/// A closed line around the cell, µm: at the fibers' middle height where they are seen from above, and around what a
/// cut meets of the cell, if anything.
std::vector<Vec3> cell_line(const std::array<Vec3, 4>& cell, const PictureOptions& options, double bottom, double top) {
  std::vector<Vec3> line;
  if (options.view != View::cut) {
    for (const Vec3& corner : cell)
      line.emplace_back(corner.x() / micrometre, corner.y() / micrometre, 0.5 * (bottom + top));
    return line;
  }
  const int axis = options.cut.axis, along = 1 - axis;
  std::vector<double> sides;
  for (std::size_t i = 0; i < cell.size(); ++i) {
    const Vec3 &a = cell[i], &b = cell[(i + 1) % cell.size()];
    const double before = a[axis] - options.cut.position, after = b[axis] - options.cut.position;
    if ((before < 0) != (after < 0)) sides.push_back((a + before / (before - after) * (b - a))[along] / micrometre);
  }
  if (sides.size() != 2) return {};
  Vec3 corner = options.cut.position / micrometre * Vec3::Unit(axis);
  for (const Vec2& xz : {Vec2(sides[0], bottom), Vec2(sides[1], bottom), Vec2(sides[1], top), Vec2(sides[0], top)}) {
    corner[along] = xz.x();
    corner.z() = xz.y();
    line.push_back(corner);
  }
  return line;
}

void add_closed_line(vtkRenderer* renderer, const std::vector<Vec3>& corners, const Vec3& colour, double n_pixels) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> lines;
  lines->InsertNextCell(static_cast<vtkIdType>(corners.size() + 1));
  for (const Vec3& corner : corners) lines->InsertCellPoint(points->InsertNextPoint(corner.data()));
  lines->InsertCellPoint(0);
  vtkNew<vtkPolyData> loop;
  loop->SetPoints(points);
  loop->SetLines(lines);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(loop);
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->LightingOff();
  actor->GetProperty()->SetColor(colour.x(), colour.y(), colour.z());
  actor->GetProperty()->SetLineWidth(static_cast<float>(n_pixels * oversampling));
  renderer->AddActor(actor);
}

/// What is seen, and around what.
struct Seen {
  std::vector<Vec3> points;  ///< µm
  Vec3 backward, up;
  bool parallel = true;
};

/// Adds the fibers and surfaces that the view shows.
Seen add_patch(vtkRenderer* renderer, const Patch& patch, const PictureOptions& options) {
  const Eigen::AlignedBox3d around = micro::extent_of(patch.mesh, patch.fibers);
  if (options.view == View::cut) {
    const CutPatch cut = cut_patch(patch.mesh, patch.fibers, options.cut);
    const Vec3 backward = -view_direction(options.cut);
    const double step = 1e-2 * mean_radius(patch.mesh);
    add_tubes(renderer, cut.behind, 0.55);
    add_flat(renderer, cut.faces, step * backward);
    add_flat(renderer, cut.outlines, 2 * step * backward);
    add_flat(renderer, surface_outlines(patch.surfaces, around, options.cut), 2 * step * backward);
    return {points_of({cut.behind, cut.faces}), backward, Vec3::UnitZ(), true};
  }
  const auto tubes = fiber_tubes(patch.mesh, patch.fibers);
  add_tubes(renderer, tubes, 0.28);
  add_tubes(renderer, surface_shapes(patch.surfaces, around), 0.28);
  const bool top = options.view == View::top;
  return {points_of({tubes}), top ? Vec3::UnitZ() : Vec3(-0.45, -0.9, 0.85), top ? Vec3::UnitY() : Vec3::UnitZ(), top};
}

/// Adds the line around the cell, which then is among what is seen.
void add_cell(vtkRenderer* renderer, const Patch& patch, const PictureOptions& options, Seen& seen) {
  if (!patch.cell) return;
  const auto [low, high] = std::minmax_element(seen.points.begin(), seen.points.end(),
                                               [](const Vec3& p, const Vec3& q) { return p.z() < q.z(); });
  const double gap = mean_radius(patch.mesh);
  const std::vector<Vec3> line = cell_line(*patch.cell, options, low->z() - gap, high->z() + gap);
  if (line.empty()) return;
  add_closed_line(renderer, line, Vec3::Ones(), 3.5);  // sets it off from dark fibers
  add_closed_line(renderer, line, ink, 1.5);
  seen.points.insert(seen.points.end(), line.begin(), line.end());
}

}  // namespace

Patch patch_of(const micro::SnapshotHeader& header, const micro::Increment& state,
               const std::optional<micro::Copies>& copies) {
  const micro::Periods periods = micro::periods_of(header, state);
  const std::array<bool, 2> is_periodic = micro::is_periodic(periods);
  if (copies) micro::check_copies(*copies, is_periodic);
  ContinuedCell drawn =
      continued_cell(header.mesh, state.fibers, periods, copies ? *copies : micro::copies_to_show(is_periodic));
  return {std::move(drawn.mesh), std::move(drawn.fibers), micro::surfaces_of(header, state),
          cell_outline(header.mesh, state.fibers, periods)};
}

void write_picture(const Patch& patch, const PictureOptions& options, const std::filesystem::path& file) {
  vtkNew<vtkRenderer> fibers, notes;
  Seen seen = add_patch(fibers, patch, options);
  add_cell(notes, patch, options, seen);
  const Frame frame = fit_frame(seen.points, seen.backward, seen.up, seen.parallel, options.width);
  fibers->SetBackground(1, 1, 1);
  set_camera(fibers, frame);
  add_light(fibers, Vec3(-0.4, 0.6, 1), 0.78);
  add_light(fibers, Vec3(0.5, -0.5, 1), 0.35);
  add_ambient_occlusion(fibers, 4 * mean_radius(patch.mesh));
  notes->SetLayer(1);  // on its own, so that no shadow falls on it
  set_camera(notes, frame);
  add_scale_bar(notes, frame);

  vtkNew<vtkRenderWindow> window;
  window->SetOffScreenRendering(1);
  window->SetMultiSamples(0);
  window->SetNumberOfLayers(2);
  window->SetSize(oversampling * frame.width, oversampling * frame.height);
  window->AddRenderer(fibers);
  window->AddRenderer(notes);
  window->Render();
  write_png(window, file);
}

}  // namespace trame::workflows
