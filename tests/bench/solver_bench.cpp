/// \file
/// Time per fiber of what an increment consists of: contact search, assembly, factorisation; for a bundle of three
/// sizes, so that the counter "per fiber" shows what grows faster than the number of fibers.

#include <benchmark/benchmark.h>

#include <random>

#include "micro/fiber/rod_space.h"
#include "micro/solve/threads.h"
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
  const Threads threads(0);
  LinearSolver solver(bundle.layout, precision, threads.n());
  solver.set_pattern(bundle.pattern);
  solver.analyze(bundle.values);
  for (auto _ : bench)
    if (!solver.factorize(bundle.values)) bench.SkipWithError("not positive definite");
  report_per_fiber(bench);
  bench.counters["entries of L"] = solver.n_factor_entries();
  bench.counters["flops"] = benchmark::Counter(solver.n_factor_flops(), benchmark::Counter::kIsIterationInvariantRate);
}

/// A matrix with soft modes behind each preconditioner. Arguments: fibers, elements, penalty over the usual one.
template <Preconditioner preconditioner>
void preconditioned_solution(benchmark::State& bench) {
  Bundle bundle(static_cast<Index>(bench.range(0)), FiberModel::enriched, static_cast<Index>(bench.range(1)),
                ContactLaw{}.penalty * static_cast<double>(bench.range(2)));
  bundle.assemble_matrix(1e-3);
  const Threads threads(0);
  LinearSolver solver(bundle.layout, FactorPrecision::single_precision, threads.n(), preconditioner);
  solver.set_pattern(bundle.pattern);
  std::vector<double> load(bundle.layout.n_dofs());
  std::minstd_rand random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (double& l : load) l = uniform(random);
  int n_iterations = -1;
  for (auto _ : bench) {
    solver.analyze(bundle.values, [&] { return rod_space(bundle.field, bundle.state); });
    std::vector<double> x = load;
    if (solver.factorize(bundle.values)) n_iterations = solver.solve(bundle.values, x, 1e-3, 100).value_or(-1);
  }
  bench.counters["dofs"] = bundle.layout.n_dofs();
  bench.counters["iterations"] = n_iterations;
  bench.counters["entries"] = solver.n_factor_entries();
  bench.counters["flops"] = solver.n_factor_flops();
}

/// One conjugate gradient behind a preconditioner that is there. Argument: fibers.
template <Preconditioner preconditioner>
void linear_iteration(benchmark::State& bench) {
  Bundle bundle(static_cast<Index>(bench.range(0)), FiberModel::enriched);
  bundle.assemble_matrix(1e-3);
  const Threads threads(0);
  LinearSolver solver(bundle.layout, FactorPrecision::single_precision, threads.n(), preconditioner);
  solver.set_pattern(bundle.pattern);
  solver.analyze(bundle.values, [&] { return rod_space(bundle.field, bundle.state); });
  if (!solver.factorize(bundle.values)) bench.SkipWithError("not positive definite");
  std::vector<double> x(bundle.layout.n_dofs());
  constexpr int n_iterations = 6;
  for (auto _ : bench) {
    std::fill(x.begin(), x.end(), 1.0);
    (void)solver.solve(bundle.values, x, 1e-30, n_iterations, LinearSolver::Truncated::at_any_limit);
  }
  bench.counters["an iteration"] = benchmark::Counter(
      n_iterations, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  bench.counters["entries"] = solver.n_factor_entries();
  bench.counters["of K"] = static_cast<double>(bundle.values.size());
}

void systems(benchmark::internal::Benchmark* bench) {
  for (const int n_fibers : {7, 19, 37, 61}) bench->Args({n_fibers, 40, 1});
  for (const int n_elements : {10, 20, 80}) bench->Args({19, n_elements, 1});
  for (const int penalty : {10, 100}) bench->Args({19, 40, penalty});
  bench->Unit(benchmark::kMillisecond);
}
BENCHMARK(preconditioned_solution<Preconditioner::factor>)->Apply(systems);
BENCHMARK(preconditioned_solution<Preconditioner::two_level>)->Apply(systems);

BENCHMARK(linear_iteration<Preconditioner::factor>)->Arg(19)->Arg(61)->Unit(benchmark::kMillisecond);
BENCHMARK(linear_iteration<Preconditioner::two_level>)->Arg(19)->Arg(61)->Unit(benchmark::kMillisecond);

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
