#include "meso/mesh/yarn_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <utility>

#include "meso/mesh/delaunay.h"
#include "meso/mesh/tetrahedron.h"

namespace trame::meso {
namespace {

using Tets = std::vector<std::array<Index, 4>>;

/// Largest weight of a point in the Delaunay mesh, fiber distance = node spacing = 1, at first; it grows by a tenth of
/// this with each round. A hexagonal lattice keeps its neighbours up to differences of 1.
constexpr double first_max_weight = 0.2;

template <std::size_t n, class Point>
std::array<Point, n> corners(const std::vector<Point>& points, const std::array<Index, n>& cell) {
  std::array<Point, n> x;
  for (std::size_t i = 0; i < n; ++i) x[i] = points[cell[i]];
  return x;
}

/// Cells with a circumradius up to `limit`. Fibers that would lose all of theirs keep those up to twice as large.
template <std::size_t n, class Point>
std::vector<std::array<Index, n>> carve(const std::vector<std::array<Index, n>>& cells,
                                        const std::vector<Point>& points, const std::vector<Index>& fibers,
                                        Index n_fibers, double limit) {
  std::vector<bool> used(n_fibers, false), kept(cells.size());
  for (std::size_t c = 0; c < cells.size(); ++c) {
    kept[c] = circumradius(corners(points, cells[c])) <= limit;
    if (kept[c])
      for (const Index v : cells[c]) used[fibers[v]] = true;
  }
  std::vector<std::array<Index, n>> result;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const bool rescue = std::any_of(cells[c].begin(), cells[c].end(), [&](Index v) { return !used[fibers[v]]; }) &&
                        circumradius(corners(points, cells[c])) <= 2 * limit;
    if (kept[c] || rescue) result.push_back(cells[c]);
  }
  return result;
}

/// The faces of a tetrahedron, each with its vertices sorted.
std::array<std::array<Index, 3>, 4> faces(const std::array<Index, 4>& tet) {
  std::array<std::array<Index, 3>, 4> result;
  for (int i = 0; i < 4; ++i) {
    result[i] = {tet[(i + 1) % 4], tet[(i + 2) % 4], tet[(i + 3) % 4]};
    std::sort(result[i].begin(), result[i].end());
  }
  return result;
}

/// Removes tetrahedra with small dihedral angles from the surface, layer by layer. Returns how many.
Index peel_slivers(Tets& tets, const std::vector<Vec3>& unrolled, double min_dihedral) {
  const std::size_t n_before = tets.size();
  for (bool changed = true; changed;) {
    std::map<std::array<Index, 3>, int> n_cells_at_face;
    for (const auto& tet : tets)
      for (const auto& face : faces(tet)) ++n_cells_at_face[face];
    const auto on_surface = [&](const std::array<Index, 4>& tet) {
      const auto all = faces(tet);
      return std::any_of(all.begin(), all.end(), [&](const auto& face) { return n_cells_at_face[face] == 1; });
    };
    changed = std::erase_if(tets, [&](const auto& tet) {
                return dihedral_range(corners(unrolled, tet))[0] < min_dihedral && on_surface(tet);
              }) > 0;
  }
  return static_cast<Index>(n_before - tets.size());
}

/// Four points on a nearly flat square are covered by a flat tetrahedron (a sliver) as easily as they are split by a
/// diagonal. Small weights of the points, random but the same every time, decide for a diagonal; where that fails,
/// other, larger weights for the points of the slivers are tried (cf. Cheng et al., Sliver exudation, J. ACM 47, 2000):
/// the farther the points are off a lattice, the larger the weights that it takes to turn a sliver.
Tets delaunay_mesh(const SectionCoordinates& section, const MeshLimits& limits, MeshQuality& quality) {
  constexpr int max_rounds = 30;
  std::mt19937 random(1);
  double max_weight = first_max_weight;
  const auto draw = [&] { return max_weight * double(random()) / double(std::mt19937::max()); };
  std::vector<double> weights(section.nodes.size());
  std::generate(weights.begin(), weights.end(), draw);
  Tets best;
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  for (int round = 0; round < max_rounds && fewest > 0; ++round) {
    Tets tets = carve(regular_tetrahedra(section.unrolled, weights), section.unrolled, section.fibers, section.n_fibers,
                      limits.max_circumradius);
    const Index n_removed = peel_slivers(tets, section.unrolled, limits.min_dihedral);
    std::vector<bool> in_sliver(weights.size(), false);
    std::size_t n_slivers = 0;
    for (const auto& tet : tets) {
      if (dihedral_range(corners(section.unrolled, tet))[0] >= limits.min_dihedral) continue;
      ++n_slivers;
      for (const Index v : tet) in_sliver[v] = true;
    }
    max_weight = first_max_weight * (1 + 0.1 * (round + 1));
    for (std::size_t v = 0; v < weights.size(); ++v)
      if (in_sliver[v]) weights[v] = draw();
    if (n_slivers >= fewest) continue;
    fewest = n_slivers;
    best = std::move(tets);
    quality.n_slivers_removed = n_removed;
  }
  return best;
}

/// Triangles between the fibers at mid-length, swept from node to node; each prism is split into three tetrahedra by
/// the order of its fibers, so that neighbouring prisms agree on the diagonal between them.
Tets swept_mesh(const SectionCoordinates& section, const MeshLimits& limits) {
  const Index n_nodes = static_cast<Index>(section.nodes.size()) / section.n_fibers;
  std::vector<Vec2> points;
  std::vector<Index> fibers;
  for (Index f = 0; f < section.n_fibers; ++f) {
    points.emplace_back(section.unrolled[f * n_nodes + n_nodes / 2].head<2>());
    fibers.push_back(f);
  }
  // A prism of height 1 over a triangle of circumradius ρ has the circumradius √(ρ² + 1/4).
  const double limit = std::sqrt(std::max(limits.max_circumradius * limits.max_circumradius - 0.25, 0.0));
  Tets tets;
  for (std::array<Index, 3> triangle : carve(delaunay_triangles(points), points, fibers, section.n_fibers, limit)) {
    std::sort(triangle.begin(), triangle.end());
    const Index a = triangle[0] * n_nodes, b = triangle[1] * n_nodes, c = triangle[2] * n_nodes;
    for (Index k = 0; k + 1 < n_nodes; ++k) {
      tets.push_back({a + k, b + k, c + k, c + k + 1});
      tets.push_back({a + k, b + k, b + k + 1, c + k + 1});
      tets.push_back({a + k, a + k + 1, b + k + 1, c + k + 1});
    }
  }
  for (auto& tet : tets)
    if (volume(corners(section.unrolled, tet)) < 0) std::swap(tet[0], tet[1]);
  return tets;
}

/// Leaves out what has no volume in the reference state, and the vertices that no tetrahedron uses.
void assemble(YarnMesh& mesh, const Tets& tets, const SectionCoordinates& section, const std::vector<Vec3>& r) {
  const double smallest = 1e-9 * section.fiber_distance * section.fiber_distance * section.node_spacing;
  std::vector<Index> vertex(section.nodes.size(), 0);
  std::vector<bool> used(section.nodes.size(), false);
  for (const auto& tet : tets) {
    Tet x;
    for (int i = 0; i < 4; ++i) x[i] = r[section.nodes[tet[i]]];
    if (volume(x) < smallest) {
      ++mesh.quality.n_inverted_removed;
      continue;
    }
    mesh.tets.push_back(tet);
    mesh.volumes.push_back(volume(x));
    for (const Index v : tet) used[v] = true;
  }
  std::vector<bool> fiber_used(section.n_fibers, false);
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (!used[v]) continue;
    fiber_used[section.fibers[v]] = true;
    vertex[v] = static_cast<Index>(mesh.nodes.size());
    mesh.nodes.push_back(section.nodes[v]);
    mesh.reference.push_back(r[section.nodes[v]]);
  }
  for (auto& tet : mesh.tets)
    for (Index& v : tet) v = vertex[v];
  mesh.quality.n_unused_fibers = static_cast<Index>(std::count(fiber_used.begin(), fiber_used.end(), false));
}

