#pragma once
/// \file
/// What keeps the fibers of a periodic cell from drifting where nothing else does.

#include "micro/fiber/fiber_field.h"
#include "micro/solve/damping_book.h"
#include "micro/solve/effect.h"

namespace trame::micro {

/// Fibers without ends may move along and turn about themselves, and the cell with all of them to anywhere, without any
/// force but friction. Of each the first node is held to where it was when the step began, r_n, and the sections there
/// to what they were, by weak springs, ½ k |r − Σ ξ_k a_k − (r_n − Σ ξ_k a_kn)|² and ½ k R² |g − g_n|²: with ξ_k, the
/// coordinates of r_n along the periods a_k, a fiber that goes along with the deformation of the cell feels nothing. k
/// is 10⁻⁴ E A / L. What that takes is damping, as of Proximal.
class Anchors final : public Effect {
 public:
  explicit Anchors(const FiberField& field);

  [[nodiscard]] std::string_view name() const override { return "anchors"; }
  /// What holds a fiber against nothing is no load: equilibrium is not judged against it.
  [[nodiscard]] bool is_elastic() const override { return true; }
  void begin_step(const State& start, double stage_time) override;
  void add_sparsity(Pattern::Builder& builder) const override;
  void add(const State& state, Assembler& assembler) const override;
  [[nodiscard]] double energy(const State& state) const override;
  [[nodiscard]] Ledger ledger(const State& state) const override;
  void commit(const State& state) override;
  void keep(Archive& archive) override;

 private:
  struct Anchor {
    Index node;
    int n_vectors;             // r; of enriched beams g₁ and g₂ as well
    double k;                  // of r
    double k_section;          // of g₁ and g₂
    std::array<double, 2> xi;  // of r_n, in this step
  };
  /// How far vector v of an anchor is from where it is held.
  [[nodiscard]] Vec3 deviation(const State& state, const Anchor& anchor, int v) const;

  const FiberField& field_;
  std::vector<Anchor> anchors_;
  State start_;
  DampingBook book_;  // of the vectors of all anchors
};

}  // namespace trame::micro
