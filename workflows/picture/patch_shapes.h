#pragma once
/// \file
/// Fibers as surfaces to draw: tubes around their centre lines, and what a plane leaves of them. Lengths in µm.

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <vector>

#include "micro/fiber/fiber_mesh.h"
#include "micro/states/surfaces_vtk.h"

namespace trame::workflows {

constexpr double micrometre = 1e-6;  ///< m

/// Point array of the RGB colours of a shape, 0…255.
constexpr const char* colour_array = "colour";

/// The plane where the coordinate along `axis` (0: x, 1: y) is `position`, m.
struct CutPlane {
  int axis = 0;
  double position = 0;
};

/// A patch cut open. Of the two halves the one on the far side is left, seen along `view_direction`.
struct CutPatch {
  vtkSmartPointer<vtkPolyData> behind;    ///< tubes, paler with distance
  vtkSmartPointer<vtkPolyData> faces;     ///< sections of the fibers, flat
  vtkSmartPointer<vtkPolyData> outlines;  ///< of these sections, closed lines
};

/// RGB colours of the fibers, 0…1: blue warp, orange weft, green others, shades from yarn to yarn, and fainter ones
/// from fiber to fiber so that neighbours stand apart.
[[nodiscard]] std::vector<Vec3> fiber_colours(const micro::FiberMesh& mesh);

/// All fibers as closed tubes of their radius.
[[nodiscard]] vtkSmartPointer<vtkPolyData> fiber_tubes(const micro::FiberMesh& mesh,
                                                       const micro::FiberConfiguration& fibers);

/// What a viewer sees who looks along the plane's normal: along −x at a plane x = const, along +y at y = const, so that
/// the other horizontal axis points to the right. Throws InputError where the plane cuts no fiber.
[[nodiscard]] CutPatch cut_patch(const micro::FiberMesh& mesh, const micro::FiberConfiguration& fibers,
                                 const CutPlane& plane);

/// Surfaces as grey meshes, without planes.
[[nodiscard]] vtkSmartPointer<vtkPolyData> surface_shapes(const std::vector<micro::PlacedSurface>& surfaces,
                                                          const Eigen::AlignedBox3d& around);
/// What a cut leaves of them, and of planes: dark lines.
[[nodiscard]] vtkSmartPointer<vtkPolyData> surface_outlines(const std::vector<micro::PlacedSurface>& surfaces,
                                                            const Eigen::AlignedBox3d& around, const CutPlane& plane);

/// Unit vector along which a cut is looked at.
[[nodiscard]] Vec3 view_direction(const CutPlane& plane);

}  // namespace trame::workflows
