#include "micro/solve/supernodal_factor.h"

#include <cblas.h>
#include <omp.h>

#include <algorithm>
#include <cmath>

extern "C" {
void spotrf_(const char* uplo, const int* n, float* a, const int* lda, int* info);
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
}

namespace trame::micro {

namespace {

// The dense operations of a Cholesky factorisation and its solution, column-major, lower triangles.

bool cholesky(int n, float* a, int lda) {
  int info = 0;
  spotrf_("L", &n, a, &lda, &info);
  return info == 0;
}
bool cholesky(int n, double* a, int lda) {
  int info = 0;
  dpotrf_("L", &n, a, &lda, &info);
  return info == 0;
}
/// B ← B L⁻ᵀ, B m × n
void solve_right(int m, int n, const float* l, int ldl, float* b, int ldb) {
  cblas_strsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, m, n, 1, l, ldl, b, ldb);
}
void solve_right(int m, int n, const double* l, int ldl, double* b, int ldb) {
  cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, m, n, 1, l, ldl, b, ldb);
}
/// C ← C − A Aᵀ, lower triangle, A n × k
void subtract_square(int n, int k, const float* a, int lda, float* c, int ldc) {
  cblas_ssyrk(CblasColMajor, CblasLower, CblasNoTrans, n, k, -1, a, lda, 1, c, ldc);
}
void subtract_square(int n, int k, const double* a, int lda, double* c, int ldc) {
  cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, n, k, -1, a, lda, 1, c, ldc);
}
/// C ← C − A Bᵀ, A m × k, B n × k
void subtract_product(int m, int n, int k, const float* a, const float* b, int ld, float* c, int ldc) {
  cblas_sgemm(CblasColMajor, CblasNoTrans, CblasTrans, m, n, k, -1, a, ld, b, ld, 1, c, ldc);
}
void subtract_product(int m, int n, int k, const double* a, const double* b, int ld, double* c, int ldc) {
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, m, n, k, -1, a, ld, b, ld, 1, c, ldc);
}

/// x ← L⁻¹ x or L⁻ᵀ x
void solve_vector(CBLAS_TRANSPOSE transpose, int n, const float* l, int ld, float* x) {
  cblas_strsv(CblasColMajor, CblasLower, transpose, CblasNonUnit, n, l, ld, x, 1);
}
void solve_vector(CBLAS_TRANSPOSE transpose, int n, const double* l, int ld, double* x) {
  cblas_dtrsv(CblasColMajor, CblasLower, transpose, CblasNonUnit, n, l, ld, x, 1);
}
/// y ← β y + α A x or α Aᵀ x, A m × n
void multiply_add(CBLAS_TRANSPOSE transpose, int m, int n, float alpha, const float* a, int ld, const float* x,
                  float beta, float* y) {
  cblas_sgemv(CblasColMajor, transpose, m, n, alpha, a, ld, x, 1, beta, y, 1);
}
void multiply_add(CBLAS_TRANSPOSE transpose, int m, int n, double alpha, const double* a, int ld, const double* x,
                  double beta, double* y) {
  cblas_dgemv(CblasColMajor, transpose, m, n, alpha, a, ld, x, 1, beta, y, 1);
}

constexpr int tile = 256;             // columns of a task in a large front
constexpr double task_flops = 2e7;    // subtrees and fronts below this are not worth a task
constexpr double task_entries = 5e5;  // nor subtrees below this, where a factor is used
constexpr int task_rows = 2048;       // of a task where a large front is used

/// C ← C − A Aᵀ by tiles of columns, each a task of its own.
template <class Real>
void subtract_square_in_tasks(int n, int k, const Real* a, int lda, Real* c, int ldc) {
  for (int j = 0; j < n; j += tile) {
    const int width = std::min(tile, n - j), below = n - j - width;
#pragma omp task default(none) firstprivate(j, width, below, k, a, lda, c, ldc)
    {
      Real* corner = c + j + static_cast<std::size_t>(j) * ldc;
      subtract_square(width, k, a + j, lda, corner, ldc);
      if (below > 0) subtract_product(below, width, k, a + j + width, a + j, lda, corner + width, ldc);
    }
  }
#pragma omp taskwait
}

}  // namespace

