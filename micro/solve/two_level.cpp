#include "micro/solve/two_level.h"

#include <algorithm>
#include <array>

#include "micro/core/types.h"

namespace trame::micro {

namespace {

// Blocks of two beams' nodes, and what they are for two of their coarse nodes: most of all by far.
constexpr Index beam = 9, joint = 6;

template <class Real>
using Block = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic, 0, beam, beam>;
template <class Matrix>
using Strided = Eigen::Map<const Matrix, 0, Eigen::OuterStride<>>;

/// y ← y − B x, or Bᵀ x
template <class Matrix, class Real>
void subtract_product(const Real* block, Index height, Index width, bool transposed, const Real* x, Real* y) {
  using Column = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
  const Eigen::Map<const Matrix> b(block, height, width);
  if constexpr (Matrix::RowsAtCompileTime != Eigen::Dynamic) {
    using Fixed = Eigen::Matrix<Real, Matrix::RowsAtCompileTime, 1>;
    const Eigen::Map<const Fixed> from(x);
    Eigen::Map<Fixed> to(y);
    if (transposed)
      to.noalias() -= b.transpose() * from;
    else
      to.noalias() -= b * from;
  } else {
    if (transposed)
      Eigen::Map<Column>(y, width).noalias() -= b.transpose().lazyProduct(Eigen::Map<const Column>(x, height));
    else
      Eigen::Map<Column>(y, height).noalias() -= b.lazyProduct(Eigen::Map<const Column>(x, width));
  }
}

}  // namespace

template <class Real>
TwoLevel<Real>::TwoLevel(const Pattern& pattern, std::span<const char> kept, const CoarseSpace& space)
    : space_(space), x_(pattern.first_dof(pattern.n_nodes())), residual_(x_.size()) {
  for (Index j = 0; j < pattern.n_nodes(); ++j) {
    first_dof_.push_back(pattern.first_dof(j));
    diagonal_.push_back(pattern.value_start(j));
    stride_.push_back(pattern.column_height(j));
  }
  first_dof_.push_back(pattern.first_dof(pattern.n_nodes()));
  find_trees(pattern, kept, space.part);
  find_couplings(pattern, kept);
  find_coarse_structure();
  n_entries_ = 2 * static_cast<double>(coarse_elimination_.value_start.back()) +
               4 * static_cast<double>(tree_elimination_.value_start.back()) + 4 * static_cast<double>(blocks_.size());
  n_flops_ += coarse_elimination_.n_flops + tree_elimination_.n_flops;
}

template <class Real>
void TwoLevel<Real>::find_trees(const Pattern& pattern, std::span<const char> kept, const std::vector<Index>& part) {
  std::vector<char> within(kept.begin(), kept.end());
  for (Index j = 0; j < n_nodes(); ++j) {
    std::size_t coupling = pattern.coupling_start(j);
    for (const Index i : pattern.rows(j)) within[coupling++] &= part[i] == part[j];
  }
  tree_elimination_ = Elimination(pattern, within);
  tree_of_.resize(n_nodes());
  const Elimination& e = tree_elimination_;
  for (Index s = 0; s < e.n_supernodes(); ++s) {
    if (e.parent[s] >= 0) continue;
    for (Index k = e.first[e.first_descendant[s]]; k < e.first[s + 1]; ++k)
      tree_of_[e.node[k]] = static_cast<Index>(root_.size());
    root_.push_back(s);
  }
}

template <class Real>
void TwoLevel<Real>::find_couplings(const Pattern& pattern, std::span<const char> kept) {
  std::vector<std::vector<Coupling>> of(n_nodes());
  std::size_t copy = 0;
  for (Index j = 0; j < n_nodes(); ++j) {
    std::size_t coupling = pattern.coupling_start(j), value = pattern.value_start(j);
    for (const Index i : pattern.rows(j)) {
      if (kept[coupling++] && i != j) {
        of[i].push_back({j, false, stride_[j], value, copy});
        of[j].push_back({i, true, stride_[j], value, copy});
        if (tree_of_[i] != tree_of_[j]) copy += static_cast<std::size_t>(width(i)) * width(j);
      }
      value += width(i);
    }
  }
  blocks_.resize(copy);

  // Each tree has the first colour that none of the trees before, to which it is coupled, has.
  std::vector<std::vector<Index>> nodes_of(root_.size());
  for (Index j = 0; j < n_nodes(); ++j) nodes_of[tree_of_[j]].push_back(j);
  colour_.assign(root_.size(), -1);
  for (Index t = 0; t < static_cast<Index>(root_.size()); ++t) {
    std::vector<char> taken;
    for (const Index j : nodes_of[t])
      for (const Coupling& c : of[j])
        if (const int other = colour_[tree_of_[c.node]]; other >= 0) {
          taken.resize(std::max<std::size_t>(taken.size(), other + 1), 0);
          taken[other] = 1;
        }
    colour_[t] = static_cast<int>(std::find(taken.begin(), taken.end(), 0) - taken.begin());
    trees_by_colour_.resize(std::max<std::size_t>(trees_by_colour_.size(), colour_[t] + 1));
    trees_by_colour_[colour_[t]].push_back(t);
  }

  for (Index j = 0; j < n_nodes(); ++j) {
    const auto rank = [&](const Coupling& c) {
      return tree_of_[c.node] == tree_of_[j] ? 0 : colour_[tree_of_[c.node]] < colour_[tree_of_[j]] ? 1 : 2;
    };
    inner_.push_back(couplings_.size());
    for (int r = 0; r < 3; ++r) {
      if (r == 1) earlier_.push_back(couplings_.size());
      if (r == 2) later_.push_back(couplings_.size());
      for (const Coupling& c : of[j])
        if (rank(c) == r) couplings_.push_back(c);
    }
  }
  inner_.push_back(couplings_.size());
}

template <class Real>
void TwoLevel<Real>::find_coarse_structure() {
  const Index n = space_.n_coarse_nodes();
  follower_start_.assign(n + 1, 0);
  for (const CoarseSpace::Link& link : space_.links) ++follower_start_[link.node + 1];
  for (Index c = 0; c < n; ++c) follower_start_[c + 1] += follower_start_[c];
  followers_.resize(space_.links.size());
  std::vector<std::size_t> filled(follower_start_.begin(), follower_start_.end() - 1);
  for (Index j = 0; j < n_nodes(); ++j)
    for (const CoarseSpace::Link& link : space_.links_of(j)) followers_[filled[link.node]++] = {j, link.weight};

  Pattern::Builder builder;
  std::vector<Index> rows;
  for (Index c = 0; c < n; ++c) {
    rows.clear();
    const auto add_links = [&](Index node) {
      for (const CoarseSpace::Link& link : space_.links_of(node))
        if (link.node > c) rows.push_back(link.node);
    };
    for (std::size_t f = follower_start_[c]; f < follower_start_[c + 1]; ++f) {
      const Index j = followers_[f].node;
      add_links(j);
      for (const Coupling& coupling : couplings(inner_[j], inner_[j + 1])) {
        add_links(coupling.node);
        n_flops_ += 2.0 * width(coupling.node) * space_.width(c) * (width(j) + space_.width(c));
      }
    }
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    for (const Index r : rows) builder.add_clique(std::array{c, r});
  }
  coarse_pattern_ = Pattern(space_.first_dof, std::move(builder));
  coarse_values_.resize(coarse_pattern_.n_values());
  coarse_x_.resize(space_.first_dof.back());
  const std::vector<char> all(coarse_pattern_.coupling_start(n), 1);
  coarse_elimination_ = Elimination(coarse_pattern_, all);
}

template <class Real>
void TwoLevel<Real>::assemble_coarse(std::span<const double> values, int n_threads) {
#pragma omp parallel for num_threads(n_threads) schedule(dynamic, 16)
  for (Index c = 0; c < space_.n_coarse_nodes(); ++c) {
    const Index width_c = space_.width(c), stride_c = coarse_pattern_.column_height(c);
    double* column = coarse_values_.data() + coarse_pattern_.value_start(c);
    std::fill(column, column + static_cast<std::size_t>(stride_c) * width_c, 0.0);
    for (std::size_t f = follower_start_[c]; f < follower_start_[c + 1]; ++f) {
      const auto& [j, weight] = followers_[f];
      const Index width_j = width(j);
      const Eigen::Map<const Block<double>> w(space_.weights.data() + weight, width_j, width_c);
      // Adds W_iaᵀ K_ij W_jc to block (a, c) for the coarse nodes a ≥ c of node i.
      const auto add = [&](Index i, const auto& k_w) {
        for (const CoarseSpace::Link& link : space_.links_of(i)) {
          if (link.node < c) continue;
          const Index width_a = space_.width(link.node);
          double* to = column + (link.node == c ? 0 : coarse_pattern_.row_offset(link.node, c));
          const double* w_a = space_.weights.data() + link.weight;
          if constexpr (std::decay_t<decltype(k_w)>::RowsAtCompileTime == beam) {
            if (width_a == joint) {
              Eigen::Map<Eigen::Matrix<double, joint, joint>, 0, Eigen::OuterStride<>>(to,
                                                                                       Eigen::OuterStride<>(stride_c))
                  .noalias() += Eigen::Map<const Eigen::Matrix<double, beam, joint>>(w_a).transpose() * k_w;
              continue;
            }
          }
          Eigen::Map<Block<double>, 0, Eigen::OuterStride<>>(to, width_a, width_c, Eigen::OuterStride<>(stride_c)) +=
              Eigen::Map<const Block<double>>(w_a, width(i), width_a).transpose().lazyProduct(k_w);
        }
      };
      const Block<double> own =
          Strided<Block<double>>(values.data() + diagonal_[j], width_j, width_j, Eigen::OuterStride<>(stride_[j]))
              .template selfadjointView<Eigen::Lower>();
      add(j, Block<double>(own.lazyProduct(w)));
      for (const Coupling& coupling : couplings(inner_[j], inner_[j + 1])) {
        const Index i = coupling.node, width_i = width(i);
        if (space_.links_of(i).back().node < c) continue;
        const double* k = values.data() + coupling.value;
        const Eigen::OuterStride<> stride(coupling.stride);
        if (width_i == beam && width_j == beam && width_c == joint) {
          using Square = Eigen::Matrix<double, beam, beam>;
          using Narrow = Eigen::Matrix<double, beam, joint>;
          const Strided<Square> k_ij(k, stride);
          const Eigen::Map<const Narrow> w_jc(w.data());
          Narrow k_w;
          if (coupling.transposed)
            k_w.noalias() = k_ij * w_jc;
          else
            k_w.noalias() = k_ij.transpose() * w_jc;
          add(i, k_w);
        } else if (coupling.transposed) {
          add(i, Block<double>(Strided<Block<double>>(k, width_i, width_j, stride).lazyProduct(w)));
        } else {
          add(i, Block<double>(Strided<Block<double>>(k, width_j, width_i, stride).transpose().lazyProduct(w)));
        }
      }
    }
  }
}

template <class Real>
bool TwoLevel<Real>::factorize(std::span<const double> values, const CoarseSpace& space, int n_threads) {
  if (!trees_.factorize(tree_elimination_, values, n_threads)) return false;
  space_.weights = space.weights;
  assemble_coarse(values, n_threads);
  if (!coarse_.factorize(coarse_elimination_, coarse_values_, n_threads)) return false;
#pragma omp parallel for num_threads(n_threads) schedule(static)
  for (Index j = 0; j < n_nodes(); ++j)
    for (const Coupling& c : couplings(earlier_[j], inner_[j + 1])) {
      if (!c.transposed) continue;
      Real* to = blocks_.data() + c.copy;
      for (Index column = 0; column < width(j); ++column)
        for (Index row = 0; row < width(c.node); ++row)
          *to++ = static_cast<Real>(values[c.value + static_cast<std::size_t>(column) * c.stride + row]);
    }
  return true;
}

/// y ← y − Σ K_ij x_j of the given couplings of node i.
template <class Real>
void TwoLevel<Real>::take_off(Index node, std::span<const Coupling> couplings, Real* y) const {
  const Index own = width(node);
  for (const Coupling& c : couplings) {
    const Index other = width(c.node);
    const Real *block = blocks_.data() + c.copy, *x = x_.data() + first_dof_[c.node];
    if (own == beam && other == beam)
      subtract_product<Eigen::Matrix<Real, beam, beam>>(block, beam, beam, c.transposed, x, y);
    else
      subtract_product<Block<Real>>(block, c.transposed ? other : own, c.transposed ? own : other, c.transposed, x, y);
  }
}

/// Solves for the nodes of a tree, all others as they are, or 0 where they have not been solved for yet.
template <class Real>
void TwoLevel<Real>::solve_tree(Index tree, std::span<const double> b, bool earlier_only) {
  const Elimination& e = tree_elimination_;
  for (Index k = e.first[e.first_descendant[root_[tree]]]; k < e.first[root_[tree] + 1]; ++k) {
    const Index i = e.node[k];
    for (Index d = first_dof_[i]; d < first_dof_[i + 1]; ++d) x_[d] = static_cast<Real>(b[d]);
    take_off(i, couplings(earlier_[i], earlier_only ? later_[i] : inner_[i + 1]), x_.data() + first_dof_[i]);
  }
  trees_.solve_tree(e, root_[tree], x_);
}

template <class Real>
void TwoLevel<Real>::solve(std::span<const double> b, std::span<double> x, int n_threads) {
  const auto n_colours = static_cast<int>(trees_by_colour_.size());
#pragma omp parallel num_threads(n_threads)
  {
    for (int colour = 0; colour < n_colours; ++colour)
#pragma omp for schedule(dynamic, 1)
      for (const Index tree : trees_by_colour_[colour]) solve_tree(tree, b, true);
        // What is left over comes from trees that were solved for later.
#pragma omp for schedule(static)
    for (Index i = 0; i < n_nodes(); ++i) {
      std::fill(residual_.begin() + first_dof_[i], residual_.begin() + first_dof_[i + 1], Real(0));
      take_off(i, couplings(later_[i], inner_[i + 1]), residual_.data() + first_dof_[i]);
    }
#pragma omp for schedule(static)
    for (Index c = 0; c < space_.n_coarse_nodes(); ++c) {
      double* sum = coarse_x_.data() + space_.first_dof[c];
      std::fill(sum, sum + space_.width(c), 0.0);
      for (std::size_t f = follower_start_[c]; f < follower_start_[c + 1]; ++f) {
        const auto& [j, weight] = followers_[f];
        const double* w = space_.weights.data() + weight;
        for (Index d = 0; d < space_.width(c); ++d, w += width(j))
          for (Index r = 0; r < width(j); ++r) sum[d] += w[r] * residual_[first_dof_[j] + r];
      }
    }
  }
  coarse_.solve(coarse_elimination_, coarse_x_, coarse_x_, n_threads);
#pragma omp parallel num_threads(n_threads)
  {
#pragma omp for schedule(static)
    for (Index j = 0; j < n_nodes(); ++j)
      for (const CoarseSpace::Link& link : space_.links_of(j)) {
        const double* w = space_.weights.data() + link.weight;
        for (Index d = 0; d < space_.width(link.node); ++d, w += width(j))
          for (Index r = 0; r < width(j); ++r)
            x_[first_dof_[j] + r] += static_cast<Real>(w[r] * coarse_x_[space_.first_dof[link.node] + d]);
      }
    for (int colour = n_colours - 1; colour >= 0; --colour)
#pragma omp for schedule(dynamic, 1)
      for (const Index tree : trees_by_colour_[colour]) solve_tree(tree, b, false);
#pragma omp for schedule(static)
    for (std::size_t d = 0; d < x_.size(); ++d) x[d] = x_[d];
  }
}

template class TwoLevel<float>;
template class TwoLevel<double>;

}  // namespace trame::micro
