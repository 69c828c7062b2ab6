#include "meso/sections/sections.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "meso/strain/strain.h"
#include "micro/fiber/lagrange.h"

namespace trame::meso {
namespace {

using micro::FiberConfiguration;
using micro::FiberMesh;
using micro::Yarn;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double gauss_point = 0.5 * std::numbers::inv_sqrt3;  // ± this from the middle of an interval of length 1

/// A fiber runs along the plane, rather than through it, at angles below 6°: its section is more than 10 times as long.
constexpr double smallest_sine = 0.1;

/// A mean curve that is shorter than this, against its fibers' reference length, has no direction.
constexpr double smallest_stretch = 1e-6;

/// Corners of a fiber's outline: the hull falls short of the fibers by at most R (1 − cos π/64) = 0.0012 R.
constexpr int n_outline_points = 64;

/// A 3-node element at one arc length.
struct ElementShape {
  Index first_node = 0;
  micro::LagrangeShape shape;

  [[nodiscard]] Vec3 interpolate(const std::vector<Vec3>& nodal) const { return shape.interpolate(nodal, first_node); }
  [[nodiscard]] Vec3 derivative(const std::vector<Vec3>& nodal) const { return shape.derivative(nodal, first_node); }
};

/// First node of the element of a fiber that holds the arc length s.
Index element_at(const FiberMesh& mesh, Index fiber, double s) {
  const Index first = mesh.first_node[fiber];
  const auto begin = mesh.arc_length.begin() + first, end = mesh.arc_length.begin() + mesh.first_node[fiber + 1];
  const Index before = static_cast<Index>(std::upper_bound(begin + 1, end - 1, s) - begin) - 1;
  return first + 2 * (before / 2);
}

ElementShape element_shape(const FiberMesh& mesh, Index first_node, double s) {
  return {first_node, micro::lagrange_shape(&mesh.arc_length[first_node], s)};
}

/// A point of the mean curve and its derivative by the fraction of the fibers' lengths.
struct MeanPoint {
  Vec3 position = Vec3::Zero(), derivative = Vec3::Zero();
};

MeanPoint mean_point(const FiberMesh& mesh, const Yarn& yarn, const std::vector<Vec3>& r, double fraction) {
  MeanPoint mean;
  for (Index f = yarn.first_fiber; f < yarn.first_fiber + yarn.n_fibers; ++f) {
    const double s = fraction * mesh.length(f);
    const ElementShape shape = element_shape(mesh, element_at(mesh, f, s), s);
    mean.position += shape.interpolate(r) / yarn.n_fibers;
    mean.derivative += mesh.length(f) * shape.derivative(r) / yarn.n_fibers;
  }
  return mean;
}

/// Arc length between nodes `n` and `n + 1` of a fiber where a plane passes between their signed distances.
double crossing(const FiberMesh& mesh, Index element, Index n, const std::vector<Vec3>& r, const Vec3& origin,
                const Vec3& normal) {
  double below = mesh.arc_length[n], above = mesh.arc_length[n + 1];
  const auto distance = [&](double s) { return normal.dot(element_shape(mesh, element, s).interpolate(r) - origin); };
  const bool rising = normal.dot(r[n + 1] - r[n]) > 0;
  for (int step = 0; step < 50; ++step) {
    const double middle = 0.5 * (below + above);
    ((distance(middle) < 0) == rising ? below : above) = middle;
  }
  return 0.5 * (below + above);
}

/// Where the fiber passes through the plane nearest to the section's origin. A distance within round-off of zero counts
/// as zero, so that a plane through the fiber's end does cut it.
std::optional<double> nearest_crossing(const FiberMesh& mesh, Index fiber, const std::vector<Vec3>& r,
                                       const Section& section) {
  const Vec3 normal = section.frame.row(0);
  std::optional<double> best;
  double smallest = std::numeric_limits<double>::infinity();
  const Index first = mesh.first_node[fiber];
  for (Index n = first; n + 1 < mesh.first_node[fiber + 1]; ++n) {
    const double round_off = 1e-9 * (r[n + 1] - r[n]).norm();
    double before = normal.dot(r[n] - section.origin), after = normal.dot(r[n + 1] - section.origin);
    if (std::abs(before) < round_off) before = 0;
    if (std::abs(after) < round_off) after = 0;
    if (before * after > 0 || before == after) continue;
    const Index element = n - (n - first) % 2;
    const double s = before == 0  ? mesh.arc_length[n]
                     : after == 0 ? mesh.arc_length[n + 1]
                                  : crossing(mesh, element, n, r, section.origin, normal);
    const double distance = (element_shape(mesh, element, s).interpolate(r) - section.origin).norm();
    if (distance < smallest) {
      smallest = distance;
      best = s;
    }
  }
  return best;
}

/// The fiber's section at s, moved into the plane along the fiber: an arm a becomes a − (a·n)/(τ·n) τ.
std::optional<FiberCut> cut_fiber(const FiberMesh& mesh, Index fiber, const FiberConfiguration& fibers,
                                  const Section& section) {
  const std::optional<double> s = nearest_crossing(mesh, fiber, fibers.r, section);
  if (!s) return std::nullopt;
  const ElementShape shape = element_shape(mesh, element_at(mesh, fiber, *s), *s);
  const Vec3 normal = section.frame.row(0), tangent = shape.derivative(fibers.r).normalized();
  if (!(std::abs(tangent.dot(normal)) > smallest_sine)) return std::nullopt;
  const auto in_plane = [&](const Vec3& v) -> Vec2 {
    return (section.frame * (v - v.dot(normal) / tangent.dot(normal) * tangent)).tail<2>();
  };
  FiberCut cut{.fiber = fiber, .s = *s, .centre = in_plane(shape.interpolate(fibers.r) - section.origin)};
  const double radius = std::isfinite(mesh.radius[fiber]) ? mesh.radius[fiber] : 0;
  cut.half_axes.col(0) = radius * in_plane(shape.interpolate(fibers.g1));
  cut.half_axes.col(1) = radius * in_plane(shape.interpolate(fibers.g2));
  return cut;
}

std::vector<Vec2> hull_of_fibers(const std::vector<FiberCut>& fibers) {
  std::vector<Vec2> points;
  for (const FiberCut& cut : fibers)
    for (int i = 0; i < n_outline_points; ++i) {
      const double t = 2 * std::numbers::pi * i / n_outline_points;
      points.emplace_back(cut.centre + cut.half_axes * Vec2(std::cos(t), std::sin(t)));
    }
  return convex_hull(points);
}

Section section_without_fibers(SectionStatus status, double fraction, double arc_length) {
  Section section;
  section.status = status;
  section.fraction = fraction;
  section.arc_length = arc_length;
  section.shape = outline_shape({});
  section.fill = nan;
  return section;
}

void measure(Section& section) {
  section.status = SectionStatus::ok;
  section.outline = hull_of_fibers(section.fibers);
  section.shape = outline_shape(section.outline);
  for (const FiberCut& cut : section.fibers) section.fiber_area += cut.area();
  section.fill = section.fiber_area > 0 ? section.fiber_area / section.shape.area : nan;
}

}  // namespace

std::string_view text(SectionStatus status) {
  switch (status) {
    case SectionStatus::ok: return "ok";
    case SectionStatus::beyond_end: return "beyond the ends of the yarn";
    case SectionStatus::no_fiber: return "no fiber passes through the plane";
  }
  return "";
}

double FiberCut::area() const { return std::numbers::pi * std::abs(half_axes.determinant()); }

YarnSections::YarnSections(const FiberMesh& mesh, const Yarn& yarn, const FiberConfiguration& fibers)
    : mesh_(mesh), yarn_(yarn), fibers_(fibers), arc_length_{0} {
  assert(yarn.n_fibers > 0);
  Index n_steps = 0;
  for (Index f = yarn.first_fiber; f < yarn.first_fiber + yarn.n_fibers; ++f)
    n_steps = std::max(n_steps, mesh.n_nodes(f) - 1);
  for (Index k = 0; k < n_steps; ++k) {
    double step = 0;
    for (const double offset : {-gauss_point, gauss_point})
      step += mean_point(mesh, yarn, fibers.r, (k + 0.5 + offset) / n_steps).derivative.norm() / (2 * n_steps);
    arc_length_.push_back(arc_length_.back() + step);
  }
}

Vec3 YarnSections::mean_position(double fraction) const {
  return mean_point(mesh_, yarn_, fibers_.r, fraction).position;
}

Section YarnSections::at(double arc_length) const {
  const double n_steps = static_cast<double>(arc_length_.size() - 1), round_off = 1e-12 * length();
  if (!(arc_length >= 0 && arc_length <= length() + round_off))
    return section_without_fibers(SectionStatus::beyond_end, nan, arc_length);
  const auto above = std::upper_bound(arc_length_.begin() + 1, arc_length_.end() - 1, arc_length);
  const double k = static_cast<double>(above - arc_length_.begin() - 1);
  return at_fraction(std::min((k + (arc_length - above[-1]) / (above[0] - above[-1])) / n_steps, 1.0));
}

Section YarnSections::at_fraction(double fraction) const {
  if (!(fraction >= 0 && fraction <= 1)) return section_without_fibers(SectionStatus::beyond_end, fraction, nan);
  const double step = fraction * static_cast<double>(arc_length_.size() - 1);
  const auto k = std::min(static_cast<std::size_t>(step), arc_length_.size() - 2);
  const double t = step - static_cast<double>(k);
  const MeanPoint mean = mean_point(mesh_, yarn_, fibers_.r, fraction);
  Section section =
      section_without_fibers(SectionStatus::no_fiber, fraction, (1 - t) * arc_length_[k] + t * arc_length_[k + 1]);
  section.origin = mean.position;
  if (!(mean.derivative.norm() > smallest_stretch * mesh_.length(yarn_.first_fiber))) return section;
  section.frame = yarn_frame(mean.derivative);
  for (Index f = yarn_.first_fiber; f < yarn_.first_fiber + yarn_.n_fibers; ++f)
    if (const auto cut = cut_fiber(mesh_, f, fibers_, section)) section.fibers.push_back(*cut);
  if (!section.fibers.empty()) measure(section);
  return section;
}

std::vector<Section> YarnSections::series(Index n) const {
  std::vector<Section> sections;
  for (Index k = 0; k < n; ++k) sections.push_back(at((k + 0.5) / n * length()));
  return sections;
}

std::vector<double> axial_strains(const FiberMesh& mesh, const Section& section, const std::vector<Vec3>& r_a,
                                  const std::vector<Vec3>& r_b) {
  std::vector<double> strains;
  for (const FiberCut& cut : section.fibers) {
    const Index first = element_at(mesh, cut.fiber, cut.s);
    const double start = mesh.arc_length[first], length = mesh.arc_length[first + 2] - start;
    double strain = 0;
    for (const double offset : {-gauss_point, gauss_point}) {
      const ElementShape shape = element_shape(mesh, first, start + (0.5 + offset) * length);
      strain += 0.25 * (shape.derivative(r_b).squaredNorm() / shape.derivative(r_a).squaredNorm() - 1);
    }
    strains.push_back(std::isfinite(strain) ? strain : nan);
  }
  return strains;
}

SideToCentre side_to_centre(const Section& section, const std::vector<double>& values) {
  assert(values.size() == section.fibers.size());
  SideToCentre result;
  double left = std::numeric_limits<double>::infinity(), right = -left, largest = 0;
  for (const Vec2& corner : section.outline) {
    left = std::min(left, corner.x());
    right = std::max(right, corner.x());
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    const bool at_side = std::abs(section.fibers[i].centre.x() - 0.5 * (left + right)) > 0.25 * (right - left);
    (at_side ? result.side : result.centre) += values[i];
    ++(at_side ? result.n_side : result.n_centre);
    largest = std::max(largest, std::abs(values[i]));
  }
  result.side /= result.n_side;  // 0 / 0 is NaN
  result.centre /= result.n_centre;
  const bool has_ratio = std::abs(result.centre) >= std::max(0.01 * largest, 1e-12);
  result.ratio = has_ratio ? result.side / result.centre : nan;
  return result;
}

}  // namespace trame::meso
