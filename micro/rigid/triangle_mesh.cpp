#include "micro/rigid/triangle_mesh.h"

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/IO/polygon_soup_io.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/shape_predicates.h>
#include <CGAL/Surface_mesh.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>

namespace trame::micro {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;
using Face = Mesh::Face_index;
using Vertex = Mesh::Vertex_index;
using Halfedge = Mesh::Halfedge_index;
using Primitive = CGAL::AABB_face_graph_triangle_primitive<Mesh>;
using AabbTree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;
namespace pmp = CGAL::Polygon_mesh_processing;

Vec3 vec(const Point& p) { return {p.x(), p.y(), p.z()}; }
Point point(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

Mesh mesh_of(const Triangles& t) {
  std::vector<Point> points;
  for (const Vec3& p : t.points) points.push_back(point(p));
  std::vector<std::vector<std::size_t>> faces;
  for (const auto& corners : t.corners) faces.emplace_back(corners.begin(), corners.end());
  if (!pmp::orient_polygon_soup(points, faces))
    throw MeshError("some of its triangles share an edge or a corner with too many others");
  Mesh mesh;
  pmp::polygon_soup_to_polygon_mesh(points, faces, mesh);
  for (const Face f : mesh.faces())
    if (pmp::is_degenerate_triangle_face(f, mesh)) throw MeshError("one of its triangles has no area");
  const auto n_open =
      std::count_if(mesh.halfedges().begin(), mesh.halfedges().end(), [&](Halfedge h) { return mesh.is_border(h); });
  if (n_open > 0) throw MeshError(fmt::format("it is not closed: {} edges have one triangle only", n_open));
  if (pmp::does_self_intersect(mesh)) throw MeshError("it cuts itself");
  pmp::orient_to_bound_a_volume(mesh);
  return mesh;
}

/// The point of a triangle that is nearest to x by its barycentric coordinates, of which those of corners that it does
/// not lie between are exactly 0 (Ericson, Real-Time Collision Detection, 5.1.5).
Vec3 nearest_in(const std::array<Vec3, 3>& corners, const Vec3& x) {
  const auto& [a, b, c] = corners;
  const Vec3 ab = b - a, ac = c - a;
  const double d1 = ab.dot(x - a), d2 = ac.dot(x - a), d3 = ab.dot(x - b), d4 = ac.dot(x - b), d5 = ab.dot(x - c),
               d6 = ac.dot(x - c);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const auto between = [](double from, double to) { return from / (from + to); };
  if (const double v = d1 * d4 - d3 * d2; v <= 0 && d1 >= 0 && d3 <= 0)
    return {1 - between(d1, -d3), between(d1, -d3), 0};
  if (const double v = d5 * d2 - d1 * d6; v <= 0 && d2 >= 0 && d6 <= 0)
    return {1 - between(d2, -d6), 0, between(d2, -d6)};
  if (const double v = d3 * d6 - d5 * d4; v <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return {0, 1 - between(d4 - d3, d5 - d6), between(d4 - d3, d5 - d6)};
  const double of_c = d1 * d4 - d3 * d2, of_b = d5 * d2 - d1 * d6, of_a = d3 * d6 - d5 * d4, sum = of_a + of_b + of_c;
  return {of_a / sum, of_b / sum, of_c / sum};
}

}  // namespace

struct TriangleMesh::Tree {
  Mesh mesh;
  AabbTree tree;
  std::vector<Vec3> face_normal, vertex_normal;

  explicit Tree(Mesh of) : mesh(std::move(of)) {
    tree.insert(faces(mesh).begin(), faces(mesh).end(), mesh);
    tree.build();
    tree.accelerate_distance_queries();
    face_normal.resize(mesh.number_of_faces());
    vertex_normal.assign(mesh.number_of_vertices(), Vec3::Zero());
    for (const Face f : mesh.faces()) {
      const auto [a, b, c] = corners(f);
      face_normal[f] = (b - a).cross(c - a).normalized();
    }
    for (const Halfedge h : mesh.halfedges()) {
      const Vec3 at = position(mesh.target(h)), back = position(mesh.source(h)) - at,
                 on = position(mesh.target(mesh.next(h))) - at;
      vertex_normal[mesh.target(h)] += std::atan2(back.cross(on).norm(), back.dot(on)) * face_normal[mesh.face(h)];
    }
    for (Vec3& n : vertex_normal) n.normalize();
  }

  [[nodiscard]] Vec3 position(Vertex v) const { return vec(mesh.point(v)); }
  /// Of a face, first the target of its halfedge.
  [[nodiscard]] std::array<Vec3, 3> corners(Face f) const {
    const Halfedge h = mesh.halfedge(f), next = mesh.next(h);
    return {position(mesh.target(h)), position(mesh.target(next)), position(mesh.target(mesh.next(next)))};
  }

  /// At an edge or a vertex: the face beside it that x is above, if there is one.
  template <typename Halfedges>
  [[nodiscard]] std::optional<Face> face_below(const Vec3& away, const Halfedges& around) const {
    constexpr double aligned = 1e-7;  // sine of an angle
    for (const Halfedge h : around)
      if (const Face f = mesh.face(h); away.cross(face_normal[f]).norm() <= aligned * away.norm()) return f;
    return std::nullopt;
  }
  [[nodiscard]] Vec3 direction(Halfedge h) const {
    return (position(mesh.target(h)) - position(mesh.source(h))).normalized();
  }

  [[nodiscard]] Nearest at_edge(const Vec3& foot, const Vec3& away, Halfedge h) const {
    const std::array<Halfedge, 2> sides = {h, mesh.opposite(h)};
    if (const auto f = face_below(away, sides)) return {foot, Feature::face, face_normal[*f], Vec3::Zero()};
    const Vec3 normal = face_normal[mesh.face(sides[0])] + face_normal[mesh.face(sides[1])];
    return {foot, Feature::edge, normal.normalized(), direction(h)};
  }
  [[nodiscard]] Nearest at_vertex(const Vec3& foot, const Vec3& away, Vertex v) const {
    constexpr double square = 1e-7;  // cosine of an angle
    const auto around = CGAL::halfedges_around_target(mesh.halfedge(v), mesh);
    if (const auto f = face_below(away, around)) return {foot, Feature::face, face_normal[*f], Vec3::Zero()};
    for (const Halfedge h : around)
      if (std::abs(direction(h).dot(away)) <= square * away.norm()) return at_edge(foot, away, h);
    return {foot, Feature::vertex, vertex_normal[v], Vec3::Zero()};
  }
};

TriangleMesh::TriangleMesh(Triangles triangles)
    : triangles_(std::move(triangles)), tree_(std::make_shared<const Tree>(mesh_of(triangles_))) {}

TriangleMesh::Nearest TriangleMesh::nearest(const Vec3& x) const {
  const Mesh& mesh = tree_->mesh;
  const Face face = tree_->tree.closest_point_and_primitive(point(x)).second;
  const auto corners = tree_->corners(face);
  const Vec3 weights = nearest_in(corners, x);
  const Vec3 foot = weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2];
  std::array<Halfedge, 3> to_corner = {mesh.halfedge(face), mesh.next(mesh.halfedge(face)),
                                       mesh.next(mesh.next(mesh.halfedge(face)))};
  switch ((weights.array() > 0).count()) {
    case 3: break;
    case 2:
      for (int i = 0; i < 3; ++i)  // the halfedge to the corner after the one that is left out goes to the other
        if (weights[i] == 0) return tree_->at_edge(foot, x - foot, to_corner[(i + 2) % 3]);
      break;
    default:
      for (int i = 0; i < 3; ++i)
        if (weights[i] > 0) return tree_->at_vertex(foot, x - foot, mesh.target(to_corner[i]));
  }
  return {foot, Feature::face, tree_->face_normal[face], Vec3::Zero()};
}

Triangles joined(const std::vector<std::vector<Vec3>>& triangles) {
  constexpr auto is_less = [](const Vec3& a, const Vec3& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  };
  std::map<Vec3, Index, decltype(is_less)> known(is_less);
  Triangles joined;
  for (const std::vector<Vec3>& corners : triangles) {
    if (corners.size() != 3) throw MeshError("must be lists of 3 corners");
    auto& triangle = joined.corners.emplace_back();
    for (int i = 0; i < 3; ++i) {
      const auto [found, is_new] = known.emplace(corners[i], static_cast<Index>(joined.points.size()));
      if (is_new) joined.points.push_back(corners[i]);
      triangle[i] = found->second;
    }
  }
  return joined;
}

Triangles read_triangles(const std::filesystem::path& file) {
  constexpr std::size_t most = 20'000;
  constexpr std::uintmax_t most_bytes = 64'000'000;
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error) || !std::ifstream(file)) throw MeshError("cannot be read");
  if (std::filesystem::file_size(file, error) > most_bytes)
    throw MeshError(fmt::format("is larger than {} MB", most_bytes / 1'000'000));
  std::vector<Point> points;
  std::vector<std::vector<std::size_t>> faces;
  if (!CGAL::IO::read_polygon_soup(file.string(), points, faces) || faces.empty())
    throw MeshError("has no triangles; must be STL, OBJ, OFF or PLY, and named so");
  pmp::merge_duplicate_points_in_polygon_soup(points, faces);
  if (faces.size() > most) throw MeshError(fmt::format("{} triangles; must be at most {}", faces.size(), most));
  Triangles read;
  for (const Point& p : points) {
    if (!vec(p).allFinite()) throw MeshError("has a coordinate that is not finite");
    read.points.push_back(vec(p));
  }
  for (const auto& face : faces) {
    if (face.size() != 3) throw MeshError("has a face that is no triangle");
    read.corners.push_back({static_cast<Index>(face[0]), static_cast<Index>(face[1]), static_cast<Index>(face[2])});
  }
  return read;
}

}  // namespace trame::micro
