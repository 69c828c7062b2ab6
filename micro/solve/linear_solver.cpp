#include "micro/solve/linear_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <utility>

namespace trame::micro {

namespace {

// The product is summed in so many parts whatever the number of threads, so that it does not depend on that.
constexpr int n_parts = 8;

double dot(std::span<const double> a, std::span<const double> b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// y += a·x, and aᵀ z, of `height` rows.
template <int height>
double add_column(const double* a, double x, const double* z, double* y) {
  using Column = Eigen::Matrix<double, height, 1>;
  const Eigen::Map<const Column> column(a);
  Eigen::Map<Column>(y) += x * column;
  return column.dot(Eigen::Map<const Column>(z));
}
double add_column(Index height, const double* a, double x, const double* z, double* y) {
  switch (height) {
    case 3: return add_column<3>(a, x, z, y);
    case 6: return add_column<6>(a, x, z, y);
    case 9: return add_column<9>(a, x, z, y);
    default: assert(false); return 0;
  }
}

}  // namespace

LinearSolver::LinearSolver(const Layout& layout, FactorPrecision precision, int n_threads,
                           Preconditioner preconditioner)
    : layout_(layout), precision_(precision), n_threads_(n_threads), preconditioner_(preconditioner),
      partial_(n_parts) {
  for (auto* v : {&x_, &residual_, &z_, &direction_, &product_}) v->resize(layout.n_dofs());
  for (auto& v : partial_) v.resize(layout.n_dofs());
}

void LinearSolver::set_pattern(const Pattern& pattern) {
  pattern_ = &pattern;
  analyzed_ = false;
  part_start_.assign(1, 0);
  for (Index j = 0; j < pattern.n_nodes(); ++j)
    while (pattern.value_start(j) * n_parts >= pattern.n_values() * part_start_.size()) part_start_.push_back(j);
  part_start_.resize(n_parts, pattern.n_nodes());
  part_start_.push_back(pattern.n_nodes());
}

void LinearSolver::forget() {
  pattern_ = nullptr;
  elimination_ = {};
  in_single_.reset();
  in_double_.reset();
  analyzed_ = has_factor_ = one_level_ = complete_ = in_double_alone_ = false;
}

std::vector<char> LinearSolver::couplings(std::span<const double> values, double weak) const {
  const Pattern& pattern = *pattern_;
  // By traces and norms of 3 × 3 blocks, which do not depend on the frame.
  const auto block = [&](Index j, std::size_t value, Index v, Index w) {
    const auto stride = static_cast<Index>(pattern.column_height(j));
    return Eigen::Map<const Mat3, 0, Eigen::OuterStride<>>(values.data() + value + 3 * (w * stride + v),
                                                           Eigen::OuterStride<>(stride));
  };
  std::vector<double> size(layout_.n_vectors());
  for (Index j = 0; j < pattern.n_nodes(); ++j)
    for (Index v = 0; v < layout_.n_vectors(j); ++v)
      size[layout_.first_vector(j) + v] = std::max(block(j, pattern.value_start(j), v, v).trace(), 0.0);
  std::vector<char> strong(pattern.coupling_start(pattern.n_nodes()), 0);
#pragma omp parallel for num_threads(n_threads_) schedule(static)
  for (Index j = 0; j < pattern.n_nodes(); ++j) {
    std::size_t coupling = pattern.coupling_start(j), value = pattern.value_start(j);
    for (const Index i : pattern.rows(j)) {
      bool is_strong = i == j;
      for (Index w = 0; w < layout_.n_vectors(j) && !is_strong; ++w)
        for (Index v = 0; v < layout_.n_vectors(i) && !is_strong; ++v)
          is_strong = block(j, value, v, w).squaredNorm() >
                      weak * weak * size[layout_.first_vector(i) + v] * size[layout_.first_vector(j) + w];
      strong[coupling++] = is_strong;
      value += 3 * layout_.n_vectors(i);
    }
  }
  return strong;
}

void LinearSolver::analyze(std::span<const double> values, const std::function<CoarseSpace()>& coarse_space) {
  // What has just come above the limit was kept before.
  constexpr double weak = 1e-4, weak_when_analyzed = 3e-5;
  if (analyzed_) {
    const std::vector<char> needed = couplings(values, complete_ ? 0 : weak);
    if (std::equal(needed.begin(), needed.end(), kept_.begin(), [](char n, char k) { return k || !n; })) {
      if (has_two_levels()) coarse_space_ = coarse_space();
      return;
    }
  }
  kept_ = couplings(values, complete_ ? 0 : weak_when_analyzed);
  in_single_.reset();
  in_double_.reset();
  has_factor_ = false;
  analyzed_ = true;
  // A space of rods alone is no coarser.
  const auto finds_coarser_space = [&] {
    if (one_level_ || !coarse_space) return false;
    coarse_space_ = coarse_space();
    return coarse_space_.first_dof.back() < layout_.n_dofs();
  };
  if (preconditioner_ == Preconditioner::two_level && finds_coarser_space()) return analyze_two_levels();
  elimination_ = Elimination(*pattern_, kept_);
  constexpr double small = 5e10;  // flops that are not worth a look
  if (preconditioner_ != Preconditioner::automatic || elimination_.n_flops < small || !finds_coarser_space()) return;
  // A factor is read three times for a solution and serves three or four of them; two levels are read seven times and
  // serve two.
  constexpr double advantage = 4;
  const double one = n_factor_flops() + 3 * flops_per_entry * n_factor_entries();
  Elimination one_level = std::move(elimination_);
  analyze_two_levels();
  const double two = n_factor_flops() + 7 * flops_per_entry * n_factor_entries();
  if (one > advantage * two) return;
  in_single_.reset();
  in_double_.reset();
  elimination_ = std::move(one_level);
}

void LinearSolver::analyze_two_levels() {
  if (precision_ != FactorPrecision::double_precision)
    in_single_ = std::make_unique<TwoLevel<float>>(*pattern_, kept_, coarse_space_);
  else
    in_double_ = std::make_unique<TwoLevel<double>>(*pattern_, kept_, coarse_space_);
  elimination_ = {};
  single_.release();
  double_.release();
}

bool LinearSolver::is_single() const {
  return !in_double_alone_ && is_in_single_precision(precision_, n_factor_entries());
}

bool LinearSolver::factorize(std::span<const double> values) {
  if (in_single_) return has_factor_ = in_single_->factorize(values, coarse_space_, n_threads_);
  if (in_double_) return has_factor_ = in_double_->factorize(values, coarse_space_, n_threads_);
  if (is_single()) {
    has_factor_ = single_.factorize(elimination_, values, n_threads_);
    if (has_factor_ || precision_ == FactorPrecision::single_precision) return has_factor_;
    single_.release();
    return has_factor_ = in_double_alone_ = double_.factorize(elimination_, values, n_threads_);
  }
  return has_factor_ = double_.factorize(elimination_, values, n_threads_);
}

bool LinearSolver::refine() {
  if (has_two_levels()) {
    analyzed_ = has_factor_ = false;
    return one_level_ = true;
  }
  if (!complete_) return complete_ = true;
  if (precision_ == FactorPrecision::double_precision) return false;
  precision_ = FactorPrecision::double_precision;
  has_factor_ = false;
  single_.release();
  return true;
}

double LinearSolver::n_factor_entries() const {
  if (in_single_) return in_single_->n_entries();
  if (in_double_) return in_double_->n_entries();
  return elimination_.value_start.empty() ? 0 : static_cast<double>(elimination_.value_start.back());
}

double LinearSolver::n_factor_flops() const {
  if (in_single_) return in_single_->n_flops();
  if (in_double_) return in_double_->n_flops();
  return elimination_.n_flops;
}

void LinearSolver::precondition(std::span<const double> residual, std::span<double> z) {
  if (in_single_)
    in_single_->solve(residual, z, n_threads_);
  else if (in_double_)
    in_double_->solve(residual, z, n_threads_);
  else if (is_single())
    single_.solve(elimination_, residual, z, n_threads_);
  else
    double_.solve(elimination_, residual, z, n_threads_);
}

void LinearSolver::multiply(std::span<const double> values, std::span<const double> x, std::span<double> y) {
#pragma omp parallel for num_threads(n_threads_) schedule(dynamic, 1)
  for (int part = 0; part < n_parts; ++part) {
    std::vector<double>& sum = partial_[part];
    std::fill(sum.begin(), sum.end(), 0.0);
    for (Index j = part_start_[part]; j < part_start_[part + 1]; ++j) {
      const Index first = layout_.first_dof(j), width = layout_.first_dof(j + 1) - first;
      const double* column = values.data() + pattern_->value_start(j);
      const auto rows = pattern_->rows(j);
      for (Index c = 0; c < width; ++c, column += pattern_->column_height(j)) {
        const double xc = x[first + c];
        sum[first + c] += column[c] * xc;
        double own = 0;
        for (Index r = c + 1; r < width; ++r) {
          sum[first + r] += column[r] * xc;
          own += column[r] * x[first + r];
        }
        const double* value = column + width;
        for (const Index i : rows.subspan(1)) {
          const Index begin = layout_.first_dof(i), height = layout_.first_dof(i + 1) - begin;
          own += add_column(height, value, xc, x.data() + begin, sum.data() + begin);
          value += height;
        }
        sum[first + c] += own;
      }
    }
  }
#pragma omp parallel for num_threads(n_threads_) schedule(static)
  for (std::size_t d = 0; d < y.size(); ++d) {
    double sum = 0;
    for (const auto& part : partial_) sum += part[d];
    y[d] = sum;
  }
}

double LinearSolver::begin_iterations(std::span<const double> b) {
  std::fill(x_.begin(), x_.end(), 0.0);
  std::copy(b.begin(), b.end(), residual_.begin());
  precondition(residual_, z_);
  direction_ = z_;
  return dot(residual_, z_);
}

double LinearSolver::curvature(std::span<const double> values) {
  multiply(values, direction_, product_);
  return dot(direction_, product_);
}

double LinearSolver::iterate(double curvature, double norm_squared) {
  const double alpha = norm_squared / curvature;
  for (std::size_t d = 0; d < x_.size(); ++d) {
    x_[d] += alpha * direction_[d];
    residual_[d] -= alpha * product_[d];
  }
  precondition(residual_, z_);
  const double next = dot(residual_, z_), beta = next / norm_squared;
  for (std::size_t d = 0; d < x_.size(); ++d) direction_[d] = z_[d] + beta * direction_[d];
  return next;
}

namespace {

constexpr double neutral = 1e-6;  // a curvature of no size against that of the preconditioner is round-off

/// Whether iterations that have come so far, by the square of what is left of the residual, will not reach the goal.
bool is_too_slow(double left, double goal, int iteration, int max_iterations) {
  constexpr int judged_from = 4;
  return iteration >= judged_from && std::log(left) * max_iterations > std::log(goal) * iteration;
}

}  // namespace

bool LinearSolver::finds_negative_curvature(std::span<const double> values, std::span<double> b, int max_iterations) {
  double rz = begin_iterations(b),
         by_preconditioner = rz;  // curvatures of the direction: of the preconditioner, and of K
  // The part of the load in one direction of many, in all likelihood. Where K has a negative curvature that has not
  // turned up, what is left of the load in its direction grows with each iteration.
  constexpr double small_part = 0.1;
  const double negligible = small_part * small_part / static_cast<double>(b.size()) * rz;
  for (int i = 0; i < max_iterations && rz > negligible; ++i) {
    const double by_k = curvature(values);
    if (by_k < -neutral * by_preconditioner) return true;
    if (!(by_k > 0)) return false;
    const double next = iterate(by_k, rz), beta = next / rz;
    by_preconditioner = next + beta * beta * by_preconditioner;
    rz = next;
  }
  return false;
}

std::optional<int> LinearSolver::solve(std::span<const double> values, std::span<double> b, double tolerance,
                                       int max_iterations, Truncated truncated) {
  met_negative_curvature_ = false;
  double rz = begin_iterations(b);
  if (!std::isfinite(rz)) return std::nullopt;
  // Two levels of an indefinite matrix may themselves be indefinite.
  const auto is_indefinite = [&] { return has_two_levels() && rz < 0; };
  if (is_indefinite()) {
    met_negative_curvature_ = true;
    return std::nullopt;
  }
  const double start = rz, goal = tolerance * tolerance * rz;
  double by_preconditioner = rz;  // curvature of the direction
  int iteration = 0;
  while (rz > goal) {
    if (iteration == max_iterations) {
      if (truncated != Truncated::at_any_limit) return std::nullopt;
      break;
    }
    if (truncated != Truncated::at_any_limit && is_too_slow(rz / start, goal / start, iteration, max_iterations))
      return std::nullopt;
    const double along = curvature(values);
    // K is singular.
    if (truncated != Truncated::never && std::abs(along) <= neutral * by_preconditioner) return std::nullopt;
    if (!(along > 0)) {
      met_negative_curvature_ = true;
      if (truncated == Truncated::never || !std::isfinite(along)) return std::nullopt;
      if (iteration == 0) x_ = direction_;
      break;
    }
    ++iteration;
    const double next = iterate(along, rz), beta = next / rz;
    by_preconditioner = next + beta * beta * by_preconditioner;
    rz = next;
    if (is_indefinite()) {
      met_negative_curvature_ = true;
      if (truncated == Truncated::never) return std::nullopt;
    }
  }
  std::copy(x_.begin(), x_.end(), b.begin());
  return iteration;
}

std::optional<int> LinearSolver::solve(std::span<const double> values, const UnsymmetricTerms& terms,
                                       std::span<double> b, double tolerance, int max_iterations) {
  met_negative_curvature_ = false;
  // Residuals v and directions z = M⁻¹ v, orthonormal: vᵢ·zⱼ = δᵢⱼ.
  std::vector<Eigen::VectorXd> v, z;
  const auto n_dofs = static_cast<Eigen::Index>(b.size());
  Eigen::Map<Eigen::VectorXd> next(product_.data(), n_dofs), next_z(z_.data(), n_dofs);
  const auto add_direction = [&] {
    precondition(product_, z_);
    const double norm = std::sqrt(next.dot(next_z));
    v.emplace_back(next / norm);
    z.emplace_back(next_z / norm);
    return norm;
  };
  std::copy(b.begin(), b.end(), product_.begin());
  const double start = add_direction();
  if (!(start > 0)) return std::nullopt;  // two levels of an indefinite matrix may themselves be indefinite
  Eigen::MatrixXd along = Eigen::MatrixXd::Zero(max_iterations + 1, max_iterations),  // zᵢ·(K + Σ p qᵀ) zⱼ
      curvature = Eigen::MatrixXd::Zero(max_iterations, max_iterations);              // zᵢ·K zⱼ
  for (int n = 0; n < max_iterations; ++n) {
    std::copy(z[n].begin(), z[n].end(), direction_.begin());
    multiply(values, direction_, product_);
    for (int i = 0; i <= n; ++i) curvature(i, n) = curvature(n, i) = z[i].dot(next);
    if (curvature.topLeftCorner(n + 1, n + 1).llt().info() != Eigen::Success) {
      met_negative_curvature_ = true;
      return std::nullopt;
    }
    terms.add_product(direction_, product_);
    for (int i = 0; i <= n; ++i) {
      along(i, n) = z[i].dot(next);
      next -= along(i, n) * v[i];
    }
    along(n + 1, n) = add_direction();
    if (!std::isfinite(along(n + 1, n))) return std::nullopt;
    const auto square = along.topLeftCorner(n + 2, n + 1);
    const Eigen::VectorXd load = start * Eigen::VectorXd::Unit(n + 2, 0), x = square.householderQr().solve(load);
    const double left = (load - square * x).norm() / start;
    if (left <= tolerance) {
      Eigen::Map<Eigen::VectorXd> solution(b.data(), n_dofs);
      solution.setZero();
      for (int i = 0; i <= n; ++i) solution += x[i] * z[i];
      return n + 1;
    }
    if (is_too_slow(left * left, tolerance * tolerance, n + 1, max_iterations)) return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace trame::micro
