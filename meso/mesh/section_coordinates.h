#pragma once
/// \file
/// A yarn unrolled: where its fiber nodes are in the section, and how far along it.

#include <vector>

#include "micro/fiber/fiber_mesh.h"

namespace trame::meso {

/// Nodes of one yarn's fibers in coordinates in which the yarn is straight, neighbouring fibers are about 1 apart and
/// so are neighbouring nodes of a fiber: what a Delaunay triangulation needs to give well-shaped tetrahedra.
struct SectionCoordinates {
  std::vector<Index> nodes;    ///< of the fiber mesh, fiber by fiber
  std::vector<Index> fibers;   ///< fiber of each node, counted within the yarn
  std::vector<Vec3> unrolled;  ///< (across / d, up / d, along / h) of each node
  Index n_fibers = 0;
  bool equal_node_counts = true;
  double fiber_distance = 0;  ///< d: median over the fibers of the distance to the nearest one at mid-length, m
  double node_spacing = 0;    ///< h: mean along the fibers, m
};

/// Coordinates about the yarn's mean curve, in a frame that is carried along it and turns with the fibers' mean twist.
/// For straight parallel fibers this is the section's own plane, so nothing is distorted. `r`: node positions in the
/// reference state, m.
[[nodiscard]] SectionCoordinates section_coordinates(const micro::FiberMesh& mesh, const micro::Yarn& yarn,
                                                     const std::vector<Vec3>& r);

}  // namespace trame::meso
