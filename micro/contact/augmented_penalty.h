#pragma once
/// \file
/// How a contact presses: a penalty with a preload, which rises until next to no penetration remains (augmented
/// Lagrangian). Pure functions of a gap.

#include <algorithm>
#include <cmath>
#include <vector>

#include "micro/core/archive.h"

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
/// The penetration at which the penalty gives a force: the inverse of `penalty_force`.
[[nodiscard]] inline double penetration_of_force(double force, double k, double p_reg) {
  if (force <= 0) return 0;
  return force < 0.5 * k * p_reg ? std::sqrt(2 * p_reg * force / k) : force / k + 0.5 * p_reg;
}

/// A penalty with a preload.
struct PenaltyLaw {
  double penalty = 0, preload = 0, p_reg = 0;
  [[nodiscard]] double force(double gap) const { return penalty_force(gap - preload, penalty, p_reg); }
  /// Energy stored by the gap, none at zero: ψ(p + preload) − ψ(preload).
  [[nodiscard]] double energy(double gap) const {
    return penalty_energy(gap - preload, penalty, p_reg) - penalty_energy(-preload, penalty, p_reg);
  }
};

/// Work that must come in for the law of a contact to become another along a step, from `start_gap` to `gap`, as far as
/// it pressed: what is stored more at the end, and what the force by which they differ there has done on the rest,
/// coming up evenly on the way.
[[nodiscard]] inline double work_of_new_law(double start_gap, double gap, const PenaltyLaw& from,
                                            const PenaltyLaw& to) {
  const double before = from.force(start_gap) > 0 ? start_gap : std::min(start_gap, 0.0),
               after = to.force(gap) > 0 ? gap : std::min(gap, 0.0);
  return to.energy(gap) - from.energy(gap) + 0.5 * (to.force(gap) - from.force(gap)) * (after - before);
}

/// Force and energy of a contact at one end of a step.
struct ContactAt {
  double force = 0, energy = 0;
};
/// Energy that a contact brings with it which only one end of a step knows: that at the end at which it presses less.
/// It has come before it pressed, or gone when it no longer did; contacts that take the place of each other are counted
/// at the same end.
[[nodiscard]] constexpr double energy_brought(const ContactAt& start, const ContactAt& end) {
  return start.force < end.force ? start.energy : end.energy;
}

/// Penetration that is deeper than it may be, over the target, which most contacts stay below.
constexpr double deepest_over_target = 3;

/// Next factor of a penalty whose largest penetration was `ratio` times the target: it rises by ratio², since p² goes
/// with 1/k at a given force, at most fourfold, and never falls. Held below `largest_penalty_scale`.
constexpr double largest_penalty_scale = 400;
[[nodiscard]] constexpr double adapted_penalty_scale(double scale, double ratio) {
  constexpr double largest_rise = 4;
  return std::min(scale * std::clamp(ratio * ratio, 1.0, largest_rise), largest_penalty_scale);
}

/// The penalty and the preload of one contact, through an increment and on to the next one.
struct AugmentedPenalty {
  double unit_penalty = 0;   ///< k at a scale of 1
  double penalty = 0;        ///< k, force over length
  double penalty_scale = 1;  ///< adapted factor that `penalty` includes
  /// Penetration that the force of the multiplier is worth: the element presses as if it were so much deeper. Raised by
  /// the penetration that remains at an equilibrium, until none remains.
  double preload = 0;
  double raised_at = 0;           ///< penetration at the accepted increment that raised the preload last
  bool stuck = false;             ///< raising the preload changed nothing: what holds the fibers here is not contact
  double penetration_before = 0;  ///< when the preload was last raised in this increment
  double next_scale = 1, next_preload = 0;  ///< with which it goes on

  void set_scale(double scale) {
    penalty_scale = scale;
    penalty = unit_penalty * scale;
  }
  [[nodiscard]] PenaltyLaw law(double p_reg) const { return {penalty, preload, p_reg}; }

