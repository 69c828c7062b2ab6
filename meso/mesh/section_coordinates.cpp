#include "meso/mesh/section_coordinates.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace trame::meso {
namespace {

using micro::FiberMesh;
using micro::Yarn;

/// Position at the fraction u of a fiber's length, linear between nodes.
Vec3 position_at(const FiberMesh& mesh, const std::vector<Vec3>& r, Index fiber, double u) {
  const Index first = mesh.first_node[fiber], last = mesh.first_node[fiber + 1] - 1;
  const double s = u * mesh.length(fiber);
  const auto above = std::lower_bound(mesh.arc_length.begin() + first + 1, mesh.arc_length.begin() + last, s);
  const Index n = static_cast<Index>(above - mesh.arc_length.begin());
  const double t = (s - mesh.arc_length[n - 1]) / (mesh.arc_length[n] - mesh.arc_length[n - 1]);
  return (1 - t) * r[n - 1] + t * r[n];
}

/// The mean of a yarn's fibers at stations of equal fractions of their lengths, with a frame at each.
struct MeanCurve {
  std::vector<Vec3> position;
  std::vector<Mat3> frame;  ///< rows: across, up, along

  /// (across, up, along − arc length of the station) of a point that belongs to the fraction u.
  [[nodiscard]] Vec3 local(const Vec3& point, double u) const {
    const double station = u * double(position.size() - 1);
    const auto k = std::min(static_cast<std::size_t>(station), position.size() - 2);
    const double t = station - double(k);
    return ((1 - t) * frame[k] + t * frame[k + 1]) * (point - (1 - t) * position[k] - t * position[k + 1]);
  }
};

/// Any right-handed frame along `tangent`; "up" is the global z where that is not along the tangent.
Mat3 first_frame(const Vec3& tangent) {
  const Vec3 z = std::abs(tangent.z()) < 0.9 ? Vec3::UnitZ() : Vec3::UnitY();
  Mat3 frame;
  frame.row(2) = tangent;
  frame.row(1) = (z - z.dot(tangent) * tangent).normalized();
  frame.row(0) = frame.row(1).transpose().cross(tangent);
  return frame;
}

/// Turns `frame` about its axis as the fibers have turned in it since the station before (least squares).
Mat3 turned_with_fibers(const Mat3& frame, const std::vector<Vec3>& arms, const Mat3& frame_before,
                        const std::vector<Vec3>& arms_before) {
  double sine = 0, cosine = 0;
  for (std::size_t f = 0; f < arms.size(); ++f) {
    const Vec3 before = frame_before * arms_before[f], now = frame * arms[f];
    sine += before.x() * now.y() - before.y() * now.x();
    cosine += before.x() * now.x() + before.y() * now.y();
  }
  return Eigen::AngleAxisd(-std::atan2(sine, cosine), Vec3::UnitZ()) * frame;
}

MeanCurve mean_curve(const FiberMesh& mesh, const Yarn& yarn, const std::vector<Vec3>& r, Index n_stations) {
  MeanCurve curve;
  std::vector<std::vector<Vec3>> arms(n_stations);  // from the mean curve to each fiber
  for (Index k = 0; k < n_stations; ++k) {
    Vec3 sum = Vec3::Zero();
    for (Index f = 0; f < yarn.n_fibers; ++f) {
      arms[k].push_back(position_at(mesh, r, yarn.first_fiber + f, double(k) / (n_stations - 1)));
      sum += arms[k].back();
    }
    curve.position.push_back(sum / yarn.n_fibers);
    for (Vec3& arm : arms[k]) arm -= curve.position.back();
  }
  for (Index k = 0; k < n_stations; ++k) {
    const Index before = std::max(k - 1, 0), after = std::min(k + 1, n_stations - 1);
    const Vec3 tangent = (curve.position[after] - curve.position[before]).normalized();
    if (k == 0) {
      curve.frame.push_back(first_frame(tangent));
      continue;
    }
    const Mat3& previous = curve.frame.back();
    const Vec3 axis = previous.row(2);
    const Mat3 carried = previous * Eigen::Quaterniond::FromTwoVectors(axis, tangent).toRotationMatrix().transpose();
    curve.frame.push_back(turned_with_fibers(carried, arms[k], previous, arms[k - 1]));
  }
  return curve;
}

/// Median over the fibers of the distance to the nearest other fiber at mid-length.
double fiber_distance(const FiberMesh& mesh, const Yarn& yarn, const std::vector<Vec3>& r) {
  std::vector<double> nearest;
  for (Index a = 0; a < yarn.n_fibers; ++a) {
    double smallest = std::numeric_limits<double>::infinity();
    for (Index b = 0; b < yarn.n_fibers; ++b)
      if (b != a)
        smallest = std::min(
            smallest,
            (position_at(mesh, r, yarn.first_fiber + a, 0.5) - position_at(mesh, r, yarn.first_fiber + b, 0.5)).norm());
    nearest.push_back(smallest);
  }
  std::nth_element(nearest.begin(), nearest.begin() + nearest.size() / 2, nearest.end());
  return nearest[nearest.size() / 2];
}

}  // namespace

SectionCoordinates section_coordinates(const FiberMesh& mesh, const Yarn& yarn, const std::vector<Vec3>& r) {
  SectionCoordinates result;
  result.n_fibers = yarn.n_fibers;
  if (yarn.n_fibers < 2) return result;
  Index most_nodes = 0;
  double length = 0, n_spaces = 0;
  for (Index f = yarn.first_fiber; f < yarn.first_fiber + yarn.n_fibers; ++f) {
    most_nodes = std::max(most_nodes, mesh.n_nodes(f));
    length += mesh.length(f);
    n_spaces += mesh.n_nodes(f) - 1;
    result.equal_node_counts &= mesh.n_nodes(f) == mesh.n_nodes(yarn.first_fiber);
  }
  const double mean_length = length / yarn.n_fibers;
  result.node_spacing = length / n_spaces;
  result.fiber_distance = fiber_distance(mesh, yarn, r);
  const MeanCurve curve = mean_curve(mesh, yarn, r, most_nodes);
  const Vec3 scale(1 / result.fiber_distance, 1 / result.fiber_distance, 1 / result.node_spacing);
  for (Index f = 0; f < yarn.n_fibers; ++f) {
    const Index fiber = yarn.first_fiber + f;
    for (Index n = mesh.first_node[fiber]; n < mesh.first_node[fiber + 1]; ++n) {
      const double u = mesh.arc_length[n] / mesh.length(fiber);
      result.nodes.push_back(n);
      result.fibers.push_back(f);
      result.unrolled.push_back(scale.cwiseProduct(curve.local(r[n], u) + Vec3(0, 0, u * mean_length)));
    }
  }
  return result;
}

}  // namespace trame::meso
