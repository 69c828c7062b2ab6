#pragma once
/// \file
/// A coarse space of a system: unknowns of fewer nodes, and what those of its own nodes are for them.

#include <cstddef>
#include <span>
#include <vector>

#include "micro/core/types.h"

namespace trame::micro {

struct CoarseSpace {
  /// A coarse node that a node of the system follows, δq = W δq_coarse; W, column-major, begins at `weight`.
  struct Link {
    Index node;
    std::size_t weight;
  };
  std::vector<Index> first_dof = {0};  ///< of each coarse node; one more entry for the end
  std::vector<std::size_t> link_start = {0};
  std::vector<Link> links;
  std::vector<double> weights;

  std::vector<Index> part;  ///< of each node of the system, as the fiber: parts are solved for exactly, one by one

  [[nodiscard]] Index n_coarse_nodes() const { return static_cast<Index>(first_dof.size()) - 1; }
  [[nodiscard]] Index width(Index coarse_node) const { return first_dof[coarse_node + 1] - first_dof[coarse_node]; }
  /// Links of a node of the system.
  [[nodiscard]] std::span<const Link> links_of(Index node) const {
    return {links.data() + link_start[node], links.data() + link_start[node + 1]};
  }
};

}  // namespace trame::micro
