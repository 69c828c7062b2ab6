#pragma once
/// \file
/// Numerical Cholesky factorisation of a matrix whose elimination is known: multifrontal, parallel over the elimination
/// tree and within large fronts, in single or double precision.

#include <atomic>
#include <memory>
#include <span>
#include <vector>

#include "micro/solve/elimination.h"

namespace trame::micro {

template <class Real>
class SupernodalFactor {
 public:
  /// Computes L with P D K D Pᵀ = L Lᵀ, D = diag(K)^(−1/2), from the pattern's values. The result does not depend on
  /// the number of threads. Returns false where the matrix is not positive definite; the factor is then of no use.
  [[nodiscard]] bool factorize(const Elimination& elimination, std::span<const double> values, int n_threads);
  /// x = K⁻¹ b up to the precision of Real, whatever the number of threads. x and b may be the same.
  void solve(const Elimination& elimination, std::span<const double> b, std::span<double> x, int n_threads);
  /// The same for one tree of the elimination, that of `root`, which no other is coupled to: replaces b by x at its
  /// dofs. Trees may be solved at the same time.
  void solve_tree(const Elimination& elimination, Index root, std::span<Real> b);
  /// Gives the memory of the factor back.
  void release() {
    values_.reset();
    capacity_ = 0;
  }

 private:
  void eliminate_subtree(const Elimination& e, std::span<const double> values, Index s);
  void eliminate(const Elimination& e, std::span<const double> values, Index s);
  [[nodiscard]] bool factorize_front(Real* columns, Index n_rows, Index n_columns, Real* update);
  void forward_subtree(const Elimination& e, Index s);
  void forward(const Elimination& e, Index s);
  void backward_subtree(const Elimination& e, Index s);
  void backward(const Elimination& e, Index s);

  std::unique_ptr<Real[]> values_;
  std::size_t capacity_ = 0;
  std::vector<double> scale_;                    // D, in elimination order
  std::vector<std::unique_ptr<Real[]>> update_;  // of each supernode, from its elimination to that of its parent
  std::vector<Real> x_;                          // in elimination order
  std::vector<Real> fronts_;                     // right-hand sides of each supernode's rows
  std::atomic<bool> failed_ = false;
};

}  // namespace trame::micro
