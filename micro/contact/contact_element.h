#pragma once
/// \file
/// The contact element: a pair of points that face each other, a gap, a penalty force and a friction force. Pure
/// functions of a gap and a slip.

#include <algorithm>
#include <cmath>

#include "micro/contact/augmented_penalty.h"
#include "micro/contact/local_forms.h"
#include "micro/contact/proximity.h"
#include "micro/solve/unsymmetric_terms.h"

namespace trame::micro {

/// What history keeps of a contact element between detections, increments and stages.
struct ContactHistory {
  Index fiber_a = 0, fiber_b = 0;  ///< a < b
  Image image{};                   ///< of b, see Proximity
  double s_a = 0, s_b = 0;
  Vec3 normal = Vec3::UnitZ();
  Index traction = -1;  ///< which of the remembered tractions; negative without friction
  double penalty_scale = 1;
  bool touches = false;
  double gap_offset = 0;  ///< penetration from which the gap is counted, length; see Contact::offset_gaps
  double length = 0;      ///< of the element; 0: unknown
  bool point = false;
  double preload = 0, raised_at = 0;  ///< see ContactElement
  bool stuck = false;                 ///< see ContactElement

  /// By which histories are in order.
  [[nodiscard]] std::tuple<Index, Index, Image, double> place() const { return {fiber_a, fiber_b, image, s_a}; }
  void keep(Archive& archive) {
    archive(fiber_a, fiber_b, image[0], image[1], s_a, s_b, normal, traction, penalty_scale, touches, gap_offset,
            length, point, preload, raised_at, stuck);
  }
};

/// The gap of a pair at one state, and what its derivatives need:
///   g = ±D − R_a |w_a| − R_b |w_b| − offset,   c = r_b − r_a,  n = ±c/|c|,  w = (n·g₁, n·g₂),
/// D = |c|, for feet that are held (Hold) √(|c|² + η (τ − τ₀)²).
/// R |w| is the support function of a section in direction n: its outline may turn without changing the gap. (With
/// particles fixed on the outline instead, a squeezed fiber gains energy by spinning out of the way, which only torsion
/// resists.) The feet are where g is stationary: they slide along with the fibers, and δg is as if they did not, so
/// that forces know neither of the curvatures of the fibers, which jump at their nodes, nor of where fibers end.
struct Gap {
  /// Of one side; all zero for rods, whose radius is in the offset.
  struct Section {
    Vec2 w = Vec2::Zero();          ///< w/|w|
    double curvature = 0;           ///< R/|w|
    Vec3 outermost = Vec3::Zero();  ///< R (w₁ g₁ + w₂ g₂)/|w|: from the centre to the particle farthest along ±n
    Vec3 beside = Vec3::Zero();     ///< (−w₂ g₁ + w₁ g₂)/|w|
    /// Of these particles, by arc length.
    Vec3 outermost_slope = Vec3::Zero(), outermost_curvature = Vec3::Zero(), beside_slope = Vec3::Zero();
  };
  /// How the feet slide along their free directions e: by δs = −A⁻¹ B with A = ∂²g/∂e∂e' and the forms B_e = δ(∂g/∂e).
  struct Sliding {
    int n = 0;
    std::array<Vec3, 2> of_chord;                       ///< the part of B_e that goes with δc
    std::array<Vec3, 2> normal;                         ///< ∂n/∂e
    std::array<Vec2, 2> spin;                           ///< by which the sections of a and b turn about their centres
    Eigen::Matrix2d inverse = Eigen::Matrix2d::Zero();  ///< A⁻¹
  };
  double value = 0;
  Vec3 normal = Vec3::UnitZ();  ///< n, from a to b
  double inverse_distance = 0;  ///< 1/(n·c); 0 where axes are so close that the normal is held
  double inverse_length = 0;    ///< 1/(±D), likewise
  double share = 1;             ///< |c|/D
  Vec2 lean = Vec2::Zero();     ///< ±D ∂(g ∓ D)/∂(s_a, s_b): by this feet lean away from where D is stationary
  Section a, b;
  Sliding sliding;
  /// m of the force f m on b: δg = m·δc where sections move with their centres. Normal to the outlines; it differs from
  /// n where sections stand inclined to the chord.
  Vec3 force_direction = Vec3::UnitZ();

  [[nodiscard]] Vec3 across(const Vec3& v) const { return v - normal * normal.dot(v); }
};

/// A pair of points that may touch.
struct ContactElement : AugmentedPenalty {
  Proximity pair;                         ///< feet and chord at the state last followed
  std::array<Foot, 2> feet_at_iteration;  ///< where they are followed from, with what leans on them
  Vec2 lean_at_iteration = Vec2::Zero();
  Index fiber_a = 0, fiber_b = 0;
  double s_a = 0, s_b = 0;  ///< arc lengths of the feet
  CoveredNodes covered;     ///< of the pattern
  FiberPoint a, b;          ///< particles on the outlines (for rods on the centre lines), which friction follows
  double radius_a = 0, radius_b = 0;
  Vec3 normal = Vec3::UnitZ();  ///< from a to b
  bool crossing = false;        ///< a point, not a sample along a line
  bool has_side = false;        ///< the side of a on which b lies is known: `side`
  Vec3 side = Vec3::UnitZ();    ///< normal of the last accepted increment, or from before it pressed in this one
  double offset = 0;            ///< distance along n at zero gap beyond what the sections account for (radii of rods)
  double length = 0;            ///< length of fiber that the element stands for
  double gap_offset = 0;        ///< see ContactHistory; `offset` includes what is still granted of it
  bool has_pressed = false;     ///< in the increment, since it was last looked for without `keep`
  Gap measured;                 ///< at the state last followed

