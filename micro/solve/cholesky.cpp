#include "micro/solve/cholesky.h"

#include <cholmod.h>
#include <omp.h>

#include <stdexcept>
#include <string>

namespace trame::micro {

struct Cholesky::Impl {
  cholmod_common common{};
  cholmod_sparse matrix{};  // values are borrowed at factorisation
  std::vector<int> column_start, rows;
  cholmod_factor* factor = nullptr;
  cholmod_dense *x = nullptr, *y = nullptr, *e = nullptr;  // solution and workspaces, kept between solves

  Impl() {
    cholmod_start(&common);
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_GIVEN;
    common.postorder = 1;
    common.print = 0;
    common.quick_return_if_not_posdef = 1;
    // Not positive definite is an answer here, not an error.
    common.error_handler = nullptr;
  }
  ~Impl() {
    cholmod_free_dense(&x, &common);
    cholmod_free_dense(&y, &common);
    cholmod_free_dense(&e, &common);
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  void require(bool ok, const char* what) const {
    if (!ok) throw std::runtime_error(std::string("CHOLMOD failed in ") + what + ", status " + std::to_string(common.status));
  }
};

Cholesky::Cholesky() : impl_(std::make_unique<Impl>()) {}
Cholesky::~Cholesky() = default;

namespace {

/// Scalar compressed columns of the node pattern. Diagonal blocks are stored whole; CHOLMOD skips their upper part.
void expand(const Layout& layout, const Pattern& pattern, std::vector<int>& column_start, std::vector<int>& rows) {
  if (pattern.n_values() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw std::runtime_error("the matrix has more than 2^31 entries: fewer fibers or elements are needed");
  column_start.resize(layout.n_dofs() + 1);
  rows.resize(pattern.n_values());
  std::size_t at = 0;
  for (Index j = 0; j < pattern.n_nodes(); ++j) {
    const Index n_columns = 3 * layout.n_vectors(j), height = pattern.column_height(j);
    for (Index c = 0; c < n_columns; ++c) {
      column_start[layout.first_dof(j) + c] = static_cast<int>(at + static_cast<std::size_t>(c) * height);
      int* row = rows.data() + at + static_cast<std::size_t>(c) * height;
      for (const Index i : pattern.rows(j))
        for (Index r = 0; r < 3 * layout.n_vectors(i); ++r) *row++ = layout.first_dof(i) + r;
    }
    at += static_cast<std::size_t>(n_columns) * height;
  }
  column_start[layout.n_dofs()] = static_cast<int>(at);
}

/// Fill-reducing order of the nodes.
std::vector<int> order_nodes(const Pattern& pattern, cholmod_common& common) {
  const Index n = pattern.n_nodes();
  std::vector<int> start(n + 1, 0), rows;
  for (Index j = 0; j < n; ++j) {
    const auto nodes = pattern.rows(j);
    rows.insert(rows.end(), nodes.begin(), nodes.end());
    start[j + 1] = static_cast<int>(rows.size());
  }
  cholmod_sparse graph{};
  graph.nrow = graph.ncol = n;
  graph.nzmax = rows.size();
  graph.p = start.data();
  graph.i = rows.data();
  graph.stype = -1;
  graph.itype = CHOLMOD_INT;
  graph.xtype = CHOLMOD_PATTERN;
  graph.dtype = CHOLMOD_DOUBLE;
  graph.sorted = graph.packed = 1;
  std::vector<int> order(n);
  if (!cholmod_metis(&graph, nullptr, 0, 1, order.data(), &common))
    throw std::runtime_error("METIS ordering failed");
  return order;
}

}  // namespace

void Cholesky::analyze(const Layout& layout, const Pattern& pattern) {
  Impl& m = *impl_;
  cholmod_free_factor(&m.factor, &m.common);
  const std::vector<int> order = order_nodes(pattern, m.common);
  std::vector<int> permutation;
  permutation.reserve(layout.n_dofs());
  for (const int node : order)
    for (Index d = 0; d < 3 * layout.n_vectors(node); ++d) permutation.push_back(layout.first_dof(node) + d);

  expand(layout, pattern, m.column_start, m.rows);
  m.matrix.nrow = m.matrix.ncol = layout.n_dofs();
  m.matrix.nzmax = m.rows.size();
  m.matrix.p = m.column_start.data();
  m.matrix.i = m.rows.data();
  m.matrix.x = nullptr;
  m.matrix.stype = -1;
  m.matrix.itype = CHOLMOD_INT;
  m.matrix.xtype = CHOLMOD_PATTERN;
  m.matrix.dtype = CHOLMOD_DOUBLE;
  m.matrix.sorted = m.matrix.packed = 1;
  m.factor = cholmod_analyze_p(&m.matrix, permutation.data(), nullptr, 0, &m.common);
  m.require(m.factor != nullptr, "analysis (is there enough memory?)");
}

bool Cholesky::factorize(std::span<const double> values) {
  Impl& m = *impl_;
  m.matrix.x = const_cast<double*>(values.data());
  m.matrix.xtype = CHOLMOD_REAL;
  // CHOLMOD's own OpenMP loops slow the threaded BLAS down.
  const int levels = omp_get_max_active_levels();
  omp_set_max_active_levels(0);
  const int ok = cholmod_factorize(&m.matrix, m.factor, &m.common);
  omp_set_max_active_levels(levels);
  m.matrix.x = nullptr;
  if (m.common.status == CHOLMOD_NOT_POSDEF) return false;
  m.require(ok != 0, "factorisation (is there enough memory?)");
  return true;
}

void Cholesky::solve(std::span<double> b) {
  Impl& m = *impl_;
  cholmod_dense right{};
  right.nrow = right.d = right.nzmax = b.size();
  right.ncol = 1;
  right.x = b.data();
  right.xtype = CHOLMOD_REAL;
  right.dtype = CHOLMOD_DOUBLE;
  m.require(cholmod_solve2(CHOLMOD_A, m.factor, &right, nullptr, &m.x, nullptr, &m.y, &m.e, &m.common) != 0, "solve");
  const double* solution = static_cast<const double*>(m.x->x);
  std::copy(solution, solution + b.size(), b.begin());
}

double Cholesky::n_factor_entries() const { return impl_->common.lnz; }
double Cholesky::n_factor_flops() const { return impl_->common.fl; }

}  // namespace trame::micro
