#pragma once
/// \file
/// Solution of K x = b for the lower-triangular block matrices of a Pattern: conjugate gradients behind the factor of
/// what couples nodes strongly, or two levels for the same, which may be in single precision, or of an earlier matrix.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "micro/solve/supernodal_factor.h"
#include "micro/solve/two_level.h"
#include "micro/solve/unsymmetric_terms.h"

namespace trame::micro {

/// Whether a factor of so many entries is in single precision, to begin with.
[[nodiscard]] inline bool is_in_single_precision(FactorPrecision precision, double n_entries) {
  constexpr double many = 1e6;  // that caches do not hold
  return precision == FactorPrecision::single_precision ||
         (precision == FactorPrecision::automatic && n_entries >= many);
}

class LinearSolver {
 public:
  /// Threads work on fronts and parts of fronts, each with a BLAS of one thread, for which the caller's `Threads` see.
  LinearSolver(const Layout& layout, FactorPrecision precision, int n_threads,
               Preconditioner preconditioner = Preconditioner::factor);

  /// Matrices have this pattern from now on; it must outlive its use here. The last factor stays, and may still serve.
  void set_pattern(const Pattern& pattern);
  /// Orders and analyses what couples nodes strongly in the matrix with these values. What has been analysed before of
  /// the same pattern stays as long as it has all of that; otherwise the last factor goes. Without a coarse space there
  /// are no two levels.
  void analyze(std::span<const double> values, const std::function<CoarseSpace()>& coarse_space = {});
  /// Factorises the matrix with these values, which has been analysed, without its weak couplings. Returns false where
  /// it is not positive definite in the precision of the factor, the automatic one in neither.
  [[nodiscard]] bool factorize(std::span<const double> values);
  /// Factorises more exactly from now on: first, until `forget`, in one level, then with all couplings, then in double
  /// precision. Returns false if that was the case already.
  bool refine();

  /// The last factor goes, and with it all that does not follow from the next pattern and matrix.
  void forget();
  void keep(Archive& archive) { archive(precision_); }

  [[nodiscard]] bool has_factor() const { return has_factor_; }
  /// When iterations may end early with what has been found up to there, along which ½ x·K x − b·x falls: never, where
  /// a direction of negative curvature turns up (Steihaug's truncation), or also at the limit of their number.
  enum class Truncated : std::uint8_t { never, at_negative_curvature, at_any_limit };
  /// Solves K x = b in place, up to `tolerance` in the norm of the preconditioned residual relative to that of b.
  /// Returns the number of iterations, or nothing, b unchanged, if `max_iterations` do not suffice, will not at the
  /// pace of the first ones, or K is seen not to be positive definite.
  [[nodiscard]] std::optional<int> solve(std::span<const double> values, std::span<double> b, double tolerance,
                                         int max_iterations, Truncated truncated = Truncated::never);
  /// Solves (K + Σ p qᵀ) x = b likewise, by the generalised minimal residual in the norm of the preconditioned
  /// residual. Nothing is returned either where K is seen not to be positive definite.
  [[nodiscard]] std::optional<int> solve(std::span<const double> values, const UnsymmetricTerms& terms,
                                         std::span<double> b, double tolerance, int max_iterations);
  /// Whether the last solution met a direction of negative curvature.
  [[nodiscard]] bool met_negative_curvature() const { return met_negative_curvature_; }

  /// Whether a direction x of negative curvature, xᵀ K x < 0, turns up in the first `max_iterations` conjugate
  /// gradients from b. False says nothing. Destroys b.
  [[nodiscard]] bool finds_negative_curvature(std::span<const double> values, std::span<double> b, int max_iterations);

  /// Reading an entry of a factor costs about as much as so many flops of a factorisation.
  static constexpr double flops_per_entry = 50;
  [[nodiscard]] bool has_two_levels() const { return in_single_ || in_double_; }
  /// Whether weak couplings count.
  [[nodiscard]] bool is_complete() const { return complete_; }
  /// What a solution by the factor reads, and what a factorisation takes.
  [[nodiscard]] double n_factor_entries() const;
  [[nodiscard]] double n_factor_flops() const;

 private:
  void analyze_two_levels();
  [[nodiscard]] bool is_single() const;
  void precondition(std::span<const double> residual, std::span<double> z);
  /// Begins conjugate gradients at x = 0; returns the norm of the residual, squared: that of the preconditioner's
  /// inverse.
  [[nodiscard]] double begin_iterations(std::span<const double> b);
  /// The curvature of the present direction, K times which is then in product_.
  [[nodiscard]] double curvature(std::span<const double> values);
  /// Goes along the present direction to its lowest point and takes the next direction; returns the new norm, squared.
  [[nodiscard]] double iterate(double curvature, double norm_squared);
  /// The couplings in which |K_vw| > weak · √(tr K_vv tr K_ww) for some pair of their vectors.
  [[nodiscard]] std::vector<char> couplings(std::span<const double> values, double weak) const;
  /// y = K x
  void multiply(std::span<const double> values, std::span<const double> x, std::span<double> y);

  const Layout& layout_;
  const Pattern* pattern_ = nullptr;
  FactorPrecision precision_;
  int n_threads_;
  Preconditioner preconditioner_;
  Elimination elimination_;
  SupernodalFactor<float> single_;
  SupernodalFactor<double> double_;
  std::unique_ptr<TwoLevel<float>>
      in_single_;  // of two levels one of them is there instead, in the precision asked for
  std::unique_ptr<TwoLevel<double>> in_double_;
  CoarseSpace coarse_space_;
  bool analyzed_ = false;         // elimination_ is that of pattern_, not of an earlier one
  bool one_level_ = false;        // two have been given up
  bool complete_ = false;         // weak couplings count
  bool in_double_alone_ = false;  // up to `forget`: single precision has failed where double has not
  std::vector<char> kept_;        // couplings of the pattern that the analysis has
  bool has_factor_ = false;
  bool met_negative_curvature_ = false;
  std::vector<Index> part_start_;             // node columns of each part of the product
  std::vector<std::vector<double>> partial_;  // its contribution to the product
  std::vector<double> x_, residual_, z_, direction_, product_;
};

}  // namespace trame::micro