template <class Real>
bool SupernodalFactor<Real>::factorize_front(Real* columns, Index n_rows, Index n_columns, Real* update) {
  const Index n_update = n_rows - n_columns;
  const double flops = static_cast<double>(n_columns) * n_rows * n_rows;
  if (flops < task_flops) {
    if (!cholesky(n_columns, columns, n_rows)) return false;
    if (n_update == 0) return true;
    solve_right(n_update, n_columns, columns, n_rows, columns + n_columns, n_rows);
    subtract_square(n_update, n_columns, columns + n_columns, n_rows, update, n_update);
    return true;
  }
  for (Index p = 0; p < n_columns; p += tile) {
    const Index width = std::min<Index>(tile, n_columns - p), next = p + width;
    Real* diagonal = columns + p + static_cast<std::size_t>(p) * n_rows;
    if (!cholesky(width, diagonal, n_rows)) return false;
    for (Index i = next; i < n_rows; i += 2 * tile) {
      const Index height = std::min<Index>(2 * tile, n_rows - i);
#pragma omp task default(none) firstprivate(i, height, width, diagonal, n_rows, p)
      solve_right(height, width, diagonal, n_rows, diagonal + (i - p), n_rows);
    }
#pragma omp taskwait
    for (Index j = next; j < n_columns; j += tile) {
      const Index w = std::min<Index>(tile, n_columns - j);
#pragma omp task default(none) firstprivate(j, w, width, columns, n_rows, p)
      {
        const Real* left = columns + j + static_cast<std::size_t>(p) * n_rows;
        Real* corner = columns + j + static_cast<std::size_t>(j) * n_rows;
        subtract_square(w, width, left, n_rows, corner, n_rows);
        if (j + w < n_rows) subtract_product(n_rows - j - w, w, width, left + w, left, n_rows, corner + w, n_rows);
      }
    }
#pragma omp taskwait
  }
  if (n_update > 0) subtract_square_in_tasks(n_update, n_columns, columns + n_columns, n_rows, update, n_update);
  return true;
}

