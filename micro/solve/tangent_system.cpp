#include "micro/solve/tangent_system.h"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace trame::micro {

TangentSystem::TangentSystem(const Layout& layout, int n_threads, Timers& timers, const Region& region)
    : layout_(layout), n_threads_(n_threads), timers_(timers), region_(region), force_(layout.n_dofs()),
      inner_(layout.n_vectors()), outer_(layout.n_vectors()) {
  for (Index j = 0; j < layout.n_nodes(); ++j) node_of_.insert(node_of_.end(), layout.n_vectors(j), j);
  owned_from_.resize(n_threads_ + 1);
  for (int t = 0; t <= n_threads_; ++t)
    owned_from_[t] = static_cast<Index>(static_cast<std::int64_t>(layout.n_nodes()) * t / n_threads_);
}

bool TangentSystem::cover_sparsity(const Effects& effects) {
  Pattern::Builder builder(region_);
  {
    const auto guard = timers_.measure(Phase::detection);
    for (const auto& effect : effects) effect->add_sparsity(builder);
    if (pattern_.covers(builder)) return false;
  }
  const auto guard = timers_.measure(Phase::symbolic);
  pattern_ = Pattern(layout_, std::move(builder));
  values_.resize(pattern_.n_values());
  return true;
}

void TangentSystem::assemble(const Effects& effects, const State& state, std::span<const Vec3> last_step,
                             Assembler::Tangent tangent, Assembler::Stress of_forces) {
  const auto guard = timers_.measure(Phase::assembly);
#pragma omp parallel for num_threads(n_threads_) schedule(static, 1)
  for (int t = 0; t < n_threads_; ++t) {
    const Index begin = owned_from_[t], end = owned_from_[t + 1];
    std::fill(force_.begin() + layout_.first_dof(begin), force_.begin() + layout_.first_dof(end), 0.0);
    for (auto* sizes : {&inner_, &outer_})
      std::fill(sizes->begin() + layout_.first_vector(begin), sizes->begin() + layout_.first_vector(end), 0.0);
    if (tangent != Assembler::Tangent::none) {
      const auto value_limit = [&](Index node) {
        return values_.begin() + (node < layout_.n_nodes() ? pattern_.value_start(node) : pattern_.n_values());
      };
      std::fill(value_limit(begin), value_limit(end), 0.0);
    }
    Assembler assembler(layout_, &pattern_, begin, end, force_.data(), inner_.data(), values_.data(), tangent, region_);
    // Actual forces alone know nothing of it.
    if (tangent != Assembler::Tangent::none || of_forces == Assembler::Stress::expected)
      assembler.set_last_step(last_step.data(), of_forces);
    for (const auto& effect : effects) {
      assembler.set_magnitude(effect->is_elastic() ? inner_.data() : outer_.data());
      effect->add(state, assembler);
    }
  }
  turn_to_dofs(tangent != Assembler::Tangent::none);
}

void TangentSystem::turn_to_dofs(bool with_tangent) {
  const Index n_nodes = layout_.n_skew_nodes();
  const Mat3& axes = layout_.skew_axes();
  for (Index v = 0; v < layout_.first_vector(n_nodes); ++v) {
    Eigen::Map<Vec3> force(force_.data() + 3 * v);
    force = axes.transpose() * Vec3(force);
  }
  for (Index j = 0; j < n_nodes && with_tangent; ++j) {
    const Index width = pattern_.width(j);
    Eigen::Map<Eigen::MatrixXd> columns(values_.data() + pattern_.value_start(j), pattern_.column_height(j), width);
    const Eigen::MatrixXd diagonal = columns.topRows(width).selfadjointView<Eigen::Lower>();
    columns.topRows(width) = diagonal;
    for (Index c = 0; c < width; c += 3) columns.middleCols<3>(c) = (columns.middleCols<3>(c) * axes).eval();
    Index n_skew_rows = 0;  // the first ones, as all other nodes come after them
    for (const Index i : pattern_.rows(j))
      if (i < n_nodes) n_skew_rows += pattern_.width(i);
    for (Index r = 0; r < n_skew_rows; r += 3)
      columns.middleRows<3>(r) = (axes.transpose() * columns.middleRows<3>(r)).eval();
  }
}