  /// At an equilibrium in which it presses with `force` at `gap`: raises the preload to the force that it has, at no
  /// penetration; and the penalty, where that has helped little. Returns false where nothing is left to be raised.
  bool raise(double gap, double force, double p_reg) {
    constexpr double helped_little = 0.5, no_difference = 0.9, as_stiff_as_can_be = 0.999, stiffer = 4, least = 1e-12;
    const double p = std::abs(gap);
    if (penetration_before > 0 && p > helped_little * penetration_before) {
      // Slow: the fibers resist about as much as the penalty does. Where even a stiff one makes no difference, it is
      // not contact that holds them in each other.
      if (penalty_scale < as_stiff_as_can_be * largest_penalty_scale)
        set_scale(std::min(stiffer * penalty_scale, largest_penalty_scale));
      else if (p > no_difference * penetration_before && gap < 0) {
        stuck = true;
        return false;
      }
    }
    preload = penetration_of_force(force, penalty, p_reg);
    penetration_before = std::max(p, least);
    return true;
  }
  /// The increment is accepted: sets with what the next one begins. What the multiplier is worth once the penetration
  /// is gone; where the fibers have parted, nothing. With `rises`, raised to the force that the element has now, so
  /// that penetrations do not add up from increment to increment; but where that has made no difference before, as at
  /// ends that are tied one in the other, it would raise the force each time.
  void accept(double gap, double force, double p_reg, bool rises) {
    constexpr double no_difference = 0.1;
    next_scale = penalty_scale;
    next_preload = gap < preload ? preload : 0;
    const double p = std::abs(gap);
    if (rises && force > 0 && !stuck && std::abs(p - raised_at) > no_difference * raised_at) {
      next_preload = penetration_of_force(force, penalty, p_reg);
      raised_at = p;
    }
    penetration_before = 0;
  }
  /// Goes on with another penalty, and the force that its preload has.
  void adapt(double scale, double p_reg) {
    if (penalty_scale == scale) return;
    const double force = penalty_force(-next_preload, penalty, p_reg);
    next_scale = scale;
    next_preload = penetration_of_force(force, penalty * scale / penalty_scale, p_reg);
  }
};

/// Whether contacts that are pressed too deep, or across gaps (by the preload of a force that is gone, which is as
/// wrong), make an answer too soft.
class Softness {
 public:
  /// `target`: of a penetration over the radius.
  explicit Softness(double target) : target_(target) {}
  void add(double gap, double force, double radius) {
    lost_ += 0.5 * force * std::abs(gap);
    const double depth = std::abs(gap) / radius;
    deepest_ = std::max(deepest_, depth);
    pressing_ += force;
    if (depth > target_) pressing_deep_ += force;
  }
  /// All together; `elastic_energy` as large as it is by the slack of all tolerances.
  [[nodiscard]] bool is_too_soft(double elastic_energy) const {
    constexpr double tolerated_softness = 0.005;  // relative error of a stiffness
    // Of thousands of contacts a few that press next to nothing are deeper than the rest.
    constexpr double tolerated_share = 0.01;  // of all forces
    return pressing_deep_ > tolerated_share * pressing_ || lost_ > tolerated_softness * elastic_energy;
  }
  /// Single ones, be they few of thousands.
  [[nodiscard]] bool has_one_too_deep() const { return deepest_ > deepest_over_target * target_; }

 private:
  double target_;
  double lost_ = 0;  // ½ f p: by so much the stored energy would rise without penetration
  double deepest_ = 0, pressing_ = 0, pressing_deep_ = 0;
};

/// What stiffening has come to.
struct Stiffening {
  bool raised = false;  ///< something has been
  /// A quarter of what is tolerated has been used up: the next increment had better begin with raised preloads. Raised
  /// sooner they would be the forces of contacts that hold every sample at no penetration at all, which curves of few
  /// dofs cannot follow: neighbours then take turns in bearing a load that is even.
  bool due = true;
};

/// Raises what presses of contact elements at an equilibrium, where they are too soft for an answer (`Softness`); where
/// that is the matter with single ones only, those that are far from just touching. On the way to rest that takes
/// `slack` times as much, but preloads are due as at rest, where there is no more time for them. An element has `gap()`
/// and `force(p_reg)`; `radius_of` and `regularisation_of` give a length for it.
template <class Element, class RadiusOf, class RegularisationOf>
Stiffening raise_where_too_soft(std::vector<Element>& elements, double target, double elastic_energy, double slack,
                                RadiusOf&& radius_of, RegularisationOf&& regularisation_of) {
  constexpr double part_that_is_due = 0.25;
  Softness softness(slack * target), softness_due(part_that_is_due * target);
  for (Element& e : elements) {
    e.stuck = e.stuck && e.gap() < 0;  // what held the fibers in each other has let go
    const double f = e.stuck ? 0 : e.force(regularisation_of(e));
    if (f <= 0) continue;
    softness.add(e.gap(), f, radius_of(e));
    softness_due.add(e.gap(), f, radius_of(e));
  }
  const bool all = softness.is_too_soft(slack * elastic_energy);
  Stiffening done{.due = softness_due.is_too_soft(part_that_is_due * elastic_energy)};
  if (!all && !softness.has_one_too_deep()) return done;
  constexpr double far = 0.5;  // of the target
  for (Element& e : elements) {
    const double p_reg = regularisation_of(e), f = e.force(p_reg);
    if (f > 0 && !e.stuck && (all || std::abs(e.gap()) > far * slack * target * radius_of(e)))
      done.raised = e.raise(e.gap(), f, p_reg) || done.raised;
  }
  return done;
}

}  // namespace trame::micro
