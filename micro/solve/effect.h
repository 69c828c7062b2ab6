#pragma once
/// \file
/// The one interface behind which all physics stands.

#include <span>
#include <string>
#include <string_view>

#include "micro/core/ledger.h"
#include "micro/solve/system.h"
#include "micro/solve/unsymmetric_terms.h"

namespace trame::micro {

/// A term of the incremental potential: elastic fibers, contact, ties, loads, damping. Its life in an increment:
/// `begin_step` → (`update` → Newton iterations of `follow` and `add`)* → `commit`, or nothing more where the increment
/// is cut.
class Effect {
 public:
  virtual ~Effect() = default;
  [[nodiscard]] virtual std::string_view name() const = 0;

  /// A step from `start` to stage time t ∈ (0, 1] begins: take the load and the start values.
  virtual void begin_step(const State& /*start*/, double /*stage_time*/) {}
  /// Looks anew, at `state`, for what the effect acts on: which fibers are near each other. With `keep`, what it acts
  /// on already stays as it is, and only what is missing is added: `state` is an equilibrium of that, or fibers go to
  /// and fro.
  virtual void update(const State& /*state*/, bool /*keep*/ = false) {}
  /// A state along a step that is tried, or the one with which an iteration begins; and likewise, but with the limits
  /// of friction renewed.
  enum class Follow : std::uint8_t { trial, renewed_trial, iteration, renewal };
  [[nodiscard]] static constexpr bool is_trial(Follow what) {
    return what == Follow::trial || what == Follow::renewed_trial;
  }
  [[nodiscard]] static constexpr bool renews_limits(Follow what) {
    return what == Follow::renewed_trial || what == Follow::renewal;
  }
  /// Goes with the state, which is about to be assembled at: contact slides to where fibers face each other. Outside
  /// of the region nothing has moved. Returns true where couplings have come up that are not in the sparsity.
  virtual bool follow(const State& /*state*/, Follow /*what*/, const Region& /*region*/) { return false; }
  /// Whether the effect is the fibers' own elasticity. What is not, comes from outside of a fiber: contact, friction,
  /// bodies, loads. Equilibrium is judged against that.
  [[nodiscard]] virtual bool is_elastic() const { return false; }
  /// Lowers, for each vector, how far it may go from `state` before the effect must look anew for what it acts on.
  virtual void limit_reach(const State& /*state*/, std::span<double> /*reach*/) const {}
  /// Fibers have travelled so far in this step that contact is about to be looked for again: hold them back, if that
  /// is what the effect is for.
  virtual void hold_back() {}
  /// Holds fibers at `state`, an equilibrium, from now on, not where the step began. Returns true if it holds them at
  /// all, so that without it there may be no equilibrium.
  [[nodiscard]] virtual bool hold_at(const State& /*state*/) { return false; }
  /// Adds the couplings between nodes that `add` may use until the next `update`, or `follow` that returns true.
  virtual void add_sparsity(Pattern::Builder& builder) const = 0;
  /// Adds the gradient and, where wanted, the tangent at `state` for the items that touch owned nodes.
  virtual void add(const State& state, Assembler& assembler) const = 0;
  /// Adds what the tangent has besides where limits of friction are renewed.
  virtual void add_unsymmetric(const State& /*state*/, UnsymmetricTerms& /*terms*/) const {}
  /// The potential whose gradient `add` gives.
  [[nodiscard]] virtual double energy(const State& state) const = 0;
  /// The effect's part of the energy books: what it stores at the accepted state `state`, and what it has dissipated
  /// and got from outside of the potential in all steps accepted since its stage began. Here, for what is nothing but a
  /// potential: the potential.
  [[nodiscard]] virtual Ledger ledger(const State& state) const {
    Ledger ledger;
    ledger.stored = energy(state);
    return ledger;
  }
  /// Why the equilibrium `state`, reached in a step from `start`, is inadmissible all the same, and what may help;
  /// empty where it is not.
  [[nodiscard]] virtual std::string inadmissibility(const State& /*start*/, const State& /*state*/) const { return {}; }
  /// What makes the answer at `state` doubtful, though it is an equilibrium; empty where nothing does.
  [[nodiscard]] virtual std::string doubt(const State& /*state*/) const { return {}; }
  /// The step is accepted: history moves on.
  virtual void commit(const State& /*state*/) {}
  /// Passes through all that goes from one increment to the next, as it is after `commit`.
  virtual void keep(Archive& /*archive*/) {}
  /// Looks whether the equilibrium `state` is as accurate as it must be, up to `slack` times its tolerances, and where
  /// it is not makes itself stiffer. Returns true where equilibrium has to be found again. `elastic_energy`: what the
  /// fibers store.
  [[nodiscard]] virtual bool stiffen(const State& /*state*/, double /*elastic_energy*/, double /*slack*/) {
    return false;
  }
};

}  // namespace trame::micro
