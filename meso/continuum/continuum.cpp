#include "meso/continuum/continuum.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "meso/mesh/delaunay.h"
#include "meso/strain/statistics.h"
#include "micro/core/error.h"

namespace trame::meso {
namespace {

using micro::FiberMesh;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Strains below this are round-off: what is relative to strain is relative to this instead.
constexpr double smallest_strain = 1e-9;

/// Of the volume of a slab; see `mesh_difference`.
constexpr double kept_share = 0.9;

using Pair = std::pair<Index, Index>;

/// Pairs of fibers that edges of the section's Delaunay triangulation join, up to a length in m.
std::set<Pair> neighbour_pairs(const Section& section, double longest) {
  std::vector<Vec2> points;
  for (const FiberCut& cut : section.fibers) points.push_back(cut.centre);
  std::set<Pair> pairs;
  for (const auto& triangle : delaunay_triangles(points))
    for (int k = 0; k < 3; ++k) {
      const Index a = triangle[k], b = triangle[(k + 1) % 3];
      if ((points[a] - points[b]).norm() <= longest)
        pairs.insert(std::minmax(section.fibers[a].fiber, section.fibers[b].fiber));
    }
  return pairs;
}

/// Tetrahedra that are not flagged, with √(E:E), smallest first.
struct Magnitude {
  double strain = 0;
  std::size_t tet = 0;
};

/// The first of `sorted` that together make up the given share of their volume, at least one.
std::vector<Magnitude> smallest_share(std::vector<Magnitude> sorted, const YarnMesh& mesh, double share) {
  double volume = 0, sum = 0;
  for (const Magnitude& m : sorted) volume += mesh.volumes[m.tet];
  std::size_t n = 0;
  while (n < sorted.size() && sum < share * volume) sum += mesh.volumes[sorted[n++].tet];
  sorted.resize(n);
  return sorted;
}

std::vector<Magnitude> sorted_by_strain(const std::vector<std::size_t>& tets, const StrainField& field) {
  std::vector<Magnitude> result;
  for (const std::size_t t : tets)
    if (!field.flagged[t]) result.push_back({field.E[t].norm(), t});
  std::sort(result.begin(), result.end(), [](const Magnitude& a, const Magnitude& b) {
    return std::pair{a.strain, a.tet} < std::pair{b.strain, b.tet};
  });
  return result;
}

double median_strain(const YarnMesh& mesh, const StrainField& field) {
  std::vector<std::size_t> all(mesh.tets.size());
  for (std::size_t t = 0; t < all.size(); ++t) all[t] = t;
  const auto half = smallest_share(sorted_by_strain(all, field), mesh, 0.5);
  return half.empty() ? nan : half.back().strain;
}

/// Tetrahedra of each slab: of equal fractions of the fibers' lengths.
std::vector<std::vector<std::size_t>> slabs(const FiberMesh& fibers, const YarnMesh& mesh, Index n_slabs) {
  std::vector<double> fraction;
  for (const Index n : mesh.nodes) {
    const auto next = std::upper_bound(fibers.first_node.begin(), fibers.first_node.end(), n);
    fraction.push_back(fibers.arc_length[n] / fibers.length(static_cast<Index>(next - fibers.first_node.begin()) - 1));
  }
  std::vector<std::vector<std::size_t>> result(n_slabs);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    double middle = 0;
    for (const Index v : mesh.tets[t]) middle += 0.25 * fraction[v];
    result[std::min(static_cast<Index>(middle * n_slabs), n_slabs - 1)].push_back(t);
  }
  return result;
}

struct Mean {
  Mat3 E = Mat3::Zero();
  double volume = 0;
};

Mean trimmed_mean(const YarnMesh& mesh, const StrainField& field, const std::vector<std::size_t>& tets) {
  Mean mean;
  for (const Magnitude& m : smallest_share(sorted_by_strain(tets, field), mesh, kept_share)) {
    mean.E += mesh.volumes[m.tet] * field.E[m.tet];
    mean.volume += mesh.volumes[m.tet];
  }
  mean.E /= mean.volume;
  return mean;
}

void add_non_affinity(YarnContinuum& row, std::vector<double> D2) {
  std::erase_if(D2, [](double value) { return std::isnan(value); });
  row.n_nodes = static_cast<Index>(D2.size());
  if (D2.empty()) return;
  std::sort(D2.begin(), D2.end());
  row.D2_mean = 0;
  for (const double value : D2) row.D2_mean += value / static_cast<double>(D2.size());
  row.D2_median = quantile(D2, 0.5);
  row.D2_95 = quantile(D2, 0.95);
  row.non_affine_median = std::sqrt(row.D2_median);
  row.non_affine_95 = std::sqrt(row.D2_95);
}

/// What of a row is beyond the limits, in words; empty where all is within. NaN is not held against it.
std::vector<std::string> excesses(const YarnContinuum& row, const ContinuumLimits& limits) {
  std::vector<std::string> words;
  const auto hold = [&](double value, double limit, double unit, const char* format) {
    if (value > limit) words.push_back(fmt::format(fmt::runtime(format), unit * value, unit * limit));
  };
  hold(row.non_affine_95, limits.non_affine_95, 1, "fibers stray by {:.2g} of their distance (limit {:.2g})");
  hold(row.non_affine_share, limits.non_affine_share, 1, "disorder is {:.2g} of the strain (limit {:.2g})");
  hold(row.exchanged, limits.exchanged, 100, "{:.3g} % of the neighbours are new (limit {:.2g} %)");
  hold(row.flagged, limits.flagged, 100, "{:.3g} % of the mesh is inside out (limit {:.2g} %)");
  hold(row.mesh_difference, limits.mesh_difference, 100, "strains differ by {:.3g} % between meshes (limit {:.2g} %)");
  return words;
}

}  // namespace

