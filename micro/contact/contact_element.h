#pragma once
/// \file
/// The contact element: two particles, a frozen normal, a penalty force and a friction force. Pure functions of a gap
/// and a slip.

#include <algorithm>

#include "micro/fiber/fiber_field.h"

namespace trame::micro {

/// Force of the penalty at gap g (positive: apart): quadratic in the penetration p = −g up to p_reg, linear beyond,
///   f = 0 (g ≥ 0),  k p²/(2 p_reg) (p < p_reg),  k (p − p_reg/2) else.
[[nodiscard]] constexpr double penalty_force(double gap, double k, double p_reg) {
  const double p = -gap;
  return p <= 0 ? 0 : p < p_reg ? 0.5 * k * p * p / p_reg : k * (p - 0.5 * p_reg);
}
/// −df/dg ≥ 0.
[[nodiscard]] constexpr double penalty_stiffness(double gap, double k, double p_reg) {
  const double p = -gap;
  return p <= 0 ? 0 : p < p_reg ? k * p / p_reg : k;
}
/// Potential: f = −dψ/dg.
[[nodiscard]] constexpr double penalty_energy(double gap, double k, double p_reg) {
  const double p = -gap;
  return p <= 0 ? 0 : p < p_reg ? k * p * p * p / (6 * p_reg) : k * (0.5 * p * p - 0.5 * p * p_reg + p_reg * p_reg / 6);
}

/// Next factor of a penalty whose largest penetration was `ratio` times the target: it rises by ratio², since p² goes
/// with 1/k at a given force, and falls by up to 30 % where the penetration stays below a quarter of the target.
/// Continuous in ratio, also at first touch, so that round-off is not enlarged. Held between 0.1 and 10⁴, because what
/// is tied in penetration cannot part.
[[nodiscard]] constexpr double adapted_penalty_scale(double scale, double ratio) {
  constexpr double largest_rise = 4, largest_fall = 0.3, low = 0.25, touch = 0.005, smallest_scale = 0.1,
                   largest_scale = 1e4;
  double factor = 1;
  if (ratio > 1) factor = std::min(ratio * ratio, largest_rise);
  if (ratio > 0 && ratio < low) factor = 1 - largest_fall * std::min(ratio / touch, 1.0) * (1 - ratio / low);
  return std::clamp(scale * factor, smallest_scale, largest_scale);
}

/// What history keeps of a contact element between detections, increments and stages.
struct ContactHistory {
  Index fiber_a = 0, fiber_b = 0;  ///< a < b
  double s_a = 0, s_b = 0;
  Vec3 normal = Vec3::UnitZ();
  Index traction = -1;  ///< which of the remembered tractions; negative without friction
  double penalty_scale = 1;
  bool touches = false;
  double allowance = 0;  ///< penetration that is forgiven at the stage's start, length; see Contact::forgive
};

/// A pair of particles that may touch. While n and the arc lengths are frozen, the gap is
///   g = n·(r_b − r_a) − R_a |w_a| − R_b |w_b| − offset,   w = (n·g₁, n·g₂),
/// R |w| being the support function of a section in direction n: its outline may turn without changing the gap. (With
/// particles fixed on the outline instead, a squeezed fiber gains energy by spinning out of the way, which only torsion
/// resists.) Slip is that of the frozen particles a and b.
struct ContactElement {
  Index fiber_a = 0, fiber_b = 0;
  double s_a = 0, s_b = 0;  ///< arc lengths of the particles
  FiberPoint a, b;
  double radius_a = 0, radius_b = 0;
  Vec3 normal = Vec3::UnitZ();  ///< from a to b
  bool crossing = false;        ///< closest approach of fibers that cross, not a sample along them
  double offset = 0;            ///< distance along n at zero gap beyond what the sections account for (radii of rods)
  double length = 0;            ///< length of fiber that the element stands for
  double penalty = 0;           ///< k, force over length
  double penalty_scale = 1;     ///< adapted factor that `penalty` includes
  double allowance = 0;         ///< see ContactHistory; `offset` includes what is still granted of it

  /// x_b − x_a of the frozen particles.
  [[nodiscard]] Vec3 relative_position(const Layout& layout, const State& state) const {
    return b.evaluate(layout, state) - a.evaluate(layout, state);
  }
  [[nodiscard]] double gap(const Layout& layout, const State& state) const;
  [[nodiscard]] Vec3 tangential(const Vec3& v) const { return v - normal * normal.dot(v); }
};

/// What friction adds to a contact element. Apart from it, so that contact without friction carries none of this.
struct StickSlip {
  Vec3 x_start = Vec3::Zero();  ///< x_b − x_a of the particles at the start of the step
  Vec3 traction_start =
      Vec3::Zero();  ///< Friction::force at the start of the step, tangential; −traction_start acts on b
  double tangential_stiffness = 0;  ///< µ N / u_rev with the normal force N at the last detection
  double slip_limit = 0;            ///< µ N, likewise
};

/// The outermost particle of a section in a direction, at the current state.
struct Touch {
  FiberPoint point;      ///< (s, ξ) with ξ = R w/|w|; for rods the point of the centre line
  FiberPoint turn;       ///< its derivative by the angle on the outline
  double curvature = 0;  ///< 1/(R |w|): weight of turn turnᵀ in the Hessian of the support function; 0 for rods
};
[[nodiscard]] Touch touch(const FiberPoint& particle, double radius, const Vec3& outward, const Layout& layout,
                          const State& state);

/// Friction at a relative position: return mapping of the trial traction onto the disc of radius µN.
struct Friction {
  Vec3 force = Vec3::Zero();  ///< gradient by x_b − x_a of the friction potential (the force on b is −force)
  Vec3 direction = Vec3::Zero();
  double stiffness_along = 0, stiffness_across = 0;  ///< along the trial force, and across it in the tangent plane
  double energy = 0;      ///< incremental potential: ½|t|²/k and, where it slides, the slip work of the step
  double dissipated = 0;  ///< limit · irreversible slip of the step
  bool slides = false;
};
[[nodiscard]] Friction friction(const ContactElement& element, const StickSlip& stick_slip,
                                const Vec3& relative_position);

/// Adds force and tangent of a contact element: those of the penalty.
void add_contact_element(const ContactElement& element, const Layout& layout, const State& state, double p_reg,
                         Assembler& assembler);
/// Adds force and tangent of its friction, which couple the same nodes.
void add_friction(const ContactElement& element, const StickSlip& stick_slip, const Layout& layout, const State& state,
                  Assembler& assembler);
/// Announces the couplings of a contact element.
void announce_contact_element(const ContactElement& element, Pattern::Builder& builder);

}  // namespace trame::micro
