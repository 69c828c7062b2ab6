#pragma once
/// \file
/// A preconditioner for a system of many parts, as fibers are: symmetric Gauss-Seidel over parts, each of them solved
/// for exactly, and a coarse space that they share.

#include <span>
#include <vector>

#include "micro/solve/coarse_space.h"
#include "micro/solve/supernodal_factor.h"

namespace trame::micro {

template <class Real>
class TwoLevel {
 public:
  /// Structure of the parts, of what couples them, and of the coarse matrix, for those couplings of the pattern that
  /// are `kept`.
  TwoLevel(const Pattern& pattern, std::span<const char> kept, const CoarseSpace& space);

  /// Of the matrix with these values, of which it keeps what it needs; the coarse space has the same structure, but may
  /// have other weights. Returns false where a part or the coarse matrix is not positive definite: nor is the matrix.
  [[nodiscard]] bool factorize(std::span<const double> values, const CoarseSpace& space, int n_threads);
  /// x = M⁻¹ b, with M symmetric, and positive definite if the matrix is. Does not depend on the number of threads.
  void solve(std::span<const double> b, std::span<double> x, int n_threads);

  [[nodiscard]] double n_entries() const { return n_entries_; }  ///< that a solution reads
  [[nodiscard]] double n_flops() const { return n_flops_; }      ///< of a factorisation

 private:
  /// A block K_ij off the diagonal, where it stands in the pattern's values, or its transpose does.
  struct Coupling {
    Index node;  // j
    bool transposed;
    Index stride;
    std::size_t value;
    std::size_t copy;  // of what stands there, in blocks_, where it couples trees
  };
  /// A node of the system that follows a coarse one.
  struct Follower {
    Index node;
    std::size_t weight;
  };

  void find_trees(const Pattern& pattern, std::span<const char> kept, const std::vector<Index>& part);
  void find_couplings(const Pattern& pattern, std::span<const char> kept);
  void find_coarse_structure();
  void assemble_coarse(std::span<const double> values, int n_threads);
  [[nodiscard]] Index n_nodes() const { return static_cast<Index>(first_dof_.size()) - 1; }
  [[nodiscard]] Index width(Index node) const { return first_dof_[node + 1] - first_dof_[node]; }
  [[nodiscard]] std::span<const Coupling> couplings(std::size_t begin, std::size_t end) const {
    return {couplings_.data() + begin, couplings_.data() + end};
  }
  void take_off(Index node, std::span<const Coupling> couplings, Real* y) const;
  void solve_tree(Index tree, std::span<const double> b, bool earlier_only);

  std::vector<Index> first_dof_;       // of each node
  std::vector<std::size_t> diagonal_;  // of each node: where its own block begins in the pattern's values,
  std::vector<Index> stride_;          // and the stride between its columns

  Elimination tree_elimination_;  // of the parts, which are not coupled here
  SupernodalFactor<Real> trees_;
  std::vector<Index> root_;     // of each tree
  std::vector<Index> tree_of_;  // of each node
  std::vector<int> colour_;     // of each tree: coupled ones differ
  std::vector<std::vector<Index>> trees_by_colour_;

  // Of each node, those within its tree, then those with trees of earlier colours, then those of later ones.
  std::vector<Coupling> couplings_;
  std::vector<std::size_t> inner_, earlier_, later_;  // where they begin; one more entry for the end in `inner_`
  std::vector<Real> blocks_;

  CoarseSpace space_;
  std::vector<std::size_t> follower_start_;  // of each coarse node
  std::vector<Follower> followers_;
  Pattern coarse_pattern_;
  std::vector<double> coarse_values_, coarse_x_;
  Elimination coarse_elimination_;
  SupernodalFactor<Real> coarse_;

  double n_entries_ = 0, n_flops_ = 0;
  std::vector<Real> x_, residual_;
};

}  // namespace trame::micro
