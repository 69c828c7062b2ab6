#include "micro/contact/closest_points.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace trame::micro {

namespace {

constexpr int max_iterations = 100;
// Steps below this part of an element's length end an iteration: the distance goes with their square.
constexpr double settled = 1e-10;

double joint(const FiberField& field, Index fiber, Index element) { return field.element_length(fiber) * element; }

}  // namespace

Chord chord_between(const FiberField& field, const State& state, Foot a, Foot b) {
  Chord chord{a, b, field.jet(state, a.fiber, a.element, a.s), field.jet(state, b.fiber, b.element, b.s)};
  chord.c = chord.at_b.r - chord.at_a.r;
  return chord;
}

std::optional<Chord> chord_at_mean_arc_length(const FiberField& field, const State& state, Index fiber_a, Index fiber_b,
                                              double sense, double tau, double u, double reach) {
  const double h = std::min(field.element_length(fiber_a), field.element_length(fiber_b));
  const double start = u, longest_step = 0.5 * h;
  constexpr double infinite = std::numeric_limits<double>::infinity();
  double low = -infinite, high = infinite;  // the minimum lies between
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    const double s_a = tau + u, s_b = sense * (tau - u);
    Chord chord = chord_between(field, state, {fiber_a, s_a, field.element_at(fiber_a, s_a)},
                                {fiber_b, s_b, field.element_at(fiber_b, s_b)});
    const Vec2 direction(1, -sense);
    const double slope = chord.slope().dot(direction), curvature = direction.dot(chord.hessian() * direction);
    (slope > 0 ? high : low) = u;
    const double step =
        curvature > 0 ? std::clamp(-slope / curvature, -longest_step, longest_step) : std::copysign(longest_step, -slope);
    if (std::abs(step) < settled * h) {
      chord.n_free = 1;
      chord.free[0] = direction;
      return chord;
    }
    // A foot rests where the tangent jumps; Newton's steps would go to and fro.
    if (high - low < settled * h) return chord;
    double next = u + step;
    if (next <= low || next >= high) next = 0.5 * (low + high);
    if (std::abs(next - start) > reach) return std::nullopt;
    u = next;
  }
  return std::nullopt;
}

namespace {

/// One coordinate of a search for the shortest chord: a foot, and the stretch of its element that it may move in.
struct Coordinate {
  Foot* foot;
  double low, high;
  bool held;  // at an end or a joint from which it gets longer both ways
};

/// Chooses the element of a foot at a joint, and holds it where it rests. `slope_in(element)`: derivative by its arc
/// length of what is minimised.
template <typename Slope>
Coordinate settle(const FiberField& field, Foot& foot, double epsilon, Slope&& slope_in) {
  const Index last = field.mesh().n_elements(foot.fiber) - 1;
  const double length = field.mesh().length(foot.fiber);
  foot.element = std::clamp(foot.element, Index{0}, last);
  const auto range = [&](bool held) {
    return Coordinate{&foot, joint(field, foot.fiber, foot.element),
                      foot.element == last ? length : joint(field, foot.fiber, foot.element + 1), held};
  };
  const bool at_low = foot.s <= joint(field, foot.fiber, foot.element) + epsilon;
  const bool at_high = foot.s >= range(false).high - epsilon;
  if (!at_low && !at_high) return range(false);
  // The joint lies between elements `before` and `before` + 1; at an end of the fiber one of them is missing.
  const Index before = at_low ? foot.element - 1 : foot.element;
  const bool can_fall = before >= 0, can_rise = before < last;
  foot.s = before < 0 ? 0 : before == last ? length : joint(field, foot.fiber, before + 1);
  // Descents into the two elements. At a fiber's end there is one, and nowhere else to go.
  const double flat = 1e-9 * field.element_length(foot.fiber);
  const double falling = can_fall ? slope_in(before) : -std::numeric_limits<double>::infinity();
  const double rising = can_rise ? -slope_in(before + 1) : -std::numeric_limits<double>::infinity();
  foot.element = falling >= rising ? before : before + 1;
  return range(falling < -flat && rising < -flat);
}

}  // namespace

std::optional<Chord> shortest_chord(const FiberField& field, const State& state, Foot a, Foot b, double reach) {
  const double h_a = field.element_length(a.fiber), h_b = field.element_length(b.fiber);
  const Foot start_a = a, start_b = b;
  constexpr double longest = 0.25;
  double radius = longest;  // of the box in which the Hessian is trusted, in elements
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    const Coordinate x = settle(field, a, 1e-12 * h_a, [&](Index e) {
      return chord_between(field, state, {a.fiber, a.s, e}, b).slope()[0];
    });
    const Coordinate y = settle(field, b, 1e-12 * h_b, [&](Index e) {
      return chord_between(field, state, a, {b.fiber, b.s, e}).slope()[1];
    });
    Chord chord = chord_between(field, state, a, b);
    if (!x.held) chord.free[chord.n_free++] = Vec2(1, 0);
    if (!y.held) chord.free[chord.n_free++] = Vec2(0, 1);
    if (chord.n_free == 0) return chord;
    const Vec2 slope = chord.slope();
    Eigen::Matrix2d hessian = chord.hessian();
    const bool convex = hessian.determinant() > 0 && hessian(0, 0) > 0;
    if (!convex) {
      // Beyond an inflection: downhill by the size of each curvature, whatever its sign.
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> modes(hessian);
      const Vec2 size = modes.eigenvalues().cwiseAbs().cwiseMax(1e-6);
      hessian = modes.eigenvectors() * size.asDiagonal() * modes.eigenvectors().transpose();
    }
    Vec2 step = Vec2::Zero();
    if (chord.n_free == 2)
      step = -hessian.inverse() * slope;
    else
      step[x.held ? 1 : 0] = -slope[x.held ? 1 : 0] / hessian(x.held ? 1 : 0, x.held ? 1 : 0);
    const double size = std::max(std::abs(step[0]) / h_a, std::abs(step[1]) / h_b);
    if (size > radius) step *= radius / size;
    step[0] = std::clamp(a.s + step[0], x.low, x.high) - a.s;
    step[1] = std::clamp(b.s + step[1], y.low, y.high) - b.s;
    if (std::abs(step[0]) < settled * h_a && std::abs(step[1]) < settled * h_b) return chord;
    // Round-off of a length decides long before its derivatives do.
    constexpr double small = 1e-3;
    const bool trusted = convex && std::abs(step[0]) < small * h_a && std::abs(step[1]) < small * h_b;
    const Chord trial = chord_between(field, state, {a.fiber, a.s + step[0], a.element}, {b.fiber, b.s + step[1], b.element});
    if (!trusted && trial.c.squaredNorm() > chord.c.squaredNorm()) {
      radius = 0.25 * std::min(size, radius);
      if (radius < settled) return chord;  // round-off decides
      continue;
    }
    radius = std::min(2 * radius, longest);
    a.s += step[0];
    b.s += step[1];
    if (std::abs(a.s - start_a.s) > reach || std::abs(b.s - start_b.s) > reach) return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace trame::micro
