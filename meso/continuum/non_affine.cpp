#include "meso/continuum/non_affine.h"

#include <Eigen/QR>
#include <algorithm>
#include <limits>
#include <utility>

#include "meso/mesh/section_coordinates.h"

namespace trame::meso {
namespace {

/// Twice the unknowns of each component.
constexpr std::size_t min_neighbours = 6;

/// Finds neighbours among nodes that are sorted along the yarn.
class NeighbourSearch {
 public:
  NeighbourSearch(const SectionCoordinates& section, const Neighbourhood& neighbourhood)
      : section_(section), neighbourhood_(neighbourhood), along_(section.nodes.size()) {
    for (std::size_t i = 0; i < along_.size(); ++i) along_[i] = {section.unrolled[i].z(), i};
    std::sort(along_.begin(), along_.end());
  }

  [[nodiscard]] std::vector<std::size_t> of(std::size_t i) const {
    const Vec3& x = section_.unrolled[i];
    const double reach = neighbourhood_.axial_radius;
    std::vector<std::size_t> result;
    auto next = std::lower_bound(along_.begin(), along_.end(), std::pair{x.z() - reach, std::size_t{0}});
    for (; next != along_.end() && next->first <= x.z() + reach; ++next) {
      const std::size_t j = next->second;
      if (j == i) continue;
      if ((section_.unrolled[j] - x).head<2>().norm() <= neighbourhood_.section_radius) result.push_back(j);
    }
    return result;
  }

 private:
  const SectionCoordinates& section_;
  const Neighbourhood& neighbourhood_;
  std::vector<std::pair<double, std::size_t>> along_;
};

/// D²_min / d² of node i: what of the images lies outside the column space of the arms. Directions in which the
/// neighbourhood has no extent (fibers in one layer) are left out of the map.
double residual(const SectionCoordinates& section, std::size_t i, const std::vector<std::size_t>& neighbours,
                const std::vector<Vec3>& r_a, const std::vector<Vec3>& r_b) {
  if (neighbours.size() < min_neighbours) return std::numeric_limits<double>::quiet_NaN();
  const auto n = static_cast<Eigen::Index>(neighbours.size());
  Eigen::MatrixX3d arms(n, 3), images(n, 3);
  for (Eigen::Index row = 0; row < n; ++row) {
    const Index node = section.nodes[i], neighbour = section.nodes[neighbours[row]];
    arms.row(row) = (r_a[neighbour] - r_a[node]) / section.fiber_distance;
    images.row(row) = (r_b[neighbour] - r_b[node]) / section.fiber_distance;
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixX3d> qr(n, 3);
  qr.setThreshold(1e-6);
  qr.compute(arms);
  images.applyOnTheLeft(qr.householderQ().adjoint());
  return images.bottomRows(n - qr.rank()).squaredNorm() / static_cast<double>(n);
}

}  // namespace

std::vector<double> non_affine_residual(const micro::FiberMesh& mesh, const micro::Yarn& yarn,
                                        const std::vector<Vec3>& r_a, const std::vector<Vec3>& r_b,
                                        const Neighbourhood& neighbourhood) {
  const SectionCoordinates section = section_coordinates(mesh, yarn, r_a);
  std::vector<double> D2(section.nodes.size(), std::numeric_limits<double>::quiet_NaN());
  // Fibers in one another have no distance, and a yarn without length has no direction.
  if (!std::all_of(section.unrolled.begin(), section.unrolled.end(), [](const Vec3& x) { return x.allFinite(); }))
    return D2;
  const NeighbourSearch search(section, neighbourhood);
  for (std::size_t i = 0; i < D2.size(); ++i) D2[i] = residual(section, i, search.of(i), r_a, r_b);
  return D2;
}

}  // namespace trame::meso
