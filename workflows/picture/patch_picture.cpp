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

#include <array>
#include <cmath>

#include "micro/core/whole_file.h"
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

/// Adds what the view shows and returns its frame.
Frame add_patch(vtkRenderer* renderer, const micro::FiberMesh& mesh, const micro::FiberConfiguration& fibers,
                const std::vector<micro::PlacedSurface>& surfaces, const PictureOptions& options) {
  const Eigen::AlignedBox3d around = micro::extent_of(mesh, fibers);
  if (options.view == View::cut) {
    const CutPatch patch = cut_patch(mesh, fibers, options.cut);
    const Vec3 backward = -view_direction(options.cut);
    const double step = 1e-2 * mean_radius(mesh);
    add_tubes(renderer, patch.behind, 0.55);
    add_flat(renderer, patch.faces, step * backward);
    add_flat(renderer, patch.outlines, 2 * step * backward);
    add_flat(renderer, surface_outlines(surfaces, around, options.cut), 2 * step * backward);
    return fit_frame(points_of({patch.behind, patch.faces}), backward, Vec3::UnitZ(), true, options.width);
  }
  const auto tubes = fiber_tubes(mesh, fibers);
  add_tubes(renderer, tubes, 0.28);
  add_tubes(renderer, surface_shapes(surfaces, around), 0.28);
  const bool top = options.view == View::top;
  const Vec3 backward = top ? Vec3::UnitZ() : Vec3(-0.45, -0.9, 0.85);
  return fit_frame(points_of({tubes}), backward, top ? Vec3::UnitY() : Vec3::UnitZ(), top, options.width);
}

}  // namespace

void write_picture(const micro::FiberMesh& mesh, const micro::FiberConfiguration& fibers,
                   const std::vector<micro::PlacedSurface>& surfaces, const PictureOptions& options,
                   const std::filesystem::path& file) {
  vtkNew<vtkRenderer> patch, notes;
  const Frame frame = add_patch(patch, mesh, fibers, surfaces, options);
  patch->SetBackground(1, 1, 1);
  set_camera(patch, frame);
  add_light(patch, Vec3(-0.4, 0.6, 1), 0.78);
  add_light(patch, Vec3(0.5, -0.5, 1), 0.35);
  add_ambient_occlusion(patch, 4 * mean_radius(mesh));
  notes->SetLayer(1);  // on its own, so that no shadow falls on it
  add_scale_bar(notes, frame);

  vtkNew<vtkRenderWindow> window;
  window->SetOffScreenRendering(1);
  window->SetMultiSamples(0);
  window->SetNumberOfLayers(2);
  window->SetSize(oversampling * frame.width, oversampling * frame.height);
  window->AddRenderer(patch);
  window->AddRenderer(notes);
  window->Render();
  write_png(window, file);
}

}  // namespace trame::workflows
