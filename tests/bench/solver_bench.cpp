/// \file
/// Time per fiber of what an increment consists of: contact search, assembly, factorisation; for a bundle of three
/// sizes, so that the counter "per fiber" shows what grows faster than the number of fibers.

#include <benchmark/benchmark.h>
#include <omp.h>

#include "micro/contact/contact.h"
#include "micro/fiber/enriched_beam.h"
#include "micro/fiber/rod.h"
#include "micro/solve/linear_solver.h"
#include "micro/weave/flat_start.h"

namespace trame::micro {
namespace {

/// A bundle of fibers of radius 1 that touch their neighbours all along, 40 elements each.
struct Bundle {
  Bundle(Index n_fibers, FiberModel model)
      : assembly(make_assembly(n_fibers, model)), field(assembly.mesh, std::vector(n_fibers, model), layout),
        contact(field, {}, std::vector(n_fibers, 1.0)) {
    state.q.assign(layout.n_vectors(), Vec3::Zero());
    field.read_configuration(assembly.configuration, state);
    contact.begin_step(state, 1);
    contact.update(state, Effect::Update::everything);
    if (model == FiberModel::enriched)
      elastic =
          std::make_unique<EnrichedBeams>(field, std::vector(n_fibers, material()), assembly.configuration, false);
    else
      elastic = std::make_unique<Rods>(field, std::vector(n_fibers, material()));
    Pattern::Builder builder;
    contact.announce(builder);
    elastic->announce(builder);
    pattern = Pattern(layout, builder);
    values.resize(pattern.n_values());
    force.resize(layout.n_dofs());
    magnitude.resize(layout.n_vectors());
  }
  static Material material() { return {"m", 1, 1, 0.4, 0.25, 0.25}; }
  static Assembly make_assembly(Index n_fibers, FiberModel model) {
    Scene scene;
    scene.materials = {material()};
    scene.fiber_types = {{"f", 0, 1.0, model}};
    scene.bundles = {{"b", 0, {{0, 0, 0}, {400, 0, 0}}, 40, n_fibers, 0, 1.0, 0.5}};
    return assemble_scene(scene);
  }
  void assemble(const Effect& effect) {
    Assembler assembler(layout, &pattern, 0, layout.n_nodes(), force.data(), magnitude.data(), values.data(),
                        Assembler::Tangent::exact);
    effect.add(state, assembler);
  }

  Assembly assembly;
  Layout layout;
  FiberField field;
  Contact contact;
  State state;
  std::unique_ptr<Effect> elastic;
  Pattern pattern;
  std::vector<double> values, force, magnitude;
};

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
  bundle.assemble(*bundle.elastic);
  bundle.assemble(bundle.contact);
  for (Index j = 0; j < bundle.layout.n_nodes(); ++j)  // holds the free bundle
    for (Index c = 0; c < 3 * bundle.layout.n_vectors(j); ++c)
      bundle
          .values[bundle.pattern.value_start(j) + static_cast<std::size_t>(c) * bundle.pattern.column_height(j) + c] +=
          0.1;
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
