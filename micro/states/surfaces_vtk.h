#pragma once
/// \file
/// Rigid surfaces for ParaView: `surfaces.pvd`, a time series of `surfaces_NNNN.vtp` beside that of the fibers, with
/// the number of the body on cells; in m. What has no end is drawn as far as the fibers reach.

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <vector>

#include "micro/rigid/surface.h"
#include "micro/states/cell_copies.h"

namespace trame::micro {

/// A surface of a body in a state, in the frame of the body at `position`, m.
struct PlacedSurface {
  Index body = 0;
  Surface surface;
  Vec3 position = Vec3::Zero();
  Mat3 rotation = Mat3::Identity();
};

/// The surfaces that are there in a state; none where the scene that stands with the states cannot be read.
[[nodiscard]] std::vector<PlacedSurface> surfaces_of(const SnapshotHeader& header, const Increment& increment);

/// As a mesh. `around`: what the fibers take up, m.
[[nodiscard]] vtkSmartPointer<vtkPolyData> shape_of(const PlacedSurface& placed, const Eigen::AlignedBox3d& around);

/// Box of all nodes, wider by the largest radius.
[[nodiscard]] Eigen::AlignedBox3d extent_of(const FiberMesh& mesh, const FiberConfiguration& fibers);

/// Writes the surfaces of every increment of a state file, where there are any, as far as `copies` of a cell reach.
/// Throws InputError or WriteError.
void write_surfaces_vtk(const SnapshotReader& states, const std::filesystem::path& folder,
                        const Copies& copies = one_cell);

}  // namespace trame::micro
