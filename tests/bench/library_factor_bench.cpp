/// \file
/// The same matrices factorised by the libraries: CHOLMOD's own supernodal Cholesky, and MUMPS where it is installed.
/// What the project's own factorisation (solver_bench.cpp, double precision) is there for shows beside them: it takes
/// blocks of nodes as they are, runs in parallel over the elimination tree, and may be in single precision.
///
///     bench --benchmark_filter=factorization

#include <benchmark/benchmark.h>
#include <cholmod.h>
#include <omp.h>

#ifdef TRAME_MUMPS
#include <dmumps_c.h>
#include <mpi.h>
#endif

#include <algorithm>
#include <memory>
#include <vector>

#include "tests/bench/bundle.h"

namespace trame::micro {
namespace {

using bench::Bundle;

/// The lower triangle, entry by entry, rows ascending in each column.
struct Entries {
  std::vector<int> column_start = {0}, row;
  std::vector<double> value;

  explicit Entries(const Bundle& bundle) {
    const Layout& layout = bundle.layout;
    const Pattern& pattern = bundle.pattern;
    for (Index j = 0; j < layout.n_nodes(); ++j)
      for (Index c = 0; c < 3 * layout.n_vectors(j); ++c) {
        const double* column = bundle.values.data() + pattern.value_start(j) +
                               static_cast<std::size_t>(c) * static_cast<std::size_t>(pattern.column_height(j));
        for (const Index i : pattern.rows(j))
          for (Index r = 0; r < 3 * layout.n_vectors(i); ++r) {
            if (layout.first_dof(i) + r < layout.first_dof(j) + c) continue;
            row.push_back(layout.first_dof(i) + r);
            value.push_back(column[pattern.row_offset(i, j) + r]);
          }
        column_start.push_back(static_cast<int>(row.size()));
      }
  }
};

template <FiberModel model>
void cholmod_factorization(benchmark::State& bench) {
  Bundle bundle(static_cast<Index>(bench.range(0)), model);
  bundle.assemble_matrix();
  Entries entries(bundle);
  const auto n = static_cast<std::size_t>(bundle.layout.n_dofs());
  cholmod_common common;
  cholmod_start(&common);
  common.supernodal = CHOLMOD_SUPERNODAL;
  cholmod_sparse matrix{};
  matrix.nrow = matrix.ncol = n;
  matrix.nzmax = entries.row.size();
  matrix.p = entries.column_start.data();
  matrix.i = entries.row.data();
  matrix.x = entries.value.data();
  matrix.stype = -1;
  matrix.itype = CHOLMOD_INT;
  matrix.xtype = CHOLMOD_REAL;
  matrix.dtype = CHOLMOD_DOUBLE;
  matrix.sorted = matrix.packed = 1;
  cholmod_factor* factor = cholmod_analyze(&matrix, &common);
  for (auto _ : bench)
    if (cholmod_factorize(&matrix, factor, &common) == 0 || common.status != CHOLMOD_OK)
      bench.SkipWithError("not positive definite");
  bench.counters["entries of L"] = common.lnz;
  bench.counters["flops"] = benchmark::Counter(common.fl, benchmark::Counter::kIsIterationInvariantRate);
  cholmod_free_factor(&factor, &common);
  cholmod_finish(&common);
}

BENCHMARK(cholmod_factorization<FiberModel::rod>)->Arg(7)->Arg(37)->Arg(127)->Unit(benchmark::kMillisecond);
BENCHMARK(cholmod_factorization<FiberModel::enriched>)->Arg(7)->Arg(19)->Arg(37)->Unit(benchmark::kMillisecond);

#ifdef TRAME_MUMPS
/// MPI from the first use to the end of the process.
void start_mpi() {
  static const struct Mpi {
    Mpi() { MPI_Init(nullptr, nullptr); }
    ~Mpi() { MPI_Finalize(); }
  } mpi;
}

template <FiberModel model>
void mumps_factorization(benchmark::State& bench) {
  start_mpi();
  Bundle bundle(static_cast<Index>(bench.range(0)), model);
  bundle.assemble_matrix();
  Entries entries(bundle);
  std::vector<int> row, column;  // count from 1
  for (std::size_t j = 0; j + 1 < entries.column_start.size(); ++j)
    for (int k = entries.column_start[j]; k < entries.column_start[j + 1]; ++k) {
      row.push_back(entries.row[k] + 1);
      column.push_back(static_cast<int>(j) + 1);
    }
  DMUMPS_STRUC_C mumps{};
  constexpr int init = -1, analysis = 1, factorization = 2, end = -2;
  mumps.comm_fortran = MPI_Comm_c2f(MPI_COMM_SELF);
  mumps.par = 1;
  mumps.sym = 1;  // positive definite
  mumps.job = init;
  dmumps_c(&mumps);
  for (const int silent : {0, 1, 2}) mumps.icntl[silent] = -1;
  mumps.icntl[3] = 0;
  mumps.n = bundle.layout.n_dofs();
  mumps.nnz = static_cast<MUMPS_INT8>(row.size());
  mumps.irn = row.data();
  mumps.jcn = column.data();
  mumps.a = entries.value.data();
  mumps.job = analysis;
  dmumps_c(&mumps);
  mumps.job = factorization;
  for (auto _ : bench) {
    dmumps_c(&mumps);
    if (mumps.infog[0] < 0) bench.SkipWithError("MUMPS failed");
  }
  bench.counters["flops"] = benchmark::Counter(mumps.rinfog[2], benchmark::Counter::kIsIterationInvariantRate);
  mumps.job = end;
  dmumps_c(&mumps);
}

BENCHMARK(mumps_factorization<FiberModel::rod>)->Arg(7)->Arg(37)->Arg(127)->Unit(benchmark::kMillisecond);
BENCHMARK(mumps_factorization<FiberModel::enriched>)->Arg(7)->Arg(19)->Arg(37)->Unit(benchmark::kMillisecond);
#endif

}  // namespace
}  // namespace trame::micro