template <class Real>
void SupernodalFactor<Real>::eliminate(const Elimination& e, std::span<const double> values, Index s) {
  const Index n_rows = e.n_rows(s), n_columns = e.n_columns(s), n_update = n_rows - n_columns;
  Real* columns = values_.get() + e.value_start[s];
  std::fill(columns, columns + (e.value_start[s + 1] - e.value_start[s]), Real(0));
  const auto rows = e.row_positions(s);
  const Index* row_dof = e.row_dof.data() + e.row_start[s];

  for (Index k = e.first[s]; k < e.first[s + 1]; ++k) {
    const Index w = e.width(k), column = e.first_dof[k] - e.first_dof[e.first[s]];
    std::size_t at = 0;
    for (std::size_t b = e.block_start[k]; b < e.block_start[k + 1]; ++b) {
      const Elimination::Block& block = e.blocks[b];
      while (rows[at] != block.row_position) ++at;
      const Index h = e.width(block.row_position);
      const double* row_scale = scale_.data() + e.first_dof[block.row_position];
      for (Index c = 0; c < w; ++c) {
        const double column_scale = scale_[e.first_dof[k] + c];
        Real* to = columns + static_cast<std::size_t>(column + c) * n_rows + row_dof[at];
        const double* from =
            values.data() + block.value + (block.transposed ? c : static_cast<std::size_t>(c) * block.stride);
        const std::size_t stride = block.transposed ? block.stride : 1;
        for (Index r = 0; r < h; ++r) to[r] = static_cast<Real>(from[r * stride] * column_scale * row_scale[r]);
      }
    }
  }

  if (n_update > 0) {
    update_[s] = std::make_unique_for_overwrite<Real[]>(static_cast<std::size_t>(n_update) * n_update);
    for (Index c = 0; c < n_update; ++c) {
      Real* column = update_[s].get() + static_cast<std::size_t>(c) * n_update;
      std::fill(column + c, column + n_update, Real(0));
    }
  }
  // Adds what the children leave. Runs of rows that follow each other in both are added as one.
  struct Run {
    Index from, to, size;
  };
  thread_local std::vector<Run> runs;
  for (Index i = e.child_start[s]; i < e.child_start[s + 1]; ++i) {
    const Index child = e.children[i];
    const Index child_columns = e.n_columns(child), m = e.n_rows(child) - child_columns;
    const auto child_rows = e.row_positions(child);
    const Index* child_row_dof = e.row_dof.data() + e.row_start[child];
    runs.clear();
    std::size_t at = 0;
    for (std::size_t r = e.n_column_positions(child); r < child_rows.size(); ++r) {
      while (rows[at] != child_rows[r]) ++at;
      const Index from = child_row_dof[r] - child_columns, to = row_dof[at], size = e.width(child_rows[r]);
      // A run ends with the supernode's own columns, since the rest goes to another array.
      if (!runs.empty() && runs.back().to + runs.back().size == to && to != n_columns)
        runs.back().size += size;
      else
        runs.push_back({from, to, size});
    }
    const Real* u = update_[child].get();
    for (std::size_t q = 0; q < runs.size(); ++q)
      for (Index c = 0; c < runs[q].size; ++c) {
        const Index from_column = runs[q].from + c, to_column = runs[q].to + c;
        const Real* from = u + static_cast<std::size_t>(from_column) * m;
        Real* to = to_column < n_columns
                       ? columns + static_cast<std::size_t>(to_column) * n_rows
                       : update_[s].get() + static_cast<std::size_t>(to_column - n_columns) * n_update - n_columns;
        for (Index r = c; r < runs[q].size; ++r) to[runs[q].to + r] += from[runs[q].from + r];
        for (std::size_t p = q + 1; p < runs.size(); ++p)
          for (Index r = 0; r < runs[p].size; ++r) to[runs[p].to + r] += from[runs[p].from + r];
      }
    update_[child].reset();
  }
  if (!factorize_front(columns, n_rows, n_columns, update_[s].get())) failed_ = true;
}

template <class Real>
void SupernodalFactor<Real>::eliminate_subtree(const Elimination& e, std::span<const double> values, Index s) {
  if (e.subtree_flops[s] < task_flops) {
    for (Index t = e.first_descendant[s]; t <= s && !failed_; ++t) eliminate(e, values, t);
    return;
  }
  for (Index i = e.child_start[s]; i < e.child_start[s + 1]; ++i) {
    const Index child = e.children[i];
#pragma omp task default(none) firstprivate(child, values) shared(e) if (e.subtree_flops[child] > task_flops)
    eliminate_subtree(e, values, child);
  }
#pragma omp taskwait
  if (!failed_) eliminate(e, values, s);
}

template <class Real>
bool SupernodalFactor<Real>::factorize(const Elimination& e, std::span<const double> values, int n_threads) {
  if (capacity_ < e.value_start.back()) {
    values_.reset();
    // Memory of a size that will do for the next patterns too need not be mapped anew.
    capacity_ = e.value_start.back() + e.value_start.back() / 10;
    values_ = std::make_unique_for_overwrite<Real[]>(capacity_);
  }
  scale_.resize(e.first_dof.back());
  for (Index k = 0; k < static_cast<Index>(e.node.size()); ++k) {
    const Elimination::Block& diagonal = e.blocks[e.block_start[k]];
    for (Index c = 0; c < e.width(k); ++c) {
      const double d = values[diagonal.value + static_cast<std::size_t>(c) * diagonal.stride + c];
      if (!(d > 0)) return false;
      scale_[e.first_dof[k] + c] = 1 / std::sqrt(d);
    }
  }
  x_.resize(e.first_dof.back());
  fronts_.resize(e.front_start.back());
  update_.clear();
  update_.resize(e.n_supernodes());
  failed_ = false;
#pragma omp parallel num_threads(n_threads)
#pragma omp single
  for (Index s = 0; s < e.n_supernodes(); ++s)
    if (e.parent[s] < 0) {
#pragma omp task default(none) firstprivate(s, values) shared(e)
      eliminate_subtree(e, values, s);
    }
  update_.clear();
  return !failed_;
}

