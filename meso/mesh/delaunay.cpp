#include "meso/mesh/delaunay.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Regular_triangulation_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <utility>

namespace trame::meso {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

using Vertex2 = CGAL::Triangulation_vertex_base_with_info_2<Index, Kernel>;
using Delaunay2 = CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Vertex2>>;

using Vertex3 =
    CGAL::Triangulation_vertex_base_with_info_3<Index, Kernel, CGAL::Regular_triangulation_vertex_base_3<Kernel>>;
using Cell3 = CGAL::Regular_triangulation_cell_base_3<Kernel>;
using Regular3 = CGAL::Regular_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<Vertex3, Cell3>>;

}  // namespace

std::vector<std::array<Index, 3>> delaunay_triangles(const std::vector<Vec2>& points) {
  std::vector<std::pair<Kernel::Point_2, Index>> input;
  for (std::size_t i = 0; i < points.size(); ++i)
    input.emplace_back(Kernel::Point_2(points[i].x(), points[i].y()), static_cast<Index>(i));
  const Delaunay2 triangulation(input.begin(), input.end());
  std::vector<std::array<Index, 3>> triangles;
  if (triangulation.dimension() < 2) return triangles;
  for (const auto& face : triangulation.finite_face_handles())
    triangles.push_back({face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
  return triangles;
}

std::vector<std::array<Index, 4>> regular_tetrahedra(const std::vector<Vec3>& points,
                                                     const std::vector<double>& weights) {
  std::vector<std::pair<Kernel::Weighted_point_3, Index>> input;
  for (std::size_t i = 0; i < points.size(); ++i)
    input.emplace_back(Kernel::Weighted_point_3({points[i].x(), points[i].y(), points[i].z()}, weights[i]),
                       static_cast<Index>(i));
  const Regular3 triangulation(input.begin(), input.end());
  std::vector<std::array<Index, 4>> tets;
  if (triangulation.dimension() < 3) return tets;
  for (const auto& cell : triangulation.finite_cell_handles())
    tets.push_back(
        {cell->vertex(0)->info(), cell->vertex(1)->info(), cell->vertex(2)->info(), cell->vertex(3)->info()});
  return tets;
}

}  // namespace trame::meso
