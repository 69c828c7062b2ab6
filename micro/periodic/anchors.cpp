#include "micro/periodic/anchors.h"

#include <Eigen/LU>

namespace trame::micro {

Anchors::Anchors(const FiberField& field) : field_(field) {
  constexpr double share = 1e-4;  // of E A / L
  const FiberMesh& mesh = field.mesh();
  for (Index f = 0; f < mesh.n_fibers(); ++f) {
    if (mesh.period(f) < 0) continue;
    const double k = share * mesh.axial_stiffness[f] / mesh.length(f);
    anchors_.push_back({field.element_node(f, 0),
                        field.model(f) == FiberModel::enriched ? 3 : 1,
                        k,
                        k * mesh.radius[f] * mesh.radius[f],
                        {}});
  }
}

void Anchors::begin_step(const State& start, double) {
  start_ = start;
  Eigen::Matrix<double, 3, 2> periods;
  for (int which = 0; which < 2; ++which) periods.col(which) = field_.period(start, which);
  for (Anchor& anchor : anchors_) {
    // The shortest of all that fit: none along a period that is not there.
    const Vec2 xi = periods.completeOrthogonalDecomposition().solve(start.q[field_.layout().first_vector(anchor.node)]);
    anchor.xi = {xi[0], xi[1]};
  }
}

void Anchors::add_sparsity(Pattern::Builder& builder) const {
  for (const Anchor& anchor : anchors_) {
    std::vector<Index> nodes = {anchor.node};
    for (const Index period : field_.period_nodes())
      if (period >= 0) nodes.push_back(period);
    builder.add_clique(nodes);
  }
}

Vec3 Anchors::deviation(const State& state, const Anchor& anchor, int v) const {
  const Index vector = field_.layout().first_vector(anchor.node) + v;
  Vec3 e = state.q[vector] - start_.q[vector];
  for (int which = 0; which < 2 && v == 0; ++which)
    e -= anchor.xi[which] * (field_.period(state, which) - field_.period(start_, which));
  return e;
}

void Anchors::add(const State& state, Assembler& assembler) const {
  const std::array<Index, 2>& periods = field_.period_nodes();
  const auto add_diagonal = [&](Index i, Index j, int v, double k) {
    const auto block = assembler.block(i, j);
    for (int c = 0; c < 3; ++c) block.data[static_cast<std::size_t>(3 * v + c) * block.stride + 3 * v + c] += k;
  };
  for (const Anchor& anchor : anchors_) {
    for (int v = 0; v < anchor.n_vectors; ++v) {
      const double k = v == 0 ? anchor.k : anchor.k_section;
      const bool wants = assembler.wants_tangent();
      const Vec3 f = k * deviation(state, anchor, v);
      assembler.add_force(anchor.node, v, f);
      if (wants && assembler.owns(anchor.node)) add_diagonal(anchor.node, anchor.node, v, k);
      for (int which = 0; which < 2 && v == 0; ++which) {
        if (periods[which] < 0) continue;
        const double xi = anchor.xi[which];
        assembler.add_force(periods[which], 0, -xi * f);
        if (!wants) continue;
        // Bodies, of which periods are some, come before all fibers.
        if (assembler.owns(periods[which])) add_diagonal(anchor.node, periods[which], 0, -k * xi);
        for (int other = 0; other < 2; ++other)
          if (periods[other] >= 0 && periods[other] <= periods[which] && assembler.owns(periods[other]))
            add_diagonal(periods[which], periods[other], 0, k * xi * anchor.xi[other]);
      }
    }
  }
}

double Anchors::energy(const State& state) const {
  double sum = 0;
  for (const Anchor& anchor : anchors_)
    for (int v = 0; v < anchor.n_vectors; ++v)
      sum += 0.5 * (v == 0 ? anchor.k : anchor.k_section) * deviation(state, anchor, v).squaredNorm();
  return sum;
}

Ledger Anchors::ledger(const State&) const {
  Ledger ledger;
  ledger[Sink::damping] = book_.dissipated;
  return ledger;
}

void Anchors::commit(const State& state) {
  std::size_t i = 0;
  for (const Anchor& anchor : anchors_)
    for (int v = 0; v < anchor.n_vectors; ++v, ++i) {
      const Vec3 motion = deviation(state, anchor, v);
      book_.enter(i, (v == 0 ? anchor.k : anchor.k_section) * motion, motion);
    }
}

void Anchors::keep(Archive& archive) {
  std::size_t n = 0;
  for (const Anchor& anchor : anchors_) n += anchor.n_vectors;
  book_.keep(archive, n);
}

}  // namespace trame::micro