std::string_view text(ContinuumVerdict verdict) {
  switch (verdict) {
    case ContinuumVerdict::holds: return "continuum holds";
    case ContinuumVerdict::holds_on_average: return "holds on average, not fiber by fiber";
    case ContinuumVerdict::does_not_hold: return "does not hold";
    case ContinuumVerdict::too_few_fibers: return "too few fibers to say";
    case ContinuumVerdict::nothing_to_judge: return "nothing to judge";
  }
  return "";
}

void check(const ContinuumOptions& options) {
  const auto positive = [](const char* name, double value) {
    if (!(value > 0)) throw InputError(fmt::format("continuum: {} is {}; it must be above 0", name, value));
  };
  positive("section_radius", options.neighbourhood.section_radius);
  positive("axial_radius", options.neighbourhood.axial_radius);
  positive("longest_bond", options.longest_bond);
  positive("n_slabs", options.n_slabs);
}

double exchanged_neighbours(const std::vector<SectionPair>& sections, double longest_bond) {
  std::size_t n_pairs = 0, n_exchanged = 0;
  for (const SectionPair& section : sections) {
    if (!section.is_station()) continue;
    std::set<Index> in_b;
    for (const FiberCut& cut : section.b.fibers) in_b.insert(cut.fiber);
    const std::set<Pair> after = neighbour_pairs(section.b, std::numeric_limits<double>::infinity());
    for (const Pair& pair : neighbour_pairs(section.a, longest_bond)) {
      if (!in_b.contains(pair.first) || !in_b.contains(pair.second)) continue;
      ++n_pairs;
      if (!after.contains(pair)) ++n_exchanged;
    }
  }
  return n_pairs == 0 ? nan : double(n_exchanged) / double(n_pairs);
}

double mesh_difference(const FiberMesh& fibers, const YarnMesh& mesh_1, const StrainField& field_1,
                       const YarnMesh& mesh_2, const StrainField& field_2, Index n_slabs) {
  const auto slabs_1 = slabs(fibers, mesh_1, n_slabs), slabs_2 = slabs(fibers, mesh_2, n_slabs);
  double volume = 0, differences = 0, squares = 0;
  for (Index k = 0; k < n_slabs; ++k) {
    const Mean mean_1 = trimmed_mean(mesh_1, field_1, slabs_1[k]), mean_2 = trimmed_mean(mesh_2, field_2, slabs_2[k]);
    if (mean_1.volume == 0 || mean_2.volume == 0) continue;
    const double weight = 0.5 * (mean_1.volume + mean_2.volume);
    volume += weight;
    differences += weight * (mean_1.E - mean_2.E).squaredNorm();
    squares += weight * (0.5 * (mean_1.E + mean_2.E)).squaredNorm();
  }
  if (volume == 0) return nan;
  return std::sqrt(differences / volume) / std::max(std::sqrt(squares / volume), smallest_strain);
}

ContinuumVerdict verdict(const YarnContinuum& row) {
  if (row.n_nodes == 0) return ContinuumVerdict::too_few_fibers;
  if (row.mesh_status != MeshStatus::ok) return ContinuumVerdict::nothing_to_judge;
  if (excesses(row, fiber_by_fiber).empty()) return ContinuumVerdict::holds;
  return excesses(row, on_average).empty() ? ContinuumVerdict::holds_on_average : ContinuumVerdict::does_not_hold;
}

std::string explanation(const YarnContinuum& row) {
  std::string words(text(row.verdict));
  if (row.verdict == ContinuumVerdict::too_few_fibers) return words;
  if (row.verdict == ContinuumVerdict::nothing_to_judge)
    return fmt::format("{}: no mesh, because {}", words, text(row.mesh_status));
  const bool fails = row.verdict == ContinuumVerdict::does_not_hold;
  const char* before = ": ";
  for (const std::string& excess : excesses(row, fails ? on_average : fiber_by_fiber)) {
    words += before + excess;
    before = "; ";
  }
  return words;
}

YarnContinuum yarn_continuum(const ContinuumEvidence& evidence, const ContinuumOptions& options) {
  const auto& [mesh, field] = evidence.delaunay;
  YarnContinuum row{evidence.yarn, mesh.status, 0, nan, nan, nan, nan, nan, nan, nan, nan, nan, nan};
  if (evidence.fibers.yarns[evidence.yarn].n_fibers < 3) return row;
  add_non_affinity(row, evidence.D2_min);
  row.exchanged = exchanged_neighbours(evidence.sections, options.longest_bond * evidence.fiber_distance);
  if (field != nullptr) {
    row.flagged = double(field->n_inverted) / static_cast<double>(mesh.tets.size());
    row.typical_strain = median_strain(mesh, *field);
    row.non_affine_share = row.non_affine_median / std::max(row.typical_strain, smallest_strain);
    if (evidence.swept.field != nullptr)
      row.mesh_difference =
          mesh_difference(evidence.fibers, mesh, *field, evidence.swept.mesh, *evidence.swept.field, options.n_slabs);
  }
  row.verdict = verdict(row);
  return row;
}

}  // namespace trame::meso
