#pragma once
/// \file
/// Plane cuts through a yarn's mesh as pictures: a regular raster that knows which tetrahedron covers each pixel.

#include <Eigen/Core>
#include <vector>

#include "meso/mesh/yarn_mesh.h"
#include "meso/sections/sections.h"
#include "meso/strain/strain.h"

namespace trame::meso {

/// A value for each pixel: row 0 is the lowest, column 0 the leftmost.
using Picture = Eigen::ArrayXXd;
using Mask = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>;

/// Axes are unit vectors normal to each other.
struct CutPlane {
  Vec3 origin = Vec3::Zero();  ///< m
  Vec3 horizontal = Vec3::UnitY(), vertical = Vec3::UnitZ();
};

/// The plane of a section: horizontal and vertical of the yarn there.
[[nodiscard]] CutPlane section_plane(const Section& section);

/// The plane along the yarn through a section's origin: its axis is horizontal. It holds the whole yarn only where that
/// is straight.
[[nodiscard]] CutPlane longitudinal_plane(const Section& section);

/// Pixels to a fiber distance where no one asks for another number.
inline constexpr double default_pixels_per_distance = 4;

/// A raster of square pixels in the plane.
struct YarnCut {
  CutPlane plane;
  Vec2 corner = Vec2::Zero();      ///< centre of pixel (0, 0), from the plane's origin along its axes, m
  double pixel = 0;                ///< side of a pixel, m
  double fiber_distance = 0;       ///< of the mesh, m
  Mask inside = {};                ///< the yarn is there; no pixel at all where the plane misses the yarn
  Eigen::ArrayXX<Index> tet = {};  ///< that covers the pixel's centre; only where inside

  /// Of a pixel, from the plane's origin along its axes, m.
  [[nodiscard]] Vec2 centre(Index row, Index column) const { return corner + pixel * Vec2(column, row); }
  [[nodiscard]] Index n_rows() const { return static_cast<Index>(inside.rows()); }
  [[nodiscard]] Index n_columns() const { return static_cast<Index>(inside.cols()); }
};

/// Cuts the tetrahedra at `positions` (of all nodes of the fiber mesh, m). Those that are inside out there are left
/// out, and so are pieces wider than 20 fiber distances, which belong to a node that has been torn away: they would
/// make the picture as wide as they are. A plane that meets the yarn twice shows both places. Throws InputError for
/// pixels_per_distance < 1.
[[nodiscard]] YarnCut cut_yarn(const YarnMesh& mesh, const std::vector<Vec3>& positions, const CutPlane& plane,
                               double pixels_per_distance = default_pixels_per_distance);

/// Values of the tetrahedra on a cut, constant in each, without any smoothing; NaN outside and where they are NaN.
[[nodiscard]] Picture sample(const YarnCut& cut, const std::vector<double>& values);

/// Component E(i, j) of every tetrahedron; 0 axial, 1 horizontal, 2 vertical.
[[nodiscard]] std::vector<double> component(const StrainField& field, int i, int j);

}  // namespace trame::meso
