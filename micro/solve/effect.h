#pragma once
/// \file
/// The one interface behind which all physics stands.

#include <string>
#include <string_view>

#include "micro/solve/system.h"

namespace trame::micro {

/// A term of the incremental potential: elastic fibers, contact, ties, loads, damping. Its life in an increment:
/// `begin_step` → (`update` → Newton iterations of `add`)* → `commit`, or nothing more where the increment is cut.
class Effect {
 public:
  virtual ~Effect() = default;
  [[nodiscard]] virtual std::string_view name() const = 0;

  /// A step from `start` to stage time t ∈ (0, 1] begins: take the load and the start values.
  virtual void begin_step(const State& /*start*/, double /*stage_time*/) {}
  /// What an update refreezes: everything (which particles face each other, normals, lagged forces), or all but the
  /// choice of particles.
  enum class Update : std::uint8_t { everything, directions };
  /// Refreezes at `state` what is constant within Newton's loop.
  virtual void update(const State& /*state*/, Update /*what*/) {}
  /// Fibers have travelled so far in this step that contact is about to be looked for again: hold them back, if that
  /// is what the effect is for.
  virtual void hold_back() {}
  /// Couplings between nodes that `add` may use until the next `update`.
  virtual void announce(Pattern::Builder& builder) const = 0;
  /// Adds the gradient and, where wanted, the tangent at `state` for the items that touch owned nodes.
  virtual void add(const State& state, Assembler& assembler) const = 0;
  /// The potential whose gradient `add` gives.
  [[nodiscard]] virtual double energy(const State& state) const = 0;
  /// Why the equilibrium `state`, reached in a step from `start`, must not be accepted all the same, and what may help;
  /// empty where it may.
  [[nodiscard]] virtual std::string objection(const State& /*start*/, const State& /*state*/) const { return {}; }
  /// The step is accepted: history moves on.
  virtual void commit(const State& /*state*/) {}
  /// True where `commit` has changed the effect so much that the last step of a stage should be taken again from
  /// `state`, at the same loads.
  [[nodiscard]] virtual bool wants_repeat(const State& /*state*/) const { return false; }
};

}  // namespace trame::micro
