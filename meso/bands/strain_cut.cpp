#include "meso/bands/strain_cut.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "meso/mesh/tetrahedron.h"
#include "micro/core/error.h"

namespace trame::meso {
namespace {

using Polygon = std::vector<Vec2>;

/// Where the plane with these signed distances of the corners cuts a tetrahedron: three or four points in the plane,
/// counter-clockwise; none where all corners are on one side. A corner in the plane counts as above it, so that
/// neighbours always agree.
Polygon intersection(const std::array<Vec2, 4>& in_plane, const std::array<double, 4>& distance) {
  Polygon polygon;
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b)
      if (distance[a] >= 0 && distance[b] < 0)
        polygon.push_back((distance[a] * in_plane[b] - distance[b] * in_plane[a]) / (distance[a] - distance[b]));
  Vec2 centre = Vec2::Zero();
  for (const Vec2& x : polygon) centre += x / double(polygon.size());
  std::sort(polygon.begin(), polygon.end(), [&](const Vec2& p, const Vec2& q) {
    return std::atan2(p.y() - centre.y(), p.x() - centre.x()) < std::atan2(q.y() - centre.y(), q.x() - centre.x());
  });
  return polygon;
}

/// True also on the outline, so that no pixel falls between two neighbours.
bool contains(const Polygon& polygon, const Vec2& x, double tolerance) {
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 &p = polygon[i], edge = polygon[(i + 1) % polygon.size()] - p, arm = x - p;
    if (edge.x() * arm.y() - edge.y() * arm.x() < -tolerance * edge.norm()) return false;
  }
  return true;
}

struct CutTet {
  Index tet;
  Polygon polygon;
};

/// Wider pieces are not shown, fiber distances.
constexpr double widest_piece = 20;

bool is_wide(const Polygon& polygon, double fiber_distance) {
  Eigen::AlignedBox2d box;
  for (const Vec2& x : polygon) box.extend(x);
  return !(box.sizes().maxCoeff() <= widest_piece * fiber_distance);
}

std::vector<CutTet> cut_tets(const YarnMesh& mesh, const std::vector<Vec3>& positions, const CutPlane& plane) {
  Mat3 frame;  // rows: horizontal, vertical, normal
  frame << plane.horizontal.transpose(), plane.vertical.transpose(), plane.horizontal.cross(plane.vertical).transpose();
  std::vector<Vec3> local;
  for (const Index n : mesh.nodes) local.emplace_back(frame * (positions[n] - plane.origin));
  std::vector<CutTet> result;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    Tet corners;
    std::array<Vec2, 4> in_plane;
    std::array<double, 4> distance;
    for (int i = 0; i < 4; ++i) {
      corners[i] = local[mesh.tets[t][i]];
      in_plane[i] = corners[i].head<2>();
      distance[i] = corners[i].z();
    }
    const auto [lowest, highest] = std::minmax_element(distance.begin(), distance.end());
    if (!(*lowest < 0 && *highest >= 0 && volume(corners) > 0)) continue;
    Polygon polygon = intersection(in_plane, distance);
    if (!is_wide(polygon, mesh.fiber_distance)) result.push_back({static_cast<Index>(t), std::move(polygon)});
  }
  return result;
}

/// Gives the pixels in a polygon to its tetrahedron, except those that have one already.
void fill(YarnCut& cut, const CutTet& piece) {
  Eigen::AlignedBox2d box;
  for (const Vec2& x : piece.polygon) box.extend(x);
  const Vec2 low = (box.min() - cut.corner) / cut.pixel, high = (box.max() - cut.corner) / cut.pixel;
  const auto first = [](double x, Index n) { return std::clamp(static_cast<Index>(std::ceil(x - 1e-9)), 0, n); };
  const auto end = [](double x, Index n) { return std::clamp(static_cast<Index>(std::floor(x + 1e-9)) + 1, 0, n); };
  for (Index row = first(low.y(), cut.n_rows()); row < end(high.y(), cut.n_rows()); ++row)
    for (Index column = first(low.x(), cut.n_columns()); column < end(high.x(), cut.n_columns()); ++column) {
      const Vec2 centre = cut.centre(row, column);
      if (cut.inside(row, column) || !contains(piece.polygon, centre, 1e-9 * cut.pixel)) continue;
      cut.inside(row, column) = true;
      cut.tet(row, column) = piece.tet;
    }
}

}  // namespace

CutPlane section_plane(const Section& section) { return {section.origin, section.frame.row(1), section.frame.row(2)}; }

CutPlane longitudinal_plane(const Section& section) {
  return {section.origin, section.frame.row(0), section.frame.row(2)};
}

YarnCut cut_yarn(const YarnMesh& mesh, const std::vector<Vec3>& positions, const CutPlane& plane,
                 double pixels_per_distance) {
  if (!(pixels_per_distance >= 1))
    throw InputError(fmt::format("pixels per fiber distance: {}; must be at least 1", pixels_per_distance));
  YarnCut cut{
      .plane = plane, .pixel = mesh.fiber_distance / pixels_per_distance, .fiber_distance = mesh.fiber_distance};
  const std::vector<CutTet> pieces = cut_tets(mesh, positions, plane);
  if (pieces.empty()) return cut;
  Eigen::AlignedBox2d box;
  for (const CutTet& piece : pieces)
    for (const Vec2& x : piece.polygon) box.extend(x);
  // Half a pixel in from the outline, so that the pictures of a yarn and of the same yarn shifted are the same.
  cut.corner = box.min() + Vec2::Constant(0.5 * cut.pixel);
  const auto count = [&](double width) { return static_cast<Index>(std::floor(width / cut.pixel + 0.5)); };
  cut.inside = Mask::Constant(count(box.sizes().y()), count(box.sizes().x()), false);
  cut.tet.setZero(cut.inside.rows(), cut.inside.cols());
  for (const CutTet& piece : pieces) fill(cut, piece);
  return cut;
}

Picture sample(const YarnCut& cut, const std::vector<double>& values) {
  Picture picture = Picture::Constant(cut.n_rows(), cut.n_columns(), std::numeric_limits<double>::quiet_NaN());
  for (Index i = 0; i < picture.size(); ++i)
    if (cut.inside(i)) picture(i) = values[cut.tet(i)];
  return picture;
}

std::vector<double> component(const StrainField& field, int i, int j) {
  std::vector<double> values;
  for (const Mat3& E : field.E) values.push_back(E(i, j));
  return values;
}

}  // namespace trame::meso