void measure(MeshQuality& quality, const Tets& tets, const std::vector<Vec3>& unrolled, double min_dihedral) {
  quality.min_dihedral = 180;
  for (const auto& tet : tets) {
    const auto [smallest, largest] = dihedral_range(corners(unrolled, tet));
    quality.min_dihedral = std::min(quality.min_dihedral, smallest);
    quality.max_dihedral = std::max(quality.max_dihedral, largest);
    if (smallest < min_dihedral) ++quality.n_slivers;
  }
}

void measure_volumes(MeshQuality& quality, const std::vector<double>& volumes) {
  const auto [smallest, largest] = std::minmax_element(volumes.begin(), volumes.end());
  quality.min_volume = *smallest;
  quality.max_volume = *largest;
  for (const double v : volumes) quality.volume += v;
}

}  // namespace

std::string_view text(MeshKind kind) { return kind == MeshKind::swept ? "swept" : "delaunay"; }

std::string_view text(MeshStatus status) {
  switch (status) {
    case MeshStatus::ok: return "ok";
    case MeshStatus::too_few_fibers: return "fewer than 3 fibers enclose no volume";
    case MeshStatus::flat_section: return "all fibers lie in one surface";
    case MeshStatus::unequal_fibers: return "fibers with different numbers of nodes cannot be swept";
  }
  return "";
}

YarnMesh mesh_yarn(const micro::FiberMesh& fibers, Index yarn, const std::vector<Vec3>& r, const MeshOptions& options) {
  const MeshLimits& limits = options.limits;
  YarnMesh mesh;
  mesh.yarn = yarn;
  const auto empty = [&](MeshStatus status) {
    mesh.status = status;
    return mesh;
  };
  if (fibers.yarns[yarn].n_fibers < 3) return empty(MeshStatus::too_few_fibers);
  const SectionCoordinates section = section_coordinates(fibers, fibers.yarns[yarn], r);
  mesh.fiber_distance = section.fiber_distance;
  mesh.node_spacing = section.node_spacing;
  const bool swept = options.kind == MeshKind::swept;
  if (swept && !section.equal_node_counts) return empty(MeshStatus::unequal_fibers);
  const Tets tets = swept ? swept_mesh(section, limits) : delaunay_mesh(section, limits, mesh.quality);
  assemble(mesh, tets, section, r);
  if (mesh.tets.empty()) return empty(MeshStatus::flat_section);
  measure(mesh.quality, tets, section.unrolled, limits.min_dihedral);
  measure_volumes(mesh.quality, mesh.volumes);
  return mesh;
}

}  // namespace trame::meso
