#include "micro/solve/system.h"

#include <algorithm>
#include <utility>

namespace trame::micro {

Mat3 skew(const Vec3& a) {
  Mat3 m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

Mat3 rotation_matrix(const Vec3& rotation_vector) {
  const double angle_squared = rotation_vector.squaredNorm();
  const double angle = std::sqrt(angle_squared);
  // Series below 1e-4 rad: the closed forms lose digits, the next terms are below round-off.
  const bool small = angle < 1e-4;
  const double a = small ? 1 - angle_squared / 6 : std::sin(angle) / angle;
  const double b = small ? 0.5 - angle_squared / 24 : (1 - std::cos(angle)) / angle_squared;
  const Mat3 w = skew(rotation_vector);
  return Mat3::Identity() + a * w + b * w * w;
}

void retract(const Layout& layout, const State& state, std::span<const double> step, double alpha, State& result) {
  result.q.resize(state.q.size());
  result.rotations.resize(state.rotations.size());
  const auto change = [&](Index v) { return layout.change(v, Eigen::Map<const Vec3>(step.data() + 3 * v)); };
  for (std::size_t v = 0; v < state.q.size(); ++v) result.q[v] = state.q[v] + alpha * change(static_cast<Index>(v));
  const auto& rotation_vectors = layout.rotation_vectors();
  for (std::size_t i = 0; i < rotation_vectors.size(); ++i)
    result.rotations[i] = rotation_matrix(alpha * change(rotation_vectors[i])) * state.rotations[i];
}

void Pattern::Builder::add_clique(std::span<const Index> nodes) {
  for (std::size_t a = 0; a < nodes.size(); ++a)
    for (std::size_t b = a + 1; b < nodes.size(); ++b) {
      if (nodes[a] == nodes[b] || !region_->has(nodes[a]) || !region_->has(nodes[b])) continue;
      const auto [low, high] = std::minmax(nodes[a], nodes[b]);
      pairs_.push_back(static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint64_t>(high));
    }
  if (pairs_.size() > compact_at_) compact();
}

void Pattern::Builder::compact() {
  std::sort(pairs_.begin(), pairs_.end());
  pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
  compact_at_ = std::max(compact_at_, 2 * pairs_.size());
}

namespace {

std::vector<Index> first_dofs(const Layout& layout) {
  std::vector<Index> first;
  for (Index j = 0; j <= layout.n_nodes(); ++j) first.push_back(layout.first_dof(j));
  return first;
}

}  // namespace

Pattern::Pattern(const Layout& layout, Builder builder) : Pattern(first_dofs(layout), std::move(builder)) {}

Pattern::Pattern(std::vector<Index> first_dof, Builder builder) : first_dof_(std::move(first_dof)) {
  builder.compact();
  const Index n = static_cast<Index>(first_dof_.size()) - 1;
  column_start_.resize(n + 1);
  column_height_.resize(n);
  value_start_.resize(n);
  row_nodes_.reserve(n + builder.pairs_.size());
  auto pair = builder.pairs_.begin();
  for (Index j = 0; j < n; ++j) {
    column_start_[j] = row_nodes_.size();
    value_start_[j] = n_values_;
    Index height = 0;
    const auto append = [&](Index i) {
      row_nodes_.push_back(i);
      row_offsets_.push_back(height);
      height += width(i);
    };
    append(j);
    for (; pair != builder.pairs_.end() && static_cast<Index>(*pair >> 32) == j; ++pair)
      append(static_cast<Index>(*pair & 0xffffffffu));
    column_height_[j] = height;
    n_values_ += static_cast<std::size_t>(height) * width(j);
  }
  column_start_[n] = row_nodes_.size();
}

bool Pattern::covers(Builder& builder) const {
  if (n_values_ == 0) return false;
  builder.compact();
  std::size_t at = 0;
  for (const std::uint64_t pair : builder.pairs_) {
    const auto j = static_cast<Index>(pair >> 32), i = static_cast<Index>(pair & 0xffffffffu);
    at = std::max(at, column_start_[j]);
    while (at < column_start_[j + 1] && row_nodes_[at] < i) ++at;
    if (at == column_start_[j + 1] || row_nodes_[at] != i) return false;
  }
  return true;
}

Index Pattern::row_offset(Index i, Index j) const {
  const auto nodes = rows(j);
  const auto found = std::lower_bound(nodes.begin(), nodes.end(), i);
  assert(found != nodes.end() && *found == i);
  return row_offsets_[column_start_[j] + (found - nodes.begin())];
}

}  // namespace trame::micro
