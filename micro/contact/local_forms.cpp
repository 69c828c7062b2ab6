#include "micro/contact/local_forms.h"

namespace trame::micro {

bool CoveredNodes::cover(const FiberField& field, const Foot& a, const Foot& b) {
  constexpr double beside_node = 0.005;  // of an element: a foot nearer than that may pass the node
  bool grown = false;
  for (int side = 0; side < 2; ++side) {
    const Foot& foot = side == 0 ? a : b;
    auto& [first, last] = range[side];
    const auto nodes_at = [&](double s) {
      const CurveShape shape = field.shape(foot.fiber, s);
      return std::make_pair(shape.first_node, shape.first_node + shape.n_nodes - 1);
    };
    const auto [first_needed, last_needed] = nodes_at(foot.s);
    if (first <= first_needed && last >= last_needed) continue;
    grown = true;
    const double beside = beside_node * field.element_length(foot.fiber);
    const Index from = nodes_at(foot.s - beside).first, to = nodes_at(foot.s + beside).second;
    const bool empty = last < first;
    first = empty ? from : std::min(first, from);
    last = empty ? to : std::max(last, to);
  }
  return grown;
}

void CoveredNodes::add_sparsity(Pattern::Builder& builder) const {
  std::vector<Index> nodes;
  for (const auto& [first, last] : range)
    for (Index n = first; n <= last; ++n) nodes.push_back(n);
  builder.add_clique(nodes);
}

void LocalForms::scatter_force(const Form& force, Assembler& assembler) const {
  for (int side = 0; side < 2; ++side)
    for (int n = 0; n < shape_[side].n_nodes; ++n) {
      const Index node = shape_[side].first_node + n;
      if (!assembler.owns(node)) continue;
      for (int v = 0; v < shape_[side].n_vectors; ++v) {
        const Parts p = parts(side, n, v);
        Vec3 f = p.weight * force.segment<3>(p.at);
        if (p.both) f += p.weight_of_tangent * force.segment<3>(p.at + 3);
        assembler.add_force(node, v, f);
      }
    }
}

void LocalForms::scatter_tangent(Matrix& k, Assembler& assembler) const {
  k.triangularView<Eigen::StrictlyUpper>() = k.transpose();
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, max_size, 3> column(size_, 3);  // of k, for a vector of a node
  for (int side = 0; side < 2; ++side)
    for (int n = 0; n < shape_[side].n_nodes; ++n) {
      const Index j = shape_[side].first_node + n;
      if (!assembler.owns(j)) continue;
      for (int u = 0; u < shape_[side].n_vectors; ++u) {
        const Parts q = parts(side, n, u);
        column = q.weight * k.middleCols<3>(q.at);
        if (q.both) column += q.weight_of_tangent * k.middleCols<3>(q.at + 3);
        for (int other = 0; other < 2; ++other)
          for (int m = 0; m < shape_[other].n_nodes; ++m) {
            const Index i = shape_[other].first_node + m;
            if (i < j) continue;
            const auto block = assembler.block(i, j);
            for (int v = 0; v < shape_[other].n_vectors; ++v) {
              const Parts p = parts(other, m, v);
              Mat3 b = p.weight * column.middleRows<3>(p.at);
              if (p.both) b += p.weight_of_tangent * column.middleRows<3>(p.at + 3);
              for (int c = 0; c < 3; ++c) {
                double* values = block.data + static_cast<std::size_t>(3 * u + c) * block.stride + 3 * v;
                for (int r = 0; r < 3; ++r) values[r] += b(r, c);
              }
            }
          }
      }
    }
}

}  // namespace trame::micro
