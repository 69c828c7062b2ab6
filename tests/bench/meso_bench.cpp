/// \file
/// Strains of the yarns of a patch of the paper's size, from states made in memory: six warp yarns of 24 fibers and six
/// weft yarns of 44, 87 nodes on each, crimped, with fibers off their lattice by some per cent of their distance. The
/// first pair of states pays for the meshes; each further one shows in the difference between 1 and 11 increments. The
/// pair with everything on is what strain_post computes, without reading, tables and the report.

#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <cmath>
#include <filesystem>
#include <random>

#include "meso/strain_series.h"
#include "tests/support/temporary_folder.h"

namespace trame::meso {
namespace {

/// A crimped patch, stretched along x by 0.1 % per increment.
class PatchStates : public FiberStates {
 public:
  explicit PatchStates(Index n_increments) : n_increments_(n_increments) {
    for (Index y = 0; y < 6; ++y) add_yarn(micro::YarnFamily::warp, y, 3, 8);
    for (Index y = 0; y < 6; ++y) add_yarn(micro::YarnFamily::weft, y, 4, 11);
  }
  [[nodiscard]] std::string name() const override { return "patch"; }
  [[nodiscard]] const micro::SnapshotHeader& header() const override { return header_; }
  [[nodiscard]] Index n_increments() const override { return n_increments_; }
  [[nodiscard]] micro::Increment read(Index i) const override {
    micro::Increment increment;
    increment.fibers = reference_;
    for (Vec3& r : increment.fibers.r) r.x() *= 1 + 1e-3 * i;
    // Fibers move by some per cent of their distance against each other, so that there is something to be found.
    std::mt19937 random(static_cast<unsigned>(i));
    if (i > 0)
      for (Vec3& r : increment.fibers.r)
        r.z() += noise * distance * std::uniform_real_distribution<double>(-1, 1)(random);
    return increment;
  }

 private:
  static constexpr Index n_nodes = 87;
  static constexpr double distance = 15e-6, node_spacing = 20e-6, crimp = 60e-6, noise = 0.03;

  void add_yarn(micro::YarnFamily family, Index number, Index n_rows, Index n_columns) {
    micro::FiberMesh& mesh = header_.mesh;
    const auto yarn = static_cast<Index>(mesh.yarns.size());
    mesh.yarns.push_back({std::to_string(yarn), family, mesh.n_fibers(), n_rows * n_columns});
    const double place = number * (n_columns + 2) * distance, phase = M_PI * number;
    for (Index row = 0; row < n_rows; ++row)
      for (Index column = 0; column < n_columns; ++column) {
        mesh.first_node.push_back(mesh.first_node.back() + n_nodes);
        mesh.radius.push_back(0.475 * distance);
        mesh.axial_stiffness.push_back(1);
        mesh.yarn_of_fiber.push_back(yarn);
        const double across = (column + 0.5 * (row % 2) + noise * draw()) * distance;
        const double up = (row + noise * draw()) * distance * std::sqrt(0.75);
        for (Index n = 0; n < n_nodes; ++n) add_node(family, n, place + across, up, phase);
      }
  }
  void add_node(micro::YarnFamily family, Index n, double across, double up, double phase) {
    const bool weft = family == micro::YarnFamily::weft;
    const double along = n * node_spacing, angle = 2 * M_PI * n * 3 / (n_nodes - 1) + phase;
    const double z = up + (weft ? -crimp : crimp) * std::cos(angle);
    header_.mesh.arc_length.push_back(along);
    reference_.r.push_back(weft ? Vec3(across, along, z) : Vec3(along, across, z));
    reference_.g1.push_back(Vec3::UnitZ());
    reference_.g2.push_back(Vec3::UnitZ());
    reference_.tangent.push_back(weft ? Vec3::UnitY() : Vec3::UnitX());
  }
  double draw() { return std::uniform_real_distribution<double>(-1, 1)(random_); }

  Index n_increments_;
  std::mt19937 random_{1};
  micro::SnapshotHeader header_;
  micro::FiberConfiguration reference_;
};

template <MeshKind kind>
void strains_of_a_patch(benchmark::State& bench) {
  const auto n_increments = static_cast<Index>(bench.range(0));
  const PatchStates states(n_increments + 1);
  const trame::test::TemporaryFolder folder;
  StrainSeries series{.vtk_folders = {folder.path()}};
  for (Index i = 1; i <= n_increments; ++i) series.to.push_back(i);
  Index n_tets = 0;
  for (auto _ : bench) {
    const YarnComparer comparer(states, {.meshes = {kind}});
    (void)follow(comparer, series);
    n_tets = comparer.n_tets(kind);
  }
  bench.counters["tets"] = n_tets;
}

double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) / 1024;
}

void pair_with_everything(benchmark::State& bench) {
  const PatchStates states(2);
  const trame::test::TemporaryFolder folder;
  double n_bands = 0, n_zones = 0;
  for (auto _ : bench) {
    const YarnComparer comparer(states);
    const auto comparisons = follow(comparer, {.from = 0, .to = {1}, .compare = {1}, .vtk_folders = {folder.path()}});
    n_bands = n_zones = 0;
    for (const YarnComparison& yarn : comparisons.at(0).yarns) {
      for (const SectionBands& cut : yarn.on_mesh().bands) n_bands += double(cut.bands.size());
      n_zones += double(yarn.on_mesh().fields.zones.zones.size());
    }
  }
  bench.counters["bands"] = n_bands;
  bench.counters["zones"] = n_zones;
  bench.counters["peak_MB"] = peak_megabytes();
}

BENCHMARK(pair_with_everything)->Unit(benchmark::kSecond)->MeasureProcessCPUTime()->UseRealTime();
BENCHMARK(strains_of_a_patch<MeshKind::delaunay>)
    ->Arg(1)
    ->Arg(11)
    ->Unit(benchmark::kSecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK(strains_of_a_patch<MeshKind::swept>)
    ->Arg(1)
    ->Arg(11)
    ->Unit(benchmark::kSecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace trame::meso
