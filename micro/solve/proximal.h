#pragma once
/// \file
/// Proximal (viscous) term ½ η Σ |r − r_n|² on positions: what keeps steps small while yarns are far from equilibrium.

#include <cmath>

#include "micro/solve/damping_book.h"
#include "micro/solve/effect.h"

namespace trame::micro {

class Proximal final : public Effect {
 public:
  /// Acts on vector 0 of nodes first_node … of the layout. η falls geometrically from `start` to `end` over the stage;
  /// where `end` is zero it falls to `last_share` of the start and vanishes at stage time 1.
  struct Settings {
    Index first_node = 0;
    double start = 0, end = 0;
  };
  Proximal(const Layout& layout, const Settings& settings) : layout_(layout), settings_(settings) {}

  [[nodiscard]] std::string_view name() const override { return "proximal damping"; }
  void begin_step(const State& start, double stage_time) override {
    held_at_ = start;
    book_ = book_n_;
    const auto& [first_node, first, end] = settings_;
    const double last = end > 0 ? end : last_share * first;
    eta_ = stage_time >= 1 && end == 0 ? 0 : first * std::pow(last / first, stage_time);
    n_detours_ = 0;
  }
  /// Once fibers have travelled far a few times in a step, η doubles each time: some loose ones would otherwise run to
  /// and fro.
  void hold_back() override {
    ++n_detours_;
    if (n_detours_ > free_detours && n_detours_ <= free_detours + max_doublings) eta_ *= 2;
  }
  [[nodiscard]] bool hold_at(const State& state) override {
    enter(state);
    held_at_ = state;
    return eta_ > 0;
  }
  void add_sparsity(Pattern::Builder&) const override {}
  void add(const State& state, Assembler& assembler) const override {
    if (eta_ == 0) return;
    for (Index n = settings_.first_node; n < layout_.n_nodes(); ++n) {
      if (!assembler.owns(n)) continue;
      const Index v = layout_.first_vector(n);
      assembler.add_force(n, 0, eta_ * (state.q[v] - held_at_.q[v]));
      if (!assembler.wants_tangent()) continue;
      const auto block = assembler.block(n, n);
      for (int c = 0; c < 3; ++c) block.data[static_cast<std::size_t>(c) * block.stride + c] += eta_;
    }
  }
  [[nodiscard]] double energy(const State& state) const override {
    double sum = 0;
    for (Index n = settings_.first_node; n < layout_.n_nodes() && eta_ > 0; ++n)
      sum += (state.q[layout_.first_vector(n)] - held_at_.q[layout_.first_vector(n)]).squaredNorm();
    return 0.5 * eta_ * sum;
  }
  /// It stores nothing: what its force takes, which goes from that of the last step to that of this one, is gone.
  [[nodiscard]] Ledger ledger(const State&) const override {
    Ledger ledger;
    ledger[Sink::damping] = book_n_.dissipated;
    return ledger;
  }
  void commit(const State& state) override {
    enter(state);
    book_n_ = book_;
  }

  void keep(Archive& archive) override { book_n_.keep(archive, static_cast<std::size_t>(layout_.n_nodes())); }

  [[nodiscard]] double eta() const { return eta_; }

 private:
  /// Enters the motion to `state`.
  void enter(const State& state) {
    for (Index n = settings_.first_node; n < layout_.n_nodes(); ++n) {
      const Vec3 motion = state.q[layout_.first_vector(n)] - held_at_.q[layout_.first_vector(n)];
      book_.enter(static_cast<std::size_t>(n), eta_ * motion, motion);
    }
  }

  static constexpr double last_share = 1e-3;
  static constexpr int free_detours = 4, max_doublings = 10;

  const Layout& layout_;
  Settings settings_;
  double eta_ = 0;
  int n_detours_ = 0;          // in this step
  DampingBook book_n_, book_;  // of nodes: up to the last accepted step, and on in this one
  State held_at_;
};

}  // namespace trame::micro
