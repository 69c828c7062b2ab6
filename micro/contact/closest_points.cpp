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

}  // namespace

Chord chord_between(const FiberField& field, const State& state, Foot a, Foot b) {
  Chord chord{a, b, field.curve(state, a), field.curve(state, b)};
  chord.c = chord.at_b.r - chord.at_a.r;
  return chord;
}

std::optional<Chord> chord_at_mean_arc_length(const FiberField& field, const State& state, Foot a, Foot b, double sense,
                                              double tau, double u, double reach, const Vec2& lean) {
  const double h = std::min(field.element_length(a.fiber), field.element_length(b.fiber));
  const double start = u, longest_step = 0.5 * h;
  constexpr double infinite = std::numeric_limits<double>::infinity();
  double low = -infinite, high = infinite;  // the minimum lies between
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    a.s = tau + u;
    b.s = sense * (tau - u);
    Chord chord = chord_between(field, state, a, b);
    const Vec2 direction(1, -sense);
    const double slope = (chord.slope() + lean).dot(direction), curvature = direction.dot(chord.hessian() * direction);
    (slope > 0 ? high : low) = u;
    const double step = curvature > 0 ? std::clamp(-slope / curvature, -longest_step, longest_step)
                                      : std::copysign(longest_step, -slope);
    if (std::min(std::abs(step), high - low) < settled * h) {
      chord.n_free = 1;
      chord.free[0] = direction;
      return chord;
    }
    double next = u + step;
    if (next <= low || next >= high) next = 0.5 * (low + high);
    if (std::abs(next - start) > reach) return std::nullopt;
    u = next;
  }
  return std::nullopt;
}

namespace {

/// Whether a foot rests at an end of its fiber: the chord gets longer from there on.
bool is_held(double s, const FiberField::Ends& ends, double slope) {
  return (s <= ends.start && slope >= 0) || (s >= ends.end && slope <= 0);
}

}  // namespace

std::optional<Chord> shortest_chord(const FiberField& field, const State& state, Foot a, Foot b, double reach,
                                    const Hold& hold, const Vec2& lean) {
  const FiberField::Ends ends_a = field.ends(a.fiber), ends_b = field.ends(b.fiber);
  a.s = std::clamp(a.s, ends_a.start, ends_a.end);
  b.s = std::clamp(b.s, ends_b.start, ends_b.end);
  const double h_a = field.element_length(a.fiber), h_b = field.element_length(b.fiber);
  const Foot start_a = a, start_b = b;
  const auto energy = [&](const Chord& chord) {
    return hold.energy(chord) + lean.dot(Vec2(chord.a.s - start_a.s, chord.b.s - start_b.s));
  };
  constexpr double longest = 0.25;
  double radius = longest;  // of the box in which the Hessian is trusted, in elements
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    Chord chord = chord_between(field, state, a, b);
    const Vec2 slope = chord.slope() + lean + hold.stiffness * hold.distance(chord) * hold.along();
    const bool held_a = is_held(a.s, ends_a, slope[0]), held_b = is_held(b.s, ends_b, slope[1]);
    if (!held_a) chord.free[chord.n_free++] = Vec2(1, 0);
    if (!held_b) chord.free[chord.n_free++] = Vec2(0, 1);
    if (chord.n_free == 0) return chord;
    Eigen::Matrix2d hessian = chord.hessian() + hold.stiffness * hold.along() * hold.along().transpose();
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
      step[held_a ? 1 : 0] = -slope[held_a ? 1 : 0] / hessian(held_a ? 1 : 0, held_a ? 1 : 0);
    const double size = std::max(std::abs(step[0]) / h_a, std::abs(step[1]) / h_b);
    if (size > radius) step *= radius / size;
    step[0] = std::clamp(a.s + step[0], ends_a.start, ends_a.end) - a.s;
    step[1] = std::clamp(b.s + step[1], ends_b.start, ends_b.end) - b.s;
    if (std::abs(step[0]) < settled * h_a && std::abs(step[1]) < settled * h_b) return chord;
    // Round-off of a length decides long before its derivatives do.
    constexpr double small = 1e-3;
    const bool trusted = convex && std::abs(step[0]) < small * h_a && std::abs(step[1]) < small * h_b;
    const Chord trial =
        chord_between(field, state, {a.fiber, a.s + step[0], a.image}, {b.fiber, b.s + step[1], b.image});
    if (!trusted && energy(trial) > energy(chord)) {
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
