#pragma once
/// \file
/// Contact and friction between fibers: contact elements made from proximities, their history and their penalties.

#include "micro/contact/contact_element.h"
#include "micro/contact/proximity.h"
#include "micro/solve/effect.h"

namespace trame::micro {

/// Numbers of the contact law, in the unit system of the model.
struct ContactLaw {
  ProximitySearch search;
  double penalty = 0.02;             ///< starting stiffness per length over the modulus
  double target_penetration = 0.03;  ///< in radii
  double regularisation = 0.1;       ///< p_reg of the penalty, in radii
  bool adapt_penalty = true;
  bool friction = true;
  double friction_coefficient = 0.2;
  double reversible_slip = 0.05;     ///< in radii
};

/// Penalty contact with Coulomb friction between fibers that run side by side or cross.
class Contact final : public Effect {
 public:
  /// `modulus` per fiber: what a penalty is measured in (transverse modulus).
  Contact(const FiberField& field, const ContactLaw& law, std::vector<double> modulus);

  [[nodiscard]] std::string_view name() const override { return "contact"; }
  void begin_step(const State& start, double stage_time) override;
  void update(const State& state, Update what) override;
  void announce(Pattern::Builder& builder) const override;
  void add(const State& state, Assembler& assembler) const override;
  [[nodiscard]] double energy(const State& state) const override;
  void commit(const State& state) override;

  [[nodiscard]] const std::vector<ContactElement>& elements() const { return elements_; }
  [[nodiscard]] double regularisation(const ContactElement& element) const;
  /// Largest penetration over the mean radius of the pair.
  [[nodiscard]] double max_penetration_over_radius(const State& state) const;
  /// Energy of the penalties and of the reversible part of friction, ½|f|²/k. (`energy` is the incremental potential, which
  /// also holds the work of slip in the step.)
  [[nodiscard]] double stored_energy(const State& state) const;
  [[nodiscard]] double dissipated() const { return dissipated_; }
  /// Work that came in where penalties were raised under pressure, less what went out where they were lowered, and that of fading
  /// allowances.
  [[nodiscard]] double adaptation_work() const { return adaptation_work_; }
  [[nodiscard]] const std::vector<ContactHistory>& history() const { return history_; }
  void set_history(std::vector<ContactHistory> history);
  /// Forgives the penetrations of `start`: the gap of each pair is measured from there, and the allowance fades linearly until
  /// stage time 0.75. For yarns that were just parted with vertical normals: where they are inclined, R_a + R_b of height is
  /// less of distance, and pushing all that out at once throws fibers out of their yarns.
  void forgive(const State& start);

 private:
  [[nodiscard]] ContactElement make_element(const Proximity& proximity, const State& state,
                                            const ContactHistory* known) const;
  [[nodiscard]] const ContactHistory* find_history(const Proximity& proximity) const;
  [[nodiscard]] double mean_radius(Index a, Index b) const;
  [[nodiscard]] double starting_scale(const Proximity& proximity) const;
  void note_loaded_particles();
  void adapt_penalties(const State& state);

  const FiberField& field_;
  ContactLaw law_;
  std::vector<double> modulus_;
  State start_;
  double fading_ = 0;  // part of the allowances that is still granted
  double fading_n_ = 0, allowance_force_n_ = 0;  // the same at the last accepted increment, and the force that works on it
  std::vector<ContactElement> elements_;
  std::vector<ContactHistory> history_;  // of the last accepted increment, sorted like elements_
  struct LoadedParticle {
    Index fiber;
    double s, log_scale;
  };
  std::vector<LoadedParticle> loaded_;   // particles in contact, sorted, with the logarithm of their penalty scale
  double dissipated_ = 0, adaptation_work_ = 0;
};

}  // namespace trame::micro
