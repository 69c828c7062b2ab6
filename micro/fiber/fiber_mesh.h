#pragma once
/// \file
/// The fibers of a scene as curves cut into 3-node elements, and one configuration of them.

#include <string>
#include <vector>

#include "micro/core/archive.h"

namespace trame::micro {

/// Which family a yarn belongs to; `free` for fibers and bundles that are not part of a weave.
enum class YarnFamily : std::uint8_t { warp, weft, free };

/// A yarn: consecutive fibers `first_fiber … first_fiber + n_fibers − 1`.
struct Yarn {
  std::string name;  ///< "warp/1", "weft/3", or the name of the bundle or fiber in the scene
  YarnFamily family = YarnFamily::free;
  Index first_fiber = 0;
  Index n_fibers = 0;
};

/// Fiber mesh: fiber f owns nodes `first_node[f] … first_node[f+1] − 1`, an odd number of them; its 3-node
/// elements span nodes (2e, 2e+1, 2e+2) counted from its first one. All arrays are flat.
struct FiberMesh {
  std::vector<Index> first_node = {0};  ///< n_fibers + 1
  std::vector<double> radius;           ///< n_fibers, R, length
  std::vector<double> axial_stiffness;  ///< n_fibers, E A, force
  std::vector<Index> yarn_of_fiber;     ///< n_fibers
  std::vector<double> arc_length;       ///< n_nodes, s of the node from its fiber's start, reference state, length
  std::vector<Yarn> yarns;
  /// Which period vector (0, 1) a fiber comes back by to where it starts: its last node is its first one, displaced by
  /// that, with the same sections. Negative: it has two ends. Empty: all have.
  std::vector<int> period_of_fiber;

  [[nodiscard]] Index n_fibers() const { return static_cast<Index>(radius.size()); }
  [[nodiscard]] Index n_nodes() const { return first_node.back(); }
  [[nodiscard]] Index n_nodes(Index fiber) const { return first_node[fiber + 1] - first_node[fiber]; }
  [[nodiscard]] Index n_elements(Index fiber) const { return (n_nodes(fiber) - 1) / 2; }
  [[nodiscard]] int period(Index fiber) const { return period_of_fiber.empty() ? -1 : period_of_fiber[fiber]; }
  [[nodiscard]] double length(Index fiber) const { return arc_length[first_node[fiber + 1] - 1]; }
};

/// One configuration of all fibers at the nodes of the mesh, whatever the fiber model:
/// x(s, ξ) = r(s) + ξ₁ g₁(s) + ξ₂ g₂(s). Rods carry sections that are unit and normal to the tangent.
struct FiberConfiguration {
  std::vector<Vec3> r;        ///< n_nodes, centre line, length
  std::vector<Vec3> g1;       ///< n_nodes, first section vector, dimensionless
  std::vector<Vec3> g2;       ///< n_nodes, second section vector, dimensionless
  std::vector<Vec3> tangent;  ///< n_nodes, dr/ds, dimensionless

  void resize(std::size_t n_nodes) {
    r.resize(n_nodes);
    g1.resize(n_nodes);
    g2.resize(n_nodes);
    tangent.resize(n_nodes);
  }
  void keep(Archive& archive) { archive(r, g1, g2, tangent); }
};

}  // namespace trame::micro