void TangentSystem::impose(const PrescribedMotion& prescribed, double remaining, std::span<double> right_side) {
  Index n_body_nodes = 0;
  for (Index j = 0; j < layout_.n_nodes(); ++j)
    for (Index d = layout_.first_dof(j); d < layout_.first_dof(j + 1); ++d)
      if (prescribed.fixed[d]) n_body_nodes = j + 1;
  for (Index j = 0; j < n_body_nodes; ++j) {
    const Index height = pattern_.column_height(j), first = layout_.first_dof(j);
    for (Index c = 0; c < 3 * layout_.n_vectors(j); ++c) {
      double* column = values_.data() + pattern_.value_start(j) + static_cast<std::size_t>(c) * height;
      const Index dc = first + c;
      Index at = 0;
      for (const Index i : pattern_.rows(j))
        for (Index r = 0; r < 3 * layout_.n_vectors(i); ++r, ++at) {
          const Index dr = layout_.first_dof(i) + r;
          if (dr <= dc) continue;  // the upper part of the diagonal block is not used
          if (prescribed.fixed[dc]) right_side[dr] -= column[at] * remaining * prescribed.motion[dc];
          if (prescribed.fixed[dr]) right_side[dc] -= column[at] * remaining * prescribed.motion[dr];
          if (prescribed.fixed[dc] || prescribed.fixed[dr]) column[at] = 0;
        }
      if (prescribed.fixed[dc]) column[c] = 1;
    }
  }
  for (std::size_t d = 0; d < right_side.size(); ++d)
    if (prescribed.fixed[d]) right_side[d] = 0;
}

void TangentSystem::scale_diagonal(double factor) {
  for (Index j = 0; j < layout_.n_nodes(); ++j) {
    double* diagonal = values_.data() + pattern_.value_start(j);
    for (Index c = 0; c < 3 * layout_.n_vectors(j); ++c, diagonal += pattern_.column_height(j) + 1) *diagonal *= factor;
  }
}

void TangentSystem::add_to_diagonal(Index vector, double stiffness) {
  const Index j = node_of_[vector], c = 3 * (vector - layout_.first_vector(j));
  double* diagonal =
      values_.data() + pattern_.value_start(j) + static_cast<std::size_t>(c) * (pattern_.column_height(j) + 1);
  for (int d = 0; d < 3; ++d, diagonal += pattern_.column_height(j) + 1) *diagonal += stiffness;
}

void TangentSystem::hold_loose_bodies(std::span<const double> load, double farthest, std::span<const double> unit) {
  for (const Index rotation : layout_.rotation_vectors()) {
    const Index j = node_of_[rotation], height = pattern_.column_height(j);
    for (Index c = 0; c < 3 * layout_.n_vectors(j); ++c) {
      double& diagonal = values_[pattern_.value_start(j) + static_cast<std::size_t>(c) * (height + 1)];
      if (diagonal != 0) continue;
      const double drive = std::abs(load[layout_.first_dof(j) + c]);
      diagonal = drive > 0 ? drive / (farthest * unit[layout_.first_vector(j) + c / 3]) : 1;
    }
  }
}

std::pair<double, double> TangentSystem::diagonal_forces(const State& state) const {
  double forces = 0, moments = 0;
  for (Index j = 0; j < layout_.n_nodes(); ++j) {
    const double* column = values_.data() + pattern_.value_start(j);
    const Index first = layout_.first_dof(j);
    for (Index c = 0; c < layout_.first_dof(j + 1) - first; ++c, column += pattern_.column_height(j)) {
      const double force = column[c] * state.q[(first + c) / 3][(first + c) % 3];
      (c < 3 ? forces : moments) += force * force;
    }
  }
  return {std::sqrt(forces), std::sqrt(moments)};
}

}  // namespace trame::micro
