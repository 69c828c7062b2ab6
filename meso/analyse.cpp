#include "meso/analyse.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "meso/parallel_for.h"
#include "meso/yarns_vtk.h"
#include "micro/core/error.h"

namespace trame::meso {
namespace {

template <class Value>
Statistics statistics(const YarnMesh& mesh, const StrainField& field, Value&& value) {
  std::vector<WeightedValue> values;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    if (!field.flagged[t]) values.push_back({value(t), mesh.volumes[t]});
  return weighted_statistics(std::move(values));
}

YarnStrain summarise(Index increment, const YarnMesh& mesh, const StrainField& field) {
  const auto component = [&](int i) {
    return statistics(mesh, field, [&, i](std::size_t t) { return field.E[t](i, i); });
  };
  return {.increment = increment,
          .yarn = mesh.yarn,
          .n_tets = static_cast<Index>(mesh.tets.size()),
          .n_flagged = field.n_flagged,
          .n_inverted = field.n_inverted,
          .axial = component(0),
          .horizontal = component(1),
          .vertical = component(2),
          .gamma_max = statistics(mesh, field, [&](std::size_t t) { return field.gamma_max[t]; }),
          .det_F = statistics(mesh, field, [&](std::size_t t) { return field.det_F[t]; })};
}

/// What the unrolling of a yarn divides by. A run always has it; a damaged or foreign file may not. Throws InputError.
void check_yarn(const FiberStates& states, const micro::Yarn& yarn, const std::vector<Vec3>& reference) {
  const micro::FiberMesh& fibers = states.header().mesh;
  for (Index f = yarn.first_fiber; f < yarn.first_fiber + yarn.n_fibers; ++f) {
    if (fibers.arc_length[fibers.first_node[f]] != 0)
      throw InputError(
          fmt::format("{}: yarn {}: the arc length of fiber {} does not begin with 0", states.name(), yarn.name, f));
    for (Index n = fibers.first_node[f] + 1; n < fibers.first_node[f + 1]; ++n)
      if (!(std::isfinite(fibers.arc_length[n]) && fibers.arc_length[n] > fibers.arc_length[n - 1]))
        throw InputError(fmt::format("{}: yarn {}: the arc length of fiber {} does not grow from node to node",
                                     states.name(), yarn.name, f));
  }
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

namespace {

/// The states to compare, one by one, with what does not change between them.
class Comparison {
 public:
  /// Meshes the yarns in the reference state and puts them into state A.
  Comparison(const FiberStates& states, const AnalyseOptions& options)
      : states_(states), options_(options), a_(states.read(options.from).fibers) {
    const micro::FiberMesh& fibers = states.header().mesh;
    const std::vector<Index> yarns = choose_yarns(fibers.yarns, options.yarns);
    const std::vector<Vec3> reference = states.read(0).fibers.r;
    analysis.meshes.resize(yarns.size());
    in_a_.resize(yarns.size());
    parallel_for(yarns.size(), options.n_threads, [&](std::size_t y) {
      check_yarn(states, fibers.yarns[yarns[y]], reference);
      analysis.meshes[y] = mesh_yarn(fibers, yarns[y], reference, options.mesh);
      if (analysis.meshes[y].status != MeshStatus::ok) return;
      in_a_[y].gradient.emplace(analysis.meshes[y]);
      in_a_[y].F_a = (*in_a_[y].gradient)(a_.r);
    });
    if (options.vtk_folder.empty()) return;
    vtk_.emplace(fibers, analysis.meshes, options.from, a_.r, options.vtk_folder);
    analysis.pvd = vtk_->pvd();
  }

  void with(Index increment) {
    const micro::Increment b = states_.read(increment);
    analysis.fields.assign(in_a_.size(), {});
    parallel_for(in_a_.size(), options_.n_threads, [&](std::size_t y) {
      if (!in_a_[y].gradient) return;
      analysis.fields[y] = yarn_fields(states_.header().mesh, analysis.meshes[y], in_a_[y].F_a,
                                       (*in_a_[y].gradient)(b.fibers.r), a_, b.fibers);
    });
    analysis.strains.clear();
    for (std::size_t y = 0; y < in_a_.size(); ++y)
      if (in_a_[y].gradient)
        analysis.strains.push_back(summarise(increment, analysis.meshes[y], analysis.fields[y].strain));
    if (options_.on_state) options_.on_state(analysis.strains);
    if (vtk_) vtk_->append(increment, b, analysis.fields);
  }

  Analysis analysis;

 private:
  const FiberStates& states_;
  const AnalyseOptions& options_;
  micro::FiberConfiguration a_;
  std::vector<YarnInStateA> in_a_;
  std::optional<YarnsVtkWriter> vtk_;
};

}  // namespace

Analysis analyse(const FiberStates& states, const AnalyseOptions& options) {
  Comparison compare(states, options);
  std::vector<Index> increments = options.to;
  if (increments.empty()) {
    increments.resize(states.n_increments());
    std::iota(increments.begin(), increments.end(), 0);
  }
  for (const Index increment : increments) compare.with(increment);
  return std::move(compare.analysis);
}

}  // namespace trame::meso