namespace {

/// y ← L⁻¹ y on the columns of a front, and what they take from the rows below. Large fronts are cut in tiles, their
/// rows in tasks.
template <class Real>
void solve_front(const Real* columns, Index n_rows, Index n_columns, Real* front) {
  for (Index p = 0; p < n_columns; p += tile) {
    const Index width = std::min<Index>(tile, n_columns - p);
    const Real* panel = columns + static_cast<std::size_t>(p) * n_rows;
    solve_vector(CblasNoTrans, width, panel + p, n_rows, front + p);
    for (Index i = p + width; i < n_rows; i += task_rows) {
      const Index height = std::min<Index>(task_rows, n_rows - i);
#pragma omp task default(none) firstprivate(i, p, height, width, panel, n_rows, front) if (n_rows > task_rows)
      multiply_add(CblasNoTrans, height, width, -1, panel + i, n_rows, front + p, 1, front + i);
    }
#pragma omp taskwait
  }
}

/// The same for L⁻ᵀ: the rows below are known.
template <class Real>
void solve_front_transposed(const Real* columns, Index n_rows, Index n_columns, Real* front) {
  for (Index end = n_columns; end > 0;) {
    const Index p = (end - 1) / tile * tile, height = n_rows - end;
    const Real* panel = columns + static_cast<std::size_t>(p) * n_rows;
    constexpr int task_columns = 64;
    for (Index c = p; c < end && height > 0; c += task_columns) {
      const Index width = std::min<Index>(task_columns, end - c);
#pragma omp task default(none) firstprivate(c, end, height, width, columns, n_rows, front) if (n_rows > task_rows)
      multiply_add(CblasTrans, height, width, -1, columns + end + static_cast<std::size_t>(c) * n_rows, n_rows,
                   front + end, 1, front + c);
    }
#pragma omp taskwait
    solve_vector(CblasTrans, end - p, panel + p, n_rows, front + p);
    end = p;
  }
}

/// Number of factor entries in the subtree of s.
double subtree_entries(const Elimination& e, Index s) {
  return static_cast<double>(e.value_start[s + 1] - e.value_start[e.first_descendant[s]]);
}

}  // namespace

template <class Real>
void SupernodalFactor<Real>::forward(const Elimination& e, Index s) {
  const Index n_rows = e.n_rows(s), n_columns = e.n_columns(s);
  Real* front = fronts_.data() + e.front_start[s];
  std::copy_n(x_.data() + e.first_dof[e.first[s]], n_columns, front);
  std::fill(front + n_columns, front + n_rows, Real(0));
  const auto rows = e.row_positions(s);
  const Index* row_dof = e.row_dof.data() + e.row_start[s];
  for (Index i = e.child_start[s]; i < e.child_start[s + 1]; ++i) {
    const Index child = e.children[i];
    const auto child_rows = e.row_positions(child);
    const Real* from = fronts_.data() + e.front_start[child] + e.n_columns(child);
    std::size_t at = 0;
    for (std::size_t r = e.n_column_positions(child); r < child_rows.size(); ++r) {
      while (rows[at] != child_rows[r]) ++at;
      for (Index d = 0; d < e.width(child_rows[r]); ++d) front[row_dof[at] + d] += *from++;
    }
  }
  solve_front(values_.get() + e.value_start[s], n_rows, n_columns, front);
}

