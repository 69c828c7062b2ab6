#include "meso/analyse.h"

#include <fmt/format.h>
#include <fnmatch.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <numeric>
#include <optional>

#include "meso/strain.h"
#include "meso/yarns_vtk.h"
#include "micro/core/error.h"

namespace trame::meso {
namespace {

/// Runs `work(i)` for 0 ≤ i < n on several threads; what one throws is thrown here.
template <class Work>
void parallel_for(std::size_t n, int n_threads, Work&& work) {
  std::exception_ptr failure;
  const int n_used = n_threads > 0 ? n_threads : omp_get_max_threads();
#pragma omp parallel for schedule(dynamic) num_threads(n_used)
  for (std::size_t i = 0; i < n; ++i) {
    try {
      work(i);
    } catch (...) {
#pragma omp critical(trame_meso_failure)
      failure = std::current_exception();
    }
  }
  if (failure) std::rethrow_exception(failure);
}

template <class Value>
Statistics statistics(const YarnMesh& mesh, const StrainField& field, Value&& value) {
  double weight = 0, sum = 0, squares = 0;
  Statistics result{.min = std::numeric_limits<double>::infinity(), .max = -std::numeric_limits<double>::infinity()};
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (field.flagged[t]) continue;
    weight += mesh.volumes[t];
    sum += mesh.volumes[t] * value(t);
    result.min = std::min(result.min, value(t));
    result.max = std::max(result.max, value(t));
  }
  if (weight == 0) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    return {nan, nan, nan, nan};
  }
  result.mean = sum / weight;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    if (!field.flagged[t]) squares += mesh.volumes[t] * (value(t) - result.mean) * (value(t) - result.mean);
  result.deviation = std::sqrt(squares / weight);
  return result;
}

YarnStrain summarise(Index increment, const YarnMesh& mesh, const StrainField& field) {
  const auto component = [&](int i) {
    return statistics(mesh, field, [&, i](std::size_t t) { return field.E[t](i, i); });
  };
  return {.increment = increment,
          .yarn = mesh.yarn,
          .n_tets = static_cast<Index>(mesh.tets.size()),
          .n_flagged = field.n_flagged,
          .axial = component(0),
          .horizontal = component(1),
          .vertical = component(2),
          .gamma_max = statistics(mesh, field, [&](std::size_t t) { return field.gamma_max[t]; }),
          .det_F = statistics(mesh, field, [&](std::size_t t) { return field.det_F[t]; })};
}

/// What the unrolling of a yarn divides by. A run always has it; a damaged or foreign file may not. Throws InputError.
void check_yarn(const FiberStates& states, const micro::Yarn& yarn, const std::vector<Vec3>& reference) {
  const micro::FiberMesh& fibers = states.header().mesh;
  for (Index f = yarn.first_fiber; f < yarn.first_fiber + yarn.n_fibers; ++f)
    for (Index n = fibers.first_node[f] + 1; n < fibers.first_node[f + 1]; ++n)
      if (!(std::isfinite(fibers.arc_length[n]) && fibers.arc_length[n] > fibers.arc_length[n - 1]))
        throw InputError(fmt::format("{}: yarn {}: the arc length of fiber {} does not grow from node to node",
                                     states.name(), yarn.name, f));
  if (yarn.n_fibers < 3) return;
  for (const Vec3& x : section_coordinates(fibers, yarn, reference).unrolled)
    if (!x.allFinite())
      throw InputError(
          fmt::format("{}: yarn {}: its fibers lie in one another in the reference state", states.name(), yarn.name));
}

/// A yarn's mesh with its deformation gradients in state A.
struct YarnInStateA {
  std::optional<DeformationGradient> gradient;
  std::vector<Mat3> F_a;
};

}  // namespace

std::vector<Index> choose_yarns(const std::vector<micro::Yarn>& yarns, const std::vector<std::string>& patterns) {
  std::vector<bool> chosen(yarns.size(), patterns.empty());
  for (const std::string& pattern : patterns) {
    bool found = false;
    for (std::size_t y = 0; y < yarns.size(); ++y)
      if (fnmatch(pattern.c_str(), yarns[y].name.c_str(), 0) == 0) chosen[y] = found = true;
    if (found) continue;
    std::string names;
    for (const micro::Yarn& yarn : yarns) names += " " + yarn.name;
    throw InputError(fmt::format("no yarn is called \"{}\"; there are:{}", pattern, names));
  }
  std::vector<Index> result;
  for (std::size_t y = 0; y < yarns.size(); ++y)
    if (chosen[y]) result.push_back(static_cast<Index>(y));
  return result;
}

Index Analysis::n_tets() const {
  return std::accumulate(meshes.begin(), meshes.end(), Index(0),
                         [](Index n, const YarnMesh& mesh) { return n + static_cast<Index>(mesh.tets.size()); });
}

Analysis analyse(const FiberStates& states, const AnalyseOptions& options) {
  const micro::FiberMesh& fibers = states.header().mesh;
  const std::vector<Index> yarns = choose_yarns(fibers.yarns, options.yarns);
  const std::vector<Vec3> reference = states.read(0).fibers.r;
  const micro::FiberConfiguration state_a = states.read(options.from).fibers;

  Analysis analysis;
  analysis.meshes.resize(yarns.size());
  std::vector<YarnInStateA> in_a(yarns.size());
  parallel_for(yarns.size(), options.n_threads, [&](std::size_t y) {
    check_yarn(states, fibers.yarns[yarns[y]], reference);
    analysis.meshes[y] = mesh_yarn(fibers, yarns[y], reference, options.mesh);
    if (analysis.meshes[y].status != MeshStatus::ok) return;
    in_a[y].gradient.emplace(analysis.meshes[y]);
    in_a[y].F_a = (*in_a[y].gradient)(state_a.r);
  });

  std::optional<YarnsVtkWriter> vtk;
  if (!options.vtk_folder.empty()) {
    vtk.emplace(fibers, analysis.meshes, options.from, state_a.r, options.vtk_folder);
    analysis.pvd = vtk->pvd();
  }
  std::vector<Index> increments = options.to;
  if (increments.empty()) {
    increments.resize(states.n_increments());
    std::iota(increments.begin(), increments.end(), 0);
  }
  for (const Index increment : increments) {
    const micro::Increment state_b = states.read(increment);
    std::vector<StrainField> strains(yarns.size());
    parallel_for(yarns.size(), options.n_threads, [&](std::size_t y) {
      if (!in_a[y].gradient) return;
      strains[y] =
          strain_between(analysis.meshes[y], in_a[y].F_a, (*in_a[y].gradient)(state_b.fibers.r), state_a.tangent);
    });
    for (std::size_t y = 0; y < yarns.size(); ++y)
      if (in_a[y].gradient) analysis.strains.push_back(summarise(increment, analysis.meshes[y], strains[y]));
    if (vtk) vtk->append(increment, state_b, strains);
  }
  return analysis;
}

}  // namespace trame::meso
