#include "micro/model/standing_loads.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include "micro/core/name_table.h"

namespace trame::micro {

namespace {

using Forces = std::vector<Vec3>;

Forces no_forces(const Assembly& assembly) {
  return {static_cast<std::size_t>(assembly.mesh.n_fibers()), Vec3::Zero()};
}

/// Force per length of a load at its full value, of each fiber.
Forces full_forces(const Scene& scene, const Assembly& assembly, const FiberLoad& load) {
  const FiberMesh& mesh = assembly.mesh;
  NameTable yarns;
  for (const Yarn& yarn : mesh.yarns) yarns.add(yarn.name);
  Forces force = no_forces(assembly);
  for (const std::string& pattern : load.fibers)
    for (const Index y : yarns.fitting(pattern))
      for (Index i = 0; i < mesh.yarns[y].n_fibers; ++i) {
        const Index f = mesh.yarns[y].first_fiber + i;
        const FiberType& type = scene.fiber_types[assembly.type_of_fiber[f]];
        const double mass_per_length =
            scene.materials[type.material].density * std::numbers::pi * type.radius * type.radius;
        force[f] = (load.kind == LoadKind::gravity ? mass_per_length : 1) * load.value;
      }
  return force;
}

template <typename Loads>
auto find_by_name(Loads& loads, const std::string& name) {
  return std::find_if(loads.begin(), loads.end(), [&](const auto& load) { return load.name == name; });
}

bool acts(const StandingLoad& load) {
  return std::any_of(load.force.begin(), load.force.end(), [](const Vec3& f) { return !f.isZero(0); });
}

}  // namespace

std::vector<LoadThroughStage> loads_through(const Scene& scene, const Assembly& assembly, const Stage& stage,
                                            const std::vector<StandingLoad>& before) {
  std::vector<LoadThroughStage> loads;
  for (const StandingLoad& load : before)
    if (find_by_name(stage.loads, load.name) == stage.loads.end()) loads.push_back({load, load});
  for (const FiberLoad& load : stage.loads) {
    const auto found = find_by_name(before, load.name);
    loads.push_back({{load.name, found == before.end() ? no_forces(assembly) : found->force},
                     {load.name, full_forces(scene, assembly, load)},
                     load.amplitude});
  }
  return loads;
}

std::vector<FiberLoadTerm> fiber_load_terms(const std::vector<LoadThroughStage>& loads) {
  std::vector<FiberLoadTerm> terms;
  for (const auto& [start, end, amplitude] : loads)
    for (std::size_t f = 0; f < end.force.size(); ++f)
      if (!start.force[f].isZero(0) || !end.force[f].isZero(0))
        terms.push_back({static_cast<Index>(f), start.force[f], end.force[f], amplitude});
  return terms;
}

std::vector<StandingLoad> standing_after(const std::vector<LoadThroughStage>& loads) {
  std::vector<StandingLoad> after;
  for (const auto& [start, end, amplitude] : loads) {
    StandingLoad load = end;
    for (std::size_t f = 0; f < load.force.size(); ++f)
      load.force[f] = FiberLoadTerm{0, start.force[f], end.force[f], amplitude}.at(1);
    if (acts(load)) after.push_back(std::move(load));
  }
  return after;
}

std::vector<StandingLoad> standing_loads(const Scene& scene, const Assembly& assembly, std::size_t n_stages) {
  std::vector<StandingLoad> loads;
  for (std::size_t i = 0; i < n_stages; ++i)
    loads = standing_after(loads_through(scene, assembly, scene.stages[i], loads));
  return loads;
}

bool are_alike(const std::vector<StandingLoad>& a, const std::vector<StandingLoad>& b) {
  constexpr double round_off = 1e-9;
  return a.size() == b.size() && std::all_of(a.begin(), a.end(), [&](const StandingLoad& load) {
           const auto found = find_by_name(b, load.name);
           return found != b.end() &&
                  std::equal(load.force.begin(), load.force.end(), found->force.begin(), found->force.end(),
                             [](const Vec3& x, const Vec3& y) { return (x - y).norm() <= round_off * x.norm(); });
         });
}

}  // namespace trame::micro
