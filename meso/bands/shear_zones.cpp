#include "meso/bands/shear_zones.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "meso/bands/contrast.h"
#include "micro/core/error.h"

namespace trame::meso {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

void check(const ShearZoneOptions& options) {
  const auto require = [](bool good, const char* name, double value, const char* range) {
    if (!good) throw InputError(fmt::format("shear zones: {} = {}; must be {}", name, value, range));
  };
  require(options.local_sweeps >= 0, "local_sweeps", options.local_sweeps, ">= 0");
  require(options.background_sweeps > options.local_sweeps, "background_sweeps", options.background_sweeps,
          "> local_sweeps");
  require(options.threshold > 0, "threshold", options.threshold, "> 0");
  require(options.min_contrast >= 0, "min_contrast", options.min_contrast, ">= 0");
  require(options.min_volume >= 0, "min_volume", options.min_volume, ">= 0");
}

/// From tetrahedra to corners and back; those without a value give none, and are given the mean of their corners.
std::vector<double> smoothed(const YarnMesh& mesh, std::vector<double> values, Index n_sweeps) {
  for (Index sweep = 0; sweep < n_sweeps; ++sweep) {
    std::vector<double> sum(mesh.nodes.size(), 0), weight(mesh.nodes.size(), 0);
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      if (!std::isfinite(values[t])) continue;
      for (const Index v : mesh.tets[t]) {
        sum[v] += mesh.volumes[t] * values[t];
        weight[v] += mesh.volumes[t];
      }
    }
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      double mean = 0;
      for (const Index v : mesh.tets[t]) mean += 0.25 * (weight[v] > 0 ? sum[v] / weight[v] : nan);
      values[t] = mean;
    }
  }
  return values;
}

std::vector<double> contrasts(const YarnMesh& mesh, const std::vector<double>& values,
                              const ShearZoneOptions& options) {
  std::vector<double> finite = values;
  std::erase_if(finite, [](double x) { return !std::isfinite(x); });
  if (finite.empty()) return std::vector<double>(values.size(), nan);
  const RobustScale scale = robust_scale(std::move(finite));
  const double deviation = std::max(scale.deviation, options.min_contrast * scale.rms / options.threshold);
  std::vector<double> moved = values;
  for (double& x : moved)
    if (std::isfinite(x)) x = std::clamp(x, scale.low, scale.high);
  const std::vector<double> local = smoothed(mesh, moved, options.local_sweeps);
  const std::vector<double> background = smoothed(mesh, moved, options.background_sweeps);
  std::vector<double> result(values.size(), nan);
  for (std::size_t t = 0; t < values.size(); ++t)
    if (std::isfinite(values[t])) result[t] = deviation > 0 ? (local[t] - background[t]) / deviation : 0;
  return result;
}

/// Pairs of tetrahedra with a common face, as lists of neighbours.
std::vector<std::vector<Index>> face_neighbours(const YarnMesh& mesh) {
  struct Face {
    std::array<Index, 3> vertices;
    Index tet;
  };
  std::vector<Face> faces;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    for (int i = 0; i < 4; ++i) {
      const auto& tet = mesh.tets[t];
      Face face{{tet[(i + 1) % 4], tet[(i + 2) % 4], tet[(i + 3) % 4]}, static_cast<Index>(t)};
      std::sort(face.vertices.begin(), face.vertices.end());
      faces.push_back(face);
    }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return a.vertices != b.vertices ? a.vertices < b.vertices : a.tet < b.tet;
  });
  std::vector<std::vector<Index>> neighbours(mesh.tets.size());
  for (std::size_t f = 0; f + 1 < faces.size(); ++f) {
    if (faces[f].vertices != faces[f + 1].vertices) continue;
    neighbours[faces[f].tet].push_back(faces[f + 1].tet);
    neighbours[faces[f + 1].tet].push_back(faces[f].tet);
  }
  return neighbours;
}

/// Connected sets of the tetrahedra above the threshold.
std::vector<std::vector<Index>> components(const YarnMesh& mesh, const std::vector<double>& contrast,
                                           double threshold) {
  const auto neighbours = face_neighbours(mesh);
  std::vector<bool> seen(mesh.tets.size());
  for (std::size_t t = 0; t < seen.size(); ++t) seen[t] = !(contrast[t] >= threshold);
  std::vector<std::vector<Index>> result;
  for (std::size_t t = 0; t < seen.size(); ++t) {
    if (seen[t]) continue;
    std::vector<Index> component = {static_cast<Index>(t)};
    seen[t] = true;
    for (std::size_t k = 0; k < component.size(); ++k)
      for (const Index other : neighbours[component[k]])
        if (!seen[other]) {
          seen[other] = true;
          component.push_back(other);
        }
    result.push_back(std::move(component));
  }
  return result;
}

ShearZone measure(const YarnMesh& mesh, const std::vector<Vec3>& positions, const std::vector<double>& contrast,
                  const std::vector<Index>& tets) {
  ShearZone zone{.n_tets = static_cast<Index>(tets.size())};
  std::vector<Vec3> centres;
  double weight = 0;
  for (const Index t : tets) {
    Vec3& x = centres.emplace_back(Vec3::Zero());
    for (const Index v : mesh.tets[t]) x += 0.25 * positions[mesh.nodes[v]];
    zone.volume += mesh.volumes[t];
    weight += mesh.volumes[t] * contrast[t];
    zone.centre += mesh.volumes[t] * contrast[t] * x;
  }
  zone.centre /= weight;
  Mat3 second = Mat3::Zero();
  for (std::size_t k = 0; k < tets.size(); ++k) {
    const Vec3 arm = centres[k] - zone.centre;
    second += mesh.volumes[tets[k]] * contrast[tets[k]] / weight * arm * arm.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> principal(second);
  zone.normal = principal.eigenvectors().col(0);
  zone.extent = (12 * principal.eigenvalues().cwiseMax(0)).cwiseSqrt().reverse();
  return zone;
}

}  // namespace

ShearZones find_shear_zones(const YarnMesh& mesh, const std::vector<Vec3>& positions, const std::vector<double>& values,
                            const ShearZoneOptions& options) {
  check(options);
  ShearZones result{.zone = std::vector<Index>(mesh.tets.size(), 0), .contrast = contrasts(mesh, values, options)};
  const auto integral = [&](const auto& tets) {
    double sum = 0;
    for (const Index t : tets)
      if (std::isfinite(values[t])) sum += mesh.volumes[t] * values[t];
    return sum;
  };
  std::vector<Index> all(mesh.tets.size());
  std::iota(all.begin(), all.end(), 0);
  const double total = integral(all);
  const double smallest = options.min_volume * mesh.fiber_distance * mesh.fiber_distance * mesh.node_spacing;
  std::vector<std::pair<ShearZone, std::vector<Index>>> found;
  for (auto& tets : components(mesh, result.contrast, options.threshold)) {
    ShearZone zone = measure(mesh, positions, result.contrast, tets);
    if (zone.volume < smallest) continue;
    zone.volume_fraction = zone.volume / mesh.quality.volume;
    zone.share_of_total = integral(tets) / total;
    found.emplace_back(zone, std::move(tets));
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first.volume > b.first.volume; });
  for (const auto& [zone, tets] : found) {
    result.zones.push_back(zone);
    result.volume_fraction += zone.volume_fraction;
    for (const Index t : tets) result.zone[t] = static_cast<Index>(result.zones.size());
  }
  return result;
}

}  // namespace trame::meso
