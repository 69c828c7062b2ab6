#pragma once
/// \file
/// Contact and friction between fibers: contact elements made from proximities, their history and their penalties.

#include <optional>
#include <vector>

#include "micro/contact/contact_element.h"
#include "micro/contact/contact_law.h"
#include "micro/contact/proximity.h"
#include "micro/solve/effect.h"

namespace trame::micro {

/// Penalty contact with Coulomb friction between fibers that run side by side or cross.
class Contact final : public Effect {
 public:
  /// `modulus` per fiber: what a penalty is measured in (transverse modulus).
  Contact(const FiberField& field, const ContactLaw& law, std::vector<double> modulus);

  [[nodiscard]] std::string_view name() const override { return "contact"; }
  void begin_step(const State& start, double stage_time) override;
  void update(const State& state, bool keep = false) override;
  bool follow(const State& state, Follow what, const Region& region) override;
  /// A fiber whose box is apart from all others may go half of that distance.
  void limit_reach(const State& state, std::span<double> reach) const override;
  void add_sparsity(Pattern::Builder& builder) const override;
  void add(const State& state, Assembler& assembler) const override;
  void add_unsymmetric(const State& state, UnsymmetricTerms& terms) const override;
  [[nodiscard]] double energy(const State& state) const override;
  /// Stored are the energy of the penalties and that of the reversible part of friction, ½|f|²/k. (`energy` is the
  /// incremental potential, which also holds the work of slip in the step.)
  [[nodiscard]] Ledger ledger(const State& state) const override;
  void commit(const State& state) override;
  void keep(Archive& archive) override;
  /// Raises preloads by the penetrations that remain, where 1 % of the forces press deeper than the target, one of them
  /// three times as deep or any across so wide a gap, or where the work that forces have lost on penetrations is more
  /// than 0.5 % of the elastic energy: by so much the answer is too soft.
  [[nodiscard]] bool stiffen(const State& state, double elastic_energy, double slack) override;

  [[nodiscard]] const std::vector<ContactElement>& elements() const { return elements_; }
  /// Friction of each of `elements`; empty without friction.
  [[nodiscard]] const std::vector<StickSlip>& stick_slip() const { return stick_slip_; }
  /// How often fibers near each other were looked for.
  [[nodiscard]] int n_searches() const { return n_searches_; }
  [[nodiscard]] double regularisation(const ContactElement& element) const;
  /// Largest penetration over the mean radius of the pair.
  [[nodiscard]] double max_penetration_over_radius() const;
  [[nodiscard]] const std::vector<ContactHistory>& history() const { return history_; }
  /// Friction::force of the pairs in `history` that have one; empty without friction.
  [[nodiscard]] const std::vector<Vec3>& tractions() const { return tractions_; }
  void set_history(std::vector<ContactHistory> history, std::vector<Vec3> tractions = {});
  /// Counts the gap of each pair from the penetration at `start`; this offset fades
  /// linearly until stage time 0.75. For yarns that were just parted with vertical normals: where they are inclined,
  /// R_a + R_b of height is less of distance, and pushing all that out at once throws fibers out of their yarns.
  void offset_gaps(const State& start);

 private:
  /// `known` from the last accepted increment, `before` from the last search in this one, where there is such a one.
  [[nodiscard]] ContactElement make_element(const Proximity& proximity, const State& state, const ContactHistory* known,
                                            const ContactElement* before) const;
  /// Friction as the element now stands: limit, stiffness and particles.
  [[nodiscard]] StickSlip make_stick_slip(ContactElement& element, const ContactHistory* known) const;
  /// Friction of element i. Only with friction.
  [[nodiscard]] Friction friction_of(std::size_t i, const State& state) const;
  /// Whether an element moves with fibers that are free.
  [[nodiscard]] bool concerns(const ContactElement& element, const Region& region) const;
  [[nodiscard]] double penalty_energy_at(const State& state) const;
  /// Energy of the reversible slips.
  [[nodiscard]] double slip_energy(const State& state) const;
  [[nodiscard]] const ContactHistory* find_history(const Proximity& proximity) const;
  [[nodiscard]] double mean_radius(Index a, Index b) const;
  [[nodiscard]] double spacing(Index a, Index b) const;
  [[nodiscard]] double starting_scale(const Proximity& proximity) const;
  /// The arc length of the same place within the first period, of a fiber that comes back.
  [[nodiscard]] double in_first_period(Index fiber, double s) const;
  void note_loaded_particles();
  void adapt_penalties();
  /// Books what became of the contacts of the last accepted state on the way to `state`. Returns the force of each of
  /// `elements` at the step's start.
  std::vector<double> book_changes(const State& state);

  const FiberField& field_;
  ContactLaw law_;
  std::vector<double> modulus_;
  State start_;                 // of the step
  std::vector<Vec3> followed_;  // vectors of the state that the elements have followed; none after a search
  double fading_ = 0;           // part of the gap offsets that is still granted
  double fading_n_ = 0,
         gap_offset_force_n_ = 0;  // the same at the last accepted increment, and the force that works on it
  bool preloads_are_due_ = true;   // at the last equilibrium
  std::vector<ContactElement> elements_;
  std::vector<const ContactHistory*> known_;  // of each element; in history_
  std::vector<StickSlip> stick_slip_;
  std::vector<ContactHistory> history_;  // of the last accepted increment, sorted like elements_
  std::vector<Vec3> tractions_;
  struct LoadedParticle {
    Index fiber;
    double s, log_scale;
  };
  std::vector<LoadedParticle> loaded_;  // particles in contact, sorted, with the logarithm of their penalty scale
  // Of the last accepted increment; before it, of the first detection of the stage, and empty before that.
  std::optional<double> slip_energy_n_;
  std::vector<ContactElement> elements_n_;
  Ledger booked_;  // of accepted increments; stores nothing
  int n_searches_ = 0;
};

}  // namespace trame::micro
