#pragma once
/// \file
/// Chords between two centre lines: the shortest one nearby, and the shortest one at a given mean arc length.
///
/// With c = r_b(s_b) − r_a(s_a), both are minima of ½|c|² over the arc lengths of the feet, found by Newton's method
/// with the second derivatives r'', safeguarded: brackets along a line, projected steps in a box.

#include <array>
#include <cmath>
#include <optional>

#include "micro/fiber/fiber_field.h"

namespace trame::micro {

/// A chord and how its feet are free to slide along their fibers when the fibers move: directions (δs_a, δs_b) along
/// which |c| is stationary.
struct Chord {
  Foot a, b;
  CurveJet at_a, at_b;
  Vec3 c = Vec3::Zero();  ///< r_b − r_a
  int n_free = 0;
  std::array<Vec2, 2> free{};

  /// Derivatives by (s_a, s_b) of ½|c|²: gradient and Hessian.
  [[nodiscard]] Vec2 slope() const { return {-c.dot(at_a.tangent), c.dot(at_b.tangent)}; }
  [[nodiscard]] Eigen::Matrix2d hessian() const {
    Eigen::Matrix2d h;
    h(0, 0) = at_a.tangent.squaredNorm() - c.dot(at_a.curvature);
    h(1, 1) = at_b.tangent.squaredNorm() + c.dot(at_b.curvature);
    h(0, 1) = h(1, 0) = -at_a.tangent.dot(at_b.tangent);
    return h;
  }
  /// Of the angle at which the fibers cross.
  [[nodiscard]] double cosine() const {
    return at_a.tangent.dot(at_b.tangent) / (at_a.tangent.norm() * at_b.tangent.norm());
  }
};

/// Second derivative by the mean arc length τ, u following, of what has the Hessian h by (s_a, s_b).
[[nodiscard]] inline double along_valley(const Eigen::Matrix2d& h, double sense) {
  const Vec2 along(1, sense), across(1, -sense);
  const double aa = along.dot(h * along), ac = along.dot(h * across), cc = across.dot(h * across);
  return cc > 0 ? aa - ac * ac / cc : aa;
}

/// The chord between given feet.
[[nodiscard]] Chord chord_between(const FiberField& field, const State& state, Foot a, Foot b);

/// The intermediate geometry of two stretches that run in the same sense σ = ±1 (fiber b is taken backwards for −1): at
/// mean arc length τ = ½(s_a + σ s_b) the shortest chord over u = ½(s_a − σ s_b), which is normal to the mean tangent
/// r_a' + σ r_b'. Feet may lie beyond the ends of their fibers. Nothing where there is none within `reach` of u. Of `a`
/// and `b` fibers and images count. `lean` is the slope by (s_a, s_b) of what is added to ½|c|².
[[nodiscard]] std::optional<Chord> chord_at_mean_arc_length(const FiberField& field, const State& state, Foot a, Foot b,
                                                            double sense, double tau, double u, double reach,
                                                            const Vec2& lean = Vec2::Zero());

/// Holds a chord near a mean arc length τ₀: minimised is ½|c|² + ½ η (τ − τ₀)², τ = ½(s_a + σ s_b). Where two fibers
/// stay at one distance over a length, their lowest point would otherwise be anywhere along it.
struct Hold {
  /// What a valley has at least where sections may incline, over R_a + R_b: second derivative of the gap by τ.
  static constexpr double least_valley = 0.25;
  double stiffness = 0;  ///< η
  double sense = 1, mean_arc_length = 0;

  [[nodiscard]] Vec2 along() const { return {0.5, 0.5 * sense}; }  ///< ∂τ/∂(s_a, s_b)
  [[nodiscard]] double distance(const Chord& chord) const {
    return 0.5 * (chord.a.s + sense * chord.b.s) - mean_arc_length;
  }
  [[nodiscard]] double energy(const Chord& chord) const {
    return 0.5 * chord.c.squaredNorm() + 0.5 * stiffness * distance(chord) * distance(chord);
  }
};

/// The shortest chord nearby, or one held: a local minimum over both feet, which may rest at ends of the fibers.
/// Nothing where the feet would go farther than `reach`. `lean` as above.
[[nodiscard]] std::optional<Chord> shortest_chord(const FiberField& field, const State& state, Foot a, Foot b,
                                                  double reach, const Hold& hold = {}, const Vec2& lean = Vec2::Zero());

}  // namespace trame::micro
