#pragma once
/// \file
/// Tetrahedra between the fibers of a yarn: nodes of the mesh are nodes of its fibers in the reference state.

#include <array>
#include <string_view>
#include <vector>

#include "meso/mesh/section_coordinates.h"
#include "micro/fiber/fiber_mesh.h"

namespace trame::meso {

enum class MeshKind : std::uint8_t {
  delaunay,  ///< triangulation of all nodes, outside carved away; the fibers of a section may have other neighbours
             ///< elsewhere
  swept      ///< triangulation of the section at mid-length, swept along the fibers
};

enum class MeshStatus : std::uint8_t {
  ok,
  too_few_fibers,  ///< one or two fibers enclose no volume
  flat_section,    ///< all fibers lie in one surface
  unequal_fibers   ///< swept only: the fibers differ in their number of nodes
};

[[nodiscard]] std::string_view text(MeshStatus status);

inline constexpr std::size_t n_mesh_kinds = 2;

/// "delaunay" or "swept".
[[nodiscard]] std::string_view text(MeshKind kind);

/// What a mesh may not exceed, of either kind.
struct MeshLimits {
  /// Largest circumradius of a tetrahedron, fiber distance = node spacing = 1. Triangles of a hexagonal packing give
  /// 0.76, of a square one 0.87, the notches along the outline of a hexagonal lattice 1.12.
  double max_circumradius = 1.0;
  /// Tetrahedra on the surface with a smaller dihedral angle are removed, degrees.
  double min_dihedral = 5.0;
};

struct MeshOptions {
  MeshKind kind = MeshKind::delaunay;
  MeshLimits limits = {};
};

/// Shape is measured where fiber distance = node spacing = 1, volumes in the reference state.
struct MeshQuality {
  Index n_slivers_removed = 0;                ///< with an angle below MeshLimits::min_dihedral, peeled off the surface
  Index n_slivers = 0;                        ///< the same, left inside
  Index n_inverted_removed = 0;               ///< flat or turned inside out in the reference state
  Index n_unused_fibers = 0;                  ///< with no tetrahedron
  double min_dihedral = 0, max_dihedral = 0;  ///< degrees
  double min_volume = 0, max_volume = 0, volume = 0;  ///< m³
};

struct YarnMesh {
  Index yarn = 0;
  MeshStatus status = MeshStatus::ok;
  double fiber_distance = 0, node_spacing = 0;  ///< m
  std::vector<Index> nodes;                     ///< node of the fiber mesh at each vertex
  std::vector<Vec3> reference;                  ///< positions of the vertices, m
  std::vector<std::array<Index, 4>> tets;       ///< vertices, positive volume in the reference state
  std::vector<double> volumes;                  ///< of the tets in the reference state, m³
  MeshQuality quality;
};

/// Meshes yarn `yarn` of `mesh`; `r`: node positions in the reference state, m. A yarn without volume gives an empty
/// mesh whose status says why.
[[nodiscard]] YarnMesh mesh_yarn(const micro::FiberMesh& mesh, Index yarn, const std::vector<Vec3>& r,
                                 const MeshOptions& options = {});

}  // namespace trame::meso
