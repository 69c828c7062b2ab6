#include "micro/contact/local_forms.h"

namespace trame::micro {

bool CoveredNodes::cover(const FiberField& field, const Foot& a, const Foot& b) {
  constexpr double beside_node = 0.005;  // of an element: a foot nearer than that may pass the node
  bool grown = false;
  for (int side = 0; side < 2; ++side) {
    const Foot& foot = side == 0 ? a : b;
    auto& [first, last] = range[side];
    const auto [first_needed, last_needed] = field.nodes_at(foot.fiber, foot.s);
    if (first <= first_needed && last >= last_needed) continue;
    grown = true;
    const double beside = beside_node * field.element_length(foot.fiber);
    const Index from = field.nodes_at(foot.fiber, foot.s - beside).first,
                to = field.nodes_at(foot.fiber, foot.s + beside).second;
    const bool empty = last < first;
    first = empty ? from : std::min(first, from);
    last = empty ? to : std::max(last, to);
    for (int which = 0; which < 2; ++which)
      periods[which] = periods[which] || foot.image[which] != 0 || field.passes_seam(foot.fiber, which, first, last);
  }
  return grown;
}

void CoveredNodes::add_sparsity(const FiberField& field, const Foot& a, const Foot& b,
                                Pattern::Builder& builder) const {
  std::vector<Index> nodes;
  for (int side = 0; side < 2; ++side)
    for (Index n = range[side].first; n <= range[side].second; ++n)
      nodes.push_back(field.wrapped_node((side == 0 ? a : b).fiber, n));
  for (int which = 0; which < 2; ++which)
    if (periods[which]) nodes.push_back(field.period_nodes()[which]);
  builder.add_clique(nodes);
}

void LocalForms::scatter_force(const Form& force, Assembler& assembler) const {
  for_each_coefficient(force, [&](Index node, int v, const Vec3& f) { assembler.add_force(node, v, f); });
}

void LocalForms::scatter_tangent(Matrix& k, Assembler& assembler) const {
  k.triangularView<Eigen::StrictlyUpper>() = k.transpose();
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, max_size, 3>;
  std::array<Columns, 3> columns;  // of k, for each vector of a node
  for_each_node([&](Index j, int side, int n) {
    if (!assembler.owns(j)) return;
    for (int u = 0; u < shape_[side].slots.vectors(n); ++u) {
      const Parts q = parts(side, n, u);
      columns[u] = q.weight * k.middleCols<3>(q.at) + q.weight_of_slope * k.middleCols<3>(q.at + 3);
    }
    for_each_node([&](Index i, int other, int m) {
      if (i < j) return;
      const auto block = assembler.block(i, j);
      for (int v = 0; v < shape_[other].slots.vectors(m); ++v) {
        const Parts p = parts(other, m, v);
        for (int u = 0; u < shape_[side].slots.vectors(n); ++u) {
          const Mat3 b =
              p.weight * columns[u].middleRows<3>(p.at) + p.weight_of_slope * columns[u].middleRows<3>(p.at + 3);
          for (int c = 0; c < 3; ++c) {
            double* values = block.data + static_cast<std::size_t>(3 * u + c) * block.stride + 3 * v;
            for (int r = 0; r < 3; ++r) values[r] += b(r, c);
          }
        }
      }
    });
  });
}

}  // namespace trame::micro
