#pragma once
/// \file
/// Order and structure of the elimination of a node pattern: what CHOLMOD's analysis says about the factor before any
/// number is known.

#include <span>
#include <vector>

#include "micro/solve/system.h"

namespace trame::micro {

/// Supernodes of the factor of a node pattern, in a fill-reducing postorder. A *position* is the place of a node in
/// that order. A supernode is a run of positions whose columns share their rows below; its parent is the first
/// supernode among those rows, and every child comes before its parent.
class Elimination {
 public:
  Elimination() = default;
  /// Orders with METIS and finds the supernodes with CHOLMOD, both on the graph of nodes: analysis costs next to
  /// nothing there. Couplings of the pattern that are not `kept` are left out. \throws std::runtime_error if CHOLMOD
  /// fails, for instance without memory.
  Elimination(const Pattern& pattern, std::span<const char> kept);

  [[nodiscard]] Index n_supernodes() const { return static_cast<Index>(parent.size()); }
  [[nodiscard]] std::span<const Index> row_positions(Index s) const {
    return {rows.data() + row_start[s], rows.data() + row_start[s + 1]};
  }
  [[nodiscard]] Index n_column_positions(Index s) const { return first[s + 1] - first[s]; }
  /// Scalar columns of supernode s, and its scalar rows, which begin with those of its own columns.
  [[nodiscard]] Index n_columns(Index s) const { return first_dof[first[s + 1]] - first_dof[first[s]]; }
  [[nodiscard]] Index n_rows(Index s) const { return height[s]; }
  [[nodiscard]] Index width(Index position) const { return first_dof[position + 1] - first_dof[position]; }

  std::vector<Index> node;       ///< at each position
  std::vector<Index> dof;        ///< of the pattern, the first of each position
  std::vector<Index> first_dof;  ///< of each position, in elimination order; one more entry for the end
  std::vector<Index> first;      ///< first position of each supernode; one more entry for the end
  std::vector<std::size_t> row_start;
  std::vector<Index> rows;     ///< positions of each supernode's rows, ascending; those of its own columns first
  std::vector<Index> row_dof;  ///< scalar row, within its supernode, at which each of `rows` begins
  std::vector<Index> height;   ///< scalar rows of each supernode
  std::vector<Index> parent;   ///< of each supernode, −1 for a root
  std::vector<Index> child_start, children;
  std::vector<Index> first_descendant;  ///< subtree of s = supernodes first_descendant[s] … s
  std::vector<double> subtree_flops;
  std::vector<std::size_t>
      value_start;  ///< of each supernode's columns (n_rows × n_columns) in the factor; one more for the end
  std::vector<std::size_t>
      front_start;  ///< of each supernode's rows, all set one after the other; one more for the end
  double n_flops = 0;

  /// A block of the matrix below or on the diagonal in elimination order, where it stands in the pattern's values.
  struct Block {
    Index row_position;
    bool transposed;    ///< the pattern stores its transpose
    Index stride;       ///< between stored columns
    std::size_t value;  ///< first stored value
  };
  std::vector<std::size_t> block_start;  ///< first of `blocks` of each position
  std::vector<Block> blocks;
};

}  // namespace trame::micro
