#pragma once
/// \file
/// Shear zones in a yarn: connected tetrahedra whose strain stands out from their surroundings.

#include <vector>

#include "meso/mesh/yarn_mesh.h"

namespace trame::meso {

/// Smoothing goes from the tetrahedra to their corners (mean weighted by volume) and back (mean of the corners). n
/// sweeps reach as far as a Gaussian of σ ≈ 0.6 √n, fiber distance = node spacing = 1.
struct ShearZoneOptions {
  Index local_sweeps = 1;        ///< for a local value; ≥ 0
  Index background_sweeps = 25;  ///< for its surroundings; > local_sweeps
  double threshold = 0.6;        ///< contrast of a zone, in deviations of the values; > 0
  double min_contrast = 0.05;    ///< smallest difference that counts, against the rms of the values; ≥ 0
  double min_volume = 3;         ///< smallest zone, in cells of fiber distance² × node spacing; ≥ 0
};

/// Tetrahedra of high contrast, each sharing a face with another one.
struct ShearZone {
  Index n_tets = 0;
  double volume = 0, volume_fraction = 0;  ///< in the reference state, m³; of the mesh
  double share_of_total = 0;               ///< of the integral of the values over the mesh
  Vec3 centre = Vec3::Zero();              ///< in state A, m
  Vec3 normal = Vec3::Zero();  ///< unit, of its plane: the smallest principal axis, weighted by contrast and volume
  Vec3 extent = Vec3::Zero();  ///< √12 times the deviations along the principal axes, largest first, m
};

struct ShearZones {
  std::vector<ShearZone> zones = {};  ///< largest volume first
  std::vector<Index> zone = {};       ///< of each tetrahedron: k + 1 in zones[k], 0 in none
  std::vector<double> contrast = {};  ///< of each tetrahedron, in deviations; NaN where there is no value
  double volume_fraction = 0;         ///< of all zones
};

/// `values`: one per tetrahedron, NaN where there is none; `positions`: of the nodes of the fiber mesh in state A, m.
/// Throws InputError for options out of range.
[[nodiscard]] ShearZones find_shear_zones(const YarnMesh& mesh, const std::vector<Vec3>& positions,
                                          const std::vector<double>& values, const ShearZoneOptions& options = {});

}  // namespace trame::meso
