#include "micro/contact/fiber_ends.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

namespace trame::micro {

namespace {

constexpr int samples_per_element = 4;

Index n_samples(const FiberField& field, Index fiber) {
  return samples_per_element * field.mesh().n_elements(fiber) + 1;
}

double sample_spacing(const FiberField& field, Index fiber) {
  return field.element_length(fiber) / samples_per_element;
}

/// A box around all of a fiber: that of its samples, wider by what may lie between them.
Eigen::AlignedBox3d box_of(const FiberField& field, const State& state, Index fiber) {
  const double spacing = sample_spacing(field, fiber);
  Eigen::AlignedBox3d box;
  for (Index i = 0; i < n_samples(field, fiber); ++i)
    box.extend(field.curve(state, fiber, std::min(i * spacing, field.mesh().length(fiber))).r);
  const Vec3 margin = Vec3::Constant(field.mesh().radius[fiber] + spacing);
  return {box.min() - margin, box.max() + margin};
}

/// Arc length of the point of a fiber that is nearest to x: of its samples, then by Newton's method for a straight line
/// between the samples beside it.
double nearest_arc_length(const FiberField& field, const State& state, Index fiber, const Vec3& x) {
  const double spacing = sample_spacing(field, fiber), length = field.mesh().length(fiber);
  double s = 0, least = std::numeric_limits<double>::infinity();
  for (Index i = 0; i < n_samples(field, fiber); ++i) {
    const double si = std::min(i * spacing, length), distance = (field.curve(state, fiber, si).r - x).norm();
    if (distance < least) {
      least = distance;
      s = si;
    }
  }
  const double low = std::max(0.0, s - spacing), high = std::min(length, s + spacing);
  for (int iteration = 0; iteration < 20; ++iteration) {
    const CurveJet at = field.curve(state, fiber, s);
    s = std::clamp(s + (x - at.r).dot(at.tangent) / at.tangent.squaredNorm(), low, high);
  }
  return s;
}

/// Beside which arc length x lies in the cylinder of a fiber; nothing where it is outside, or beyond an end face.
std::optional<double> inside(const FiberField& field, const State& state, Index fiber, const Vec3& x) {
  const double length = field.mesh().length(fiber), face = 1e-6 * length;
  const double s = nearest_arc_length(field, state, fiber, x);
  if (s < face || s > length - face) return std::nullopt;
  // An end that presses on a flank squeezes it a little.
  constexpr double deep = 0.95;
  if ((field.curve(state, fiber, s).r - x).norm() >= deep * field.mesh().radius[fiber]) return std::nullopt;
  return s;
}

}  // namespace

std::vector<BuriedEnd> find_buried_ends(const FiberField& field, const State& state,
                                        const std::function<bool(Index, FiberEnd, Index)>& together) {
  const FiberMesh& mesh = field.mesh();
  std::vector<Eigen::AlignedBox3d> boxes;
  for (Index f = 0; f < mesh.n_fibers(); ++f) boxes.push_back(box_of(field, state, f));
  std::vector<BuriedEnd> found;
  for (Index f = 0; f < mesh.n_fibers(); ++f) {
    if (mesh.period(f) >= 0) continue;
    for (const FiberEnd end : {FiberEnd::start, FiberEnd::end}) {
      const Vec3 x = field.curve(state, f, end == FiberEnd::start ? 0 : mesh.length(f)).r;
      for (Index other = 0; other < mesh.n_fibers(); ++other) {
        if (other == f || !boxes[other].contains(x) || together(f, end, other)) continue;
        if (const std::optional<double> s = inside(field, state, other, x)) {
          found.push_back({f, end, other, *s});
          break;
        }
      }
    }
  }
  return found;
}

}  // namespace trame::micro
