#pragma once
/// \file
/// Forces on fibers per length, such as weight or drag. A force f per length of the start configuration, whose
/// direction does not go with the fiber, acts on the centre line:
///   Π = −∫ f·(r − r_n) ds
/// with r_n at the start of the step. Vectors of an element of length h get ∫ N f ds of their shape functions N:
/// h (1, 4, 1)/6 f for the three r of an enriched beam, (h/2, h²/12, h/2, −h²/12) f for (r₁, r₁', r₂, r₂') of a rod.

#include <vector>

#include "micro/core/amplitude.h"
#include "micro/fiber/fiber_field.h"
#include "micro/solve/effect.h"

namespace trame::micro {

/// A force per length on a fiber that goes through a stage from `start` to `end` and beyond, as its amplitude says.
struct FiberLoadTerm {
  Index fiber = 0;
  Vec3 start = Vec3::Zero(), end = Vec3::Zero();
  Amplitude amplitude = {};

  [[nodiscard]] Vec3 at(double stage_time) const { return start + amplitude.at(stage_time) * (end - start); }
};

class FiberLoads final : public Effect {
 public:
  FiberLoads(const FiberField& field, std::vector<FiberLoadTerm> terms);
  [[nodiscard]] std::string_view name() const override { return "loads on fibers"; }
  void begin_step(const State& start, double stage_time) override;
  /// A force that does not go with the fiber has no tangent.
  void add_sparsity(Pattern::Builder&) const override {}
  void add(const State& state, Assembler& assembler) const override;
  [[nodiscard]] double energy(const State& state) const override;
  /// It stores nothing: its work, that of the mean of the force before and after each step, comes in from outside.
  [[nodiscard]] Ledger ledger(const State& state) const override;
  void commit(const State& state) override;
  void keep(Archive& archive) override { archive(time_n_, work_); }

  [[nodiscard]] const std::vector<FiberLoadTerm>& terms() const { return terms_; }
  /// Moment about the origin of the load on each fiber, ∫ r × f ds.
  [[nodiscard]] std::vector<Vec3> moments(const State& state) const;

 private:
  /// Force per length on each fiber at a stage time.
  [[nodiscard]] std::vector<Vec3> forces(double stage_time) const;
  /// ∫ r ds of a fiber with the vectors q.
  [[nodiscard]] Vec3 integral(Index fiber, const std::vector<Vec3>& q) const;
  /// −Π with these forces per length.
  [[nodiscard]] double work(const std::vector<Vec3>& force, const State& state) const;

  const FiberField& field_;
  std::vector<FiberLoadTerm> terms_;
  std::vector<Index> loaded_;          // fibers with terms, ascending
  std::vector<Vec3> force_n_, force_;  // per length, at the start and at the end of the step
  std::vector<Vec3> q_n_;
  double time_ = 0, time_n_ = 0;
  double work_ = 0;  // in all accepted steps
};

}  // namespace trame::micro
