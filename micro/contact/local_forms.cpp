#include "micro/contact/local_forms.h"

namespace trame::micro {

bool CoveredElements::cover(const FiberField& field, const Foot& a, const Foot& b) {
  constexpr double beside_joint = 0.01;  // of an element: a foot nearer than that may cross the joint
  bool grown = false;
  for (int side = 0; side < 2; ++side) {
    const Foot& foot = side == 0 ? a : b;
    auto& [first, last] = range[side];
    const bool covered = last >= first && foot.element >= first && foot.element <= last;
    if (covered) continue;
    grown = true;
    const double t = foot.s / field.element_length(foot.fiber) - foot.element;
    if (last < first) first = last = foot.element;
    first = std::min(first, foot.element - (t < beside_joint && foot.element > 0 ? 1 : 0));
    const bool next = t > 1 - beside_joint && foot.element + 1 < field.mesh().n_elements(foot.fiber);
    last = std::max(last, foot.element + (next ? 1 : 0));
  }
  return grown;
}

void CoveredElements::add_sparsity(const FiberField& field, Index fiber_a, Index fiber_b,
                                   Pattern::Builder& builder) const {
  std::vector<Index> nodes;
  const auto add = [&](Index fiber, const std::pair<Index, Index>& elements) {
    const int last = field.model(fiber) == FiberModel::enriched ? 2 : 1;
    for (Index n = field.element_node(fiber, elements.first); n <= field.element_node(fiber, elements.second) + last;
         ++n)
      nodes.push_back(n);
  };
  add(fiber_a, range[0]);
  add(fiber_b, range[1]);
  builder.add_clique(nodes);
}

}  // namespace trame::micro
