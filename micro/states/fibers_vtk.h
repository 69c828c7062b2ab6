#pragma once
/// \file
/// Fibers for ParaView: `fibers.pvd`, a time series of `fibers_NNNN.vtp` with one polyline per fiber. All in SI units.
///
/// | array | on | unit | meaning |
/// | --- | --- | --- | --- |
/// | radius | points | m | of the fiber; for the Tube filter |
/// | displacement | points | m | since increment 0 |
/// | tension | points | N | E A times the axial Green-Lagrange strain since increment 0 |
/// | curvature | points | 1/m | of the centre line |
/// | contact_force | points | N/m | sum of the sizes of normal contact forces per length of fiber |
/// | fiber, yarn, family | cells | | indices; family 0: warp, 1: weft, 2: neither |
/// | copy | cells | | (i, j) of the copy, where the weave is periodic: cell_copies.h |
/// | load, stage_time | field | | name of the stage, and 0…1 within it |
///
/// The time of the series is the increment's number.

#include <filesystem>
#include <memory>
#include <vector>

#include "micro/states/cell_copies.h"

namespace trame::micro {

/// Axial force E A · E_ss at the nodes, with E_ss = ½(r'·r' − R'·R') of the 3-node interpolation at its two Gauss
/// points, continued linearly to the nodes and averaged between elements. `reference`, `current`: n_nodes, m. Result:
/// N.
[[nodiscard]] std::vector<double> fiber_tension(const FiberMesh& mesh, const std::vector<Vec3>& reference,
                                                const std::vector<Vec3>& current);

/// |r' × r''| / |r'|³ at the nodes, from the 3-node interpolation, derivatives averaged between elements. 1/m.
[[nodiscard]] std::vector<double> fiber_curvature(const FiberMesh& mesh, const std::vector<Vec3>& current);

/// Normal contact forces (sizes, not vectors) lumped to the nearest node of both fibers, over the length of fiber that
/// belongs to the node. N/m.
[[nodiscard]] std::vector<double> fiber_contact_force(const FiberMesh& mesh, const ContactRecord& contacts);

/// Writes increments one by one, so that a running simulation can be watched.
class FibersVtkWriter {
 public:
  /// `reference`: increment 0. Throws InputError where there cannot be so many copies, or `folder` cannot be made.
  FibersVtkWriter(const SnapshotHeader& header, const Increment& reference, const std::filesystem::path& folder,
                  const Copies& copies = one_cell);
  ~FibersVtkWriter();
  FibersVtkWriter(const FibersVtkWriter&) = delete;
  FibersVtkWriter& operator=(const FibersVtkWriter&) = delete;

  /// Writes `increment` as time `index`. Throws InputError where it cannot be written.
  void append(Index index, const Increment& increment);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Writes every increment of a state file; returns the .pvd file. Throws InputError.
std::filesystem::path write_fibers_vtk(const SnapshotReader& states, const std::filesystem::path& folder,
                                       const Copies& copies = one_cell);

}  // namespace trame::micro
