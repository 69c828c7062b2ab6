#pragma once
/// \file
/// Sparse Cholesky factorisation (CHOLMOD, supernodal, METIS on the graph of nodes).

#include <memory>
#include <span>

#include "micro/solve/system.h"

namespace trame::micro {

class Cholesky {
 public:
  Cholesky();
  ~Cholesky();
  Cholesky(const Cholesky&) = delete;
  Cholesky& operator=(const Cholesky&) = delete;

  /// Orders and analyses a pattern. Done once per pattern, whatever the number of factorisations.
  void analyze(const Layout& layout, const Pattern& pattern);
  /// Factorises the matrix with these values. Returns false where it is not positive definite.
  [[nodiscard]] bool factorize(std::span<const double> values);
  /// Solves K x = b in place with the last factor.
  void solve(std::span<double> b);

  [[nodiscard]] double n_factor_entries() const;  ///< non-zeros of L
  [[nodiscard]] double n_factor_flops() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace trame::micro
