/// \file
/// Time per fiber of what an increment consists of: contact search, assembly, factorisation; for a bundle of three
/// sizes, so that the counter "per fiber" shows what grows faster than the number of fibers.

#include <benchmark/benchmark.h>
#include <omp.h>

#include "tests/bench/bundle.h"

namespace trame::micro {
namespace {

using bench::Bundle;

void report_per_fiber(benchmark::State& bench) {
  bench.counters["per fiber"] = benchmark::Counter(
      static_cast<double>(bench.range(0)), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void contact_search(benchmark::State& bench) {
  const Bundle bundle(static_cast<Index>(bench.range(0)), FiberModel::rod);
  for (auto _ : bench) benchmark::DoNotOptimize(find_proximities(bundle.field, bundle.state, {}));
  report_per_fiber(bench);
}

template <FiberModel model>
void elastic_assembly(benchmark::State& bench) {
  Bundle bundle(static_cast<Index>(bench.range(0)), model);
  for (auto _ : bench) bundle.assemble(*bundle.elastic);
  report_per_fiber(bench);
}

void contact_assembly(benchmark::State& bench) {
  Bundle bundle(static_cast<Index>(bench.range(0)), FiberModel::enriched);
  for (auto _ : bench) bundle.assemble(bundle.contact);
  report_per_fiber(bench);
  bench.counters["elements"] = static_cast<double>(bundle.contact.elements().size());
}

template <FiberModel model, FactorPrecision precision>
void factorization(benchmark::State& bench) {
  Bundle bundle(static_cast<Index>(bench.range(0)), model);
  bundle.assemble_matrix();
  LinearSolver solver(bundle.layout, precision, omp_get_max_threads());
  solver.set_pattern(bundle.pattern);
  for (auto _ : bench)
    if (!solver.factorize(bundle.values)) bench.SkipWithError("not positive definite");
  report_per_fiber(bench);
  bench.counters["entries of L"] = solver.n_factor_entries();
  bench.counters["flops"] = benchmark::Counter(solver.n_factor_flops(), benchmark::Counter::kIsIterationInvariantRate);
}

BENCHMARK(contact_search)->Arg(7)->Arg(37)->Arg(127)->Unit(benchmark::kMillisecond);
BENCHMARK(elastic_assembly<FiberModel::enriched>)->Arg(7)->Arg(37)->Arg(127)->Unit(benchmark::kMillisecond);
BENCHMARK(elastic_assembly<FiberModel::rod>)->Arg(7)->Arg(37)->Arg(127)->Unit(benchmark::kMillisecond);
BENCHMARK(contact_assembly)->Arg(7)->Arg(37)->Arg(127)->Unit(benchmark::kMillisecond);
constexpr FactorPrecision single = FactorPrecision::single_precision, in_double = FactorPrecision::double_precision;
BENCHMARK(factorization<FiberModel::rod, single>)->Arg(7)->Arg(37)->Arg(127)->Unit(benchmark::kMillisecond);
BENCHMARK(factorization<FiberModel::rod, in_double>)->Arg(7)->Arg(37)->Arg(127)->Unit(benchmark::kMillisecond);
BENCHMARK(factorization<FiberModel::enriched, single>)->Arg(7)->Arg(19)->Arg(37)->Unit(benchmark::kMillisecond);
BENCHMARK(factorization<FiberModel::enriched, in_double>)->Arg(7)->Arg(19)->Arg(37)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace trame::micro
