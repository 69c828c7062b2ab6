#include "meso/comparison.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "meso/continuum/non_affine.h"
#include "meso/mesh/section_coordinates.h"
#include "meso/parallel_for.h"
#include "meso/sections/places.h"
#include "micro/core/error.h"

namespace trame::meso {
namespace {

using micro::FiberConfiguration;

constexpr std::array<MeshKind, n_mesh_kinds> both_kinds = {MeshKind::delaunay, MeshKind::swept};

std::size_t index_of(MeshKind kind) { return static_cast<std::size_t>(kind); }

void check(const ComparisonSettings& settings) {
  if (settings.meshes.empty()) throw InputError("comparison: no kind of mesh is wanted");
  if (settings.n_stations <= 0)
    throw InputError(fmt::format("comparison: n_stations is {}; it must be above 0", settings.n_stations));
  check(settings.continuum);
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

void check_state(const FiberStates& states, char which, Index index) {
  const Index last = states.n_increments() - 1;
  if (index < 0 || index > last)
    throw InputError(fmt::format("{}: state {} = {}: allowed are 0 … {}", states.name(), which, index, last));
}

}  // namespace

/// Yarns on one kind of mesh.
struct YarnComparer::Meshed {
  std::vector<YarnMesh> meshes;
  std::vector<std::optional<DeformationGradient>> gradients;  ///< where there is a mesh
};

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

std::vector<StatePair> pairs_of_run(const FiberStates& states) {
  const Index last = states.n_increments() - 1;
  const std::string stage = states.read(last).stage;
  Index middle = last;
  while (middle > 0 && states.read(middle).stage == stage) --middle;
  if (middle == 0) return {{0, last}};
  return {{0, middle}, {middle, last}};
}

YarnComparer::YarnComparer(const FiberStates& states, ComparisonSettings settings)
    : states_(states), settings_(std::move(settings)) {
  check(settings_);
  const micro::FiberMesh& fibers = states.header().mesh;
  yarns_ = choose_yarns(fibers.yarns, settings_.yarns);
  const std::vector<Vec3> reference = states.read(0).fibers.r;
  for (auto& meshed : meshed_) {
    meshed = std::make_unique<Meshed>();
    meshed->meshes.resize(yarns_.size());
    meshed->gradients.resize(yarns_.size());
  }
  parallel_for(yarns_.size(), settings_.n_threads, [&](std::size_t y) {
    check_yarn(states, fibers.yarns[yarns_[y]], reference);
    for (const MeshKind kind : both_kinds) {
      Meshed& meshed = *meshed_[index_of(kind)];
      meshed.meshes[y] = mesh_yarn(fibers, yarns_[y], reference, {kind, settings_.limits});
      if (meshed.meshes[y].status == MeshStatus::ok) meshed.gradients[y].emplace(meshed.meshes[y]);
    }
  });
}

YarnComparer::~YarnComparer() = default;

const std::vector<YarnMesh>& YarnComparer::meshes(MeshKind kind) const { return meshed_[index_of(kind)]->meshes; }

Index YarnComparer::n_tets(MeshKind kind) const {
  const auto& all = meshes(kind);
  return std::accumulate(all.begin(), all.end(), Index(0),
                         [](Index n, const YarnMesh& mesh) { return n + static_cast<Index>(mesh.tets.size()); });
}

std::shared_ptr<const StateA> YarnComparer::state_a(Index from) const {
  check_state(states_, 'A', from);
  const auto a = std::make_shared<StateA>();
  a->index = from;
  a->increment = states_.read(from);
  for (const MeshKind kind : settings_.meshes) a->F[index_of(kind)].resize(yarns_.size());
  parallel_for(yarns_.size(), settings_.n_threads, [&](std::size_t y) {
    for (const MeshKind kind : settings_.meshes)
      if (const auto& gradient = meshed_[index_of(kind)]->gradients[y])
        a->F[index_of(kind)][y] = (*gradient)(a->increment.fibers.r);
  });
  return a;
}

YarnFields YarnComparer::fields(std::size_t y, MeshKind kind, const StateStrains& strains) const {
  const Meshed& meshed = *meshed_[index_of(kind)];
  YarnFields fields;
  if (!meshed.gradients[y]) return fields;
  const YarnMesh& mesh = meshed.meshes[y];
  const FiberConfiguration &a = strains.a->increment.fibers, &b = strains.b.fibers;
  fields.strain = strain_between(mesh, strains.a->F[index_of(kind)][y], (*meshed.gradients[y])(b.r), a.tangent);
  fields.nodal = nodal_strain(mesh, fields.strain);
  const micro::FiberMesh& fibers = states_.header().mesh;
  const Index first = fibers.first_node[fibers.yarns[mesh.yarn].first_fiber];
  for (const Index n : mesh.nodes) fields.D2_min.push_back(strains.D2_min[y][n - first]);
  fields.zones = find_shear_zones(mesh, a.r, fields.strain.gamma_max, settings_.zones);
  return fields;
}

StateStrains YarnComparer::strains(const std::shared_ptr<const StateA>& a, Index to) const {
  check_state(states_, 'B', to);
  StateStrains result{.a = a, .to = to, .b = states_.read(to), .D2_min = {}, .meshes = {}};
  result.D2_min.resize(yarns_.size());
  for (const MeshKind kind : settings_.meshes)
    result.meshes.push_back({kind, std::vector<YarnFields>(yarns_.size()), std::vector<YarnStrain>(yarns_.size())});
  const micro::FiberMesh& fibers = states_.header().mesh;
  parallel_for(yarns_.size(), settings_.n_threads, [&](std::size_t y) {
    const micro::Yarn& yarn = fibers.yarns[yarns_[y]];
    if (yarn.n_fibers >= 3)
      result.D2_min[y] = non_affine_residual(fibers, yarn, a->increment.fibers.r, result.b.fibers.r,
                                             settings_.continuum.neighbourhood);
    for (MeshStrains& mesh : result.meshes) {
      mesh.fields[y] = fields(y, mesh.kind, result);
      mesh.summaries[y] = summarise(to, meshes(mesh.kind)[y], mesh.fields[y].strain);
    }
  });
  return result;
}

void YarnComparer::add_bands(YarnComparison& yarn, const FiberConfiguration& a) const {
  const auto& wanted = settings_.bands_of;
  yarn.has_bands = !wanted || std::find(wanted->begin(), wanted->end(), yarn.yarn) != wanted->end();
  for (YarnOnMesh& on : yarn.meshes) {
    if (yarn.has_bands)
      on.bands =
          survey_bands(on.mesh, on.fields.strain, a.r, yarn.sections, settings_.bands, settings_.pixels_per_distance);
    on.orientation = survey_orientation(on.fields.strain, yarn.sections, on.bands);
  }
}

YarnContinuum YarnComparer::continuum(std::size_t y, const YarnComparison& yarn, const StateStrains& strains) const {
  const micro::FiberMesh& fibers = states_.header().mesh;
  // What is not among the meshes that are wanted is needed here all the same.
  std::array<StrainField, n_mesh_kinds> own;
  std::array<const StrainField*, n_mesh_kinds> field{};
  for (const MeshKind kind : both_kinds) {
    const std::size_t k = index_of(kind);
    const auto& gradient = meshed_[k]->gradients[y];
    if (!gradient) continue;
    for (const YarnOnMesh& on : yarn.meshes)
      if (on.kind == kind) field[k] = &on.fields.strain;
    if (field[k] != nullptr) continue;
    const FiberConfiguration& a = strains.a->increment.fibers;
    own[k] = strain_between(meshed_[k]->meshes[y], (*gradient)(a.r), (*gradient)(strains.b.fibers.r), a.tangent);
    field[k] = &own[k];
  }
  const double distance =
      section_coordinates(fibers, fibers.yarns[yarn.yarn], strains.a->increment.fibers.r).fiber_distance;
  return yarn_continuum({.fibers = fibers,
                         .yarn = yarn.yarn,
                         .fiber_distance = distance,
                         .D2_min = strains.D2_min[y],
                         .sections = yarn.sections,
                         .delaunay = {meshes(MeshKind::delaunay)[y], field[index_of(MeshKind::delaunay)]},
                         .swept = {meshes(MeshKind::swept)[y], field[index_of(MeshKind::swept)]}},
                        settings_.continuum);
}

YarnComparison YarnComparer::compare_yarn(std::size_t y, const FiberConfiguration& reference,
                                          StateStrains& strains) const {
  const micro::FiberMesh& fibers = states_.header().mesh;
  const FiberConfiguration &a = strains.a->increment.fibers, &b = strains.b.fibers;
  const micro::Yarn& yarn = fibers.yarns[yarns_[y]];
  const YarnSections in_reference(fibers, yarn, reference), in_a(fibers, yarn, a), in_b(fibers, yarn, b);
  YarnComparison result{.yarn = yarns_[y],
                        .sections = section_pairs(fibers, yarn, a, b, settings_.n_stations),
                        .means = {},
                        .meshes = {},
                        .continuum = {}};
  for (const Place& place : places(fibers, b, yarns_[y], settings_.most_places)) {
    result.sections.push_back(section_pair(fibers, in_a, in_b, place.fraction));
    result.sections.back().place = place.label;
  }
  for (SectionPair& pair : result.sections) pair.reference = in_reference.at_fraction(pair.a.fraction);
  result.means = section_means(result.sections);
  for (MeshStrains& mesh : strains.meshes)
    result.meshes.push_back({.kind = mesh.kind,
                             .mesh = meshes(mesh.kind)[y],
                             .fields = std::move(mesh.fields[y]),
                             .summary = mesh.summaries[y]});
  add_bands(result, a);
  result.continuum = continuum(y, result, strains);
  return result;
}

Comparison YarnComparer::complete(StateStrains strains) const {
  const FiberConfiguration reference = states_.read(0).fibers;
  Comparison result{.pair = {strains.a->index, strains.to}, .a = strains.a->increment, .b = {}, .yarns = {}};
  std::vector<std::optional<YarnComparison>> yarns(yarns_.size());
  parallel_for(yarns_.size(), settings_.n_threads,
               [&](std::size_t y) { yarns[y].emplace(compare_yarn(y, reference, strains)); });
  for (auto& yarn : yarns) result.yarns.push_back(std::move(*yarn));
  result.b = std::move(strains.b);
  result.fabric = fabric_facts(states_.header().mesh, result.b.fibers, fiber_densities(states_.header()),
                               weft_layers(states_.header()));
  return result;
}

Comparison YarnComparer::compare(const StatePair& pair) const { return complete(strains(state_a(pair.from), pair.to)); }

}  // namespace trame::meso
