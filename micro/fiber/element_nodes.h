#pragma once
/// \file
/// The nodes of a fiber element, from which it gathers its vectors and to which it adds forces and tangents.

#include <array>

#include "micro/solve/system.h"

namespace trame::micro {

/// The nodes of an element in their order along the fiber. The last element of a fiber that comes back to its start
/// (FiberMesh::period_of_fiber) ends at the fiber's first node, displaced by a period vector: its position is the sum
/// of both, its other vectors are those of the node. Being linear with constant coefficients, that goes through forces
/// and tangents as it is.
struct ElementNodes {
  int n_nodes = 0, n_vectors = 0;
  std::array<Index, 3> node{};
  Index period_node = -1;  ///< its first vector is the period; negative: none is added

  using Buffer = std::array<Vec3, 9>;
  /// The vectors of the nodes, one after the other, of all vectors `q`; in `buffer` where they do not stand so in `q`.
  [[nodiscard]] const Vec3* gather(const Layout& layout, const Vec3* q, Buffer& buffer) const {
    if (period_node < 0) return q + layout.first_vector(node[0]);
    for (int a = 0; a < n_nodes; ++a)
      for (int v = 0; v < n_vectors; ++v) buffer[a * n_vectors + v] = q[layout.first_vector(node[a]) + v];
    buffer[(n_nodes - 1) * n_vectors] += q[layout.first_vector(period_node)];
    return buffer.data();
  }
  [[nodiscard]] bool touches(const Assembler& assembler) const {
    if (period_node < 0) return assembler.touches(node[0], node[n_nodes - 1]);
    bool any = assembler.owns(period_node);
    for (int a = 0; a < n_nodes; ++a) any = any || assembler.owns(node[a]);
    return any;
  }
  void add_clique(Pattern::Builder& builder) const {
    std::array<Index, 4> nodes{node[0], node[1], node[2]};
    nodes[n_nodes] = period_node;
    builder.add_clique({nodes.data(), nodes.data() + n_nodes + (period_node < 0 ? 0 : 1)});
  }
  /// Adds to the gradient at vector `v` of node `a` of the element.
  void add_force(int a, int v, const Vec3& f, Assembler& assembler) const {
    assembler.add_force(node[a], v, f);
    if (period_node >= 0 && a == n_nodes - 1 && v == 0) assembler.add_force(period_node, 0, f);
  }
  /// Whether the block of nodes a and c of the element is one of the lower triangle that the assembler owns.
  [[nodiscard]] bool is_wanted(int a, int c, const Assembler& assembler) const {
    return node[a] >= node[c] && assembler.owns(node[c]);
  }
  /// Adds a symmetric matrix of all vectors of the nodes.
  template <typename Matrix>
  void add_tangent(const Matrix& k, Assembler& assembler) const {
    const int width = 3 * n_vectors, last = (n_nodes - 1) * width;
    const auto add = [&](Index i, int row, int n_rows, Index j, int column, int n_columns) {
      const auto block = assembler.block(i, j);
      for (int c = 0; c < n_columns; ++c)
        for (int r = 0; r < n_rows; ++r)
          block.data[static_cast<std::size_t>(c) * block.stride + r] += k(row + r, column + c);
    };
    for (int a = 0; a < n_nodes; ++a)
      for (int c = 0; c < n_nodes; ++c)
        if (is_wanted(a, c, assembler)) add(node[a], width * a, width, node[c], width * c, width);
    if (period_node < 0 || !assembler.owns(period_node)) return;
    // Bodies, of which the period is one, come before all fibers.
    for (int a = 0; a < n_nodes; ++a) add(node[a], width * a, width, period_node, last, 3);
    add(period_node, last, 3, period_node, last, 3);
  }
};

}  // namespace trame::micro