  /// What tells how it goes on from the gap that it has.
  void keep(Archive& archive) {
    archive(pair, s_a, s_b, radius_a, radius_b, crossing, has_side, side, offset, length, penalty, penalty_scale,
            preload, measured.value);
    fiber_a = pair.fiber_a();
    fiber_b = pair.fiber_b();
  }

  /// The side goes with the normal, from iteration to iteration, as long as axes are far enough from passing through
  /// each other: fibers that roll around each other turn it over.
  void turn_side() {
    constexpr double far = 0.5;  // of the sum of the radii
    if (measured.inverse_distance != 0 && pair.chord.c.norm() > far * (radius_a + radius_b) && normal.dot(side) > 0)
      side = normal;
  }

  /// Gap at the state last followed.
  [[nodiscard]] double gap() const { return measured.value; }
  /// x_b − x_a of the particles.
  [[nodiscard]] Vec3 relative_position(const Layout& layout, const State& state) const {
    return b.evaluate(layout, state) - a.evaluate(layout, state);
  }

  /// Of the gap: what the energy falls by as it opens.
  [[nodiscard]] double force(double p_reg) const { return law(p_reg).force(gap()); }
  /// Of the fibers on each other: N = f |m|, which Coulomb's law is about.
  [[nodiscard]] double normal_force(double p_reg) const { return force(p_reg) * measured.force_direction.norm(); }
  [[nodiscard]] double stiffness(double p_reg) const { return penalty_stiffness(gap() - preload, penalty, p_reg); }
  /// Energy stored by the gap, none at zero: ψ(p + preload) − ψ(preload).
  [[nodiscard]] double energy(double p_reg) const { return law(p_reg).energy(gap()); }
};

/// Holds a point to its place where inclined sections make the valley of the gap too shallow (Hold), which that of the
/// distance is not. Needs the gap measured, and measures it anew.
void hold_in_valley(const FiberField& field, const State& state, ContactElement& element);
/// Measures the gap of the element's chord.
void measure(const FiberField& field, const State& state, ContactElement& element);
/// Slides the feet to where they face each other at `state`, and measures the gap.
void follow(const FiberField& field, const State& state, ContactElement& element);
/// Lays the particles that friction follows to where the feet are.
void place_particles(const FiberField& field, ContactElement& element);

/// What friction adds to a contact element. Apart from it, so that contact without friction carries none of this.
struct StickSlip {
  Vec3 normal = Vec3::UnitZ();  ///< to the outlines, at the last iteration: the direction of the normal force
  Vec3 x_start = Vec3::Zero();  ///< x_b − x_a of the particles at the start of the step
  Vec3 traction_start =
      Vec3::Zero();  ///< Friction::force at the start of the step, tangential; −traction_start acts on b
  double tangential_stiffness = 0;  ///< µ N / u_rev with the normal force N at the last iteration
  double slip_limit = 0;            ///< µ N, likewise

  /// Takes up a tangential traction from before. What the limit no longer bears is gone without a slip.
  void begin_with(const Vec3& traction) {
    traction_start = traction;
    if (const double size = traction_start.norm(); size > slip_limit) traction_start *= slip_limit / size;
  }

  [[nodiscard]] Vec3 tangential(const Vec3& v) const { return v - normal * normal.dot(v); }
};

/// Energy of the reversible slips with which a step begins, Σ ½|t|²/k.
[[nodiscard]] double slip_energy_at_start(const std::vector<StickSlip>& stick_slip);

/// Friction at a relative position: return mapping of the trial traction onto the disc of radius µN.
struct Friction {
  Vec3 force = Vec3::Zero();  ///< gradient by x_b − x_a of the friction potential (the force on b is −force)
  Vec3 direction = Vec3::Zero();
  double stiffness_along = 0, stiffness_across = 0;  ///< along the trial force, and across it in the tangent plane
  double energy = 0;      ///< incremental potential: ½|t|²/k and, where it slides, the slip work of the step
  double dissipated = 0;  ///< limit · irreversible slip of the step
  bool slides = false;
};
[[nodiscard]] Friction friction(const StickSlip& stick_slip, const Vec3& relative_position);
/// The derivative of its force by the slip limit µN, with which goes k = µN/u_rev: where it sticks, that of the trial
/// force t*, where it slides, d + µN/|t*| (I − d dᵀ) ∂t*/∂(µN) with the direction d = t*/|t*|.
[[nodiscard]] Vec3 friction_by_limit(const StickSlip& stick_slip, const Vec3& relative_position);

/// Adds force and tangent of the penalty, at the state last followed.
void add_contact_element(const FiberField& field, const ContactElement& element, double p_reg, Assembler& assembler);
/// Adds how its friction goes with the normal force, δt = ∂t/∂(µN) µ δN.
void add_friction_by_limit(const FiberField& field, const ContactElement& element, const StickSlip& stick_slip,
                           double friction_coefficient, double p_reg, const State& state, UnsymmetricTerms& terms);
/// Adds force and tangent of its friction, which couple the same nodes.
void add_friction(const ContactElement& element, const StickSlip& stick_slip, const Layout& layout, const State& state,
                  Assembler& assembler);

}  // namespace trame::micro