template <class Real>
void SupernodalFactor<Real>::forward_subtree(const Elimination& e, Index s) {
  if (subtree_entries(e, s) < task_entries) {
    for (Index t = e.first_descendant[s]; t <= s; ++t) forward(e, t);
    return;
  }
  for (Index i = e.child_start[s]; i < e.child_start[s + 1]; ++i) {
    const Index child = e.children[i];
#pragma omp task default(none) firstprivate(child) shared(e) if (subtree_entries(e, child) > task_entries)
    forward_subtree(e, child);
  }
#pragma omp taskwait
  forward(e, s);
}

template <class Real>
void SupernodalFactor<Real>::backward(const Elimination& e, Index s) {
  const Index n_rows = e.n_rows(s), n_columns = e.n_columns(s);
  Real* front = fronts_.data() + e.front_start[s];
  const auto rows = e.row_positions(s);
  Real* to = front + n_columns;
  for (std::size_t r = e.n_column_positions(s); r < rows.size(); ++r)
    for (Index d = e.first_dof[rows[r]]; d < e.first_dof[rows[r] + 1]; ++d) *to++ = x_[d];
  solve_front_transposed(values_.get() + e.value_start[s], n_rows, n_columns, front);
  std::copy_n(front, n_columns, x_.data() + e.first_dof[e.first[s]]);
}

template <class Real>
void SupernodalFactor<Real>::backward_subtree(const Elimination& e, Index s) {
  if (subtree_entries(e, s) < task_entries) {
    for (Index t = s; t >= e.first_descendant[s]; --t) backward(e, t);
    return;
  }
  backward(e, s);
  for (Index i = e.child_start[s]; i < e.child_start[s + 1]; ++i) {
    const Index child = e.children[i];
#pragma omp task default(none) firstprivate(child) shared(e) if (subtree_entries(e, child) > task_entries)
    backward_subtree(e, child);
  }
#pragma omp taskwait
}

template <class Real>
void SupernodalFactor<Real>::solve(const Elimination& e, std::span<const double> b, std::span<double> x,
                                   int n_threads) {
  for (Index k = 0; k < static_cast<Index>(e.node.size()); ++k)
    for (Index c = 0, to = e.first_dof[k]; c < e.width(k); ++c)
      x_[to + c] = static_cast<Real>(b[e.dof[k] + c] * scale_[to + c]);
  const bool worth_threads = e.value_start.back() > 20 * task_entries;
#pragma omp parallel num_threads(n_threads) if (worth_threads)
#pragma omp single
  for (Index s = 0; s < e.n_supernodes(); ++s)
    if (e.parent[s] < 0) {
#pragma omp task default(none) firstprivate(s) shared(e)
      {
        forward_subtree(e, s);
        backward_subtree(e, s);
      }
    }
  for (Index k = 0; k < static_cast<Index>(e.node.size()); ++k)
    for (Index c = 0, from = e.first_dof[k]; c < e.width(k); ++c) x[e.dof[k] + c] = x_[from + c] * scale_[from + c];
}

template <class Real>
void SupernodalFactor<Real>::solve_tree(const Elimination& e, Index root, std::span<Real> b) {
  const Index leaf = e.first_descendant[root], begin = e.first[leaf], end = e.first[root + 1];
  for (Index k = begin; k < end; ++k)
    for (Index c = 0, to = e.first_dof[k]; c < e.width(k); ++c)
      x_[to + c] = b[e.dof[k] + c] * static_cast<Real>(scale_[to + c]);
  for (Index s = leaf; s <= root; ++s) forward(e, s);
  for (Index s = root; s >= leaf; --s) backward(e, s);
  for (Index k = begin; k < end; ++k)
    for (Index c = 0, from = e.first_dof[k]; c < e.width(k); ++c)
      b[e.dof[k] + c] = x_[from + c] * static_cast<Real>(scale_[from + c]);
}

template class SupernodalFactor<float>;
template class SupernodalFactor<double>;

}  // namespace trame::micro
