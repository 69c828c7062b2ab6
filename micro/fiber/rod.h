#pragma once
/// \file
/// Rods: stretch and bending only, cubic Hermite elements with 6 dofs a node (r, dr/ds), straight at rest.
/// Energy ∫ EA W(E_ss) + ½ EI r''·r'' ds, W = ½ E_ss² but under strong compression (axial_law.h). Under small strain
/// r''·r'' is κ² plus the square of the strain gradient, which is (R/ℓ)² smaller than the stretching energy over
/// lengths ℓ; in exchange the bending tangent is constant and positive. E_ss is taken at the three Lobatto points of an
/// element, which leaves bending free of membrane locking (the constraint count of Meier, Popp & Wall 2015).

#include "micro/fiber/fiber_field.h"
#include "micro/solve/effect.h"

namespace trame::micro {

class Rods final : public Effect {
 public:
  /// `materials` per fiber; fibers of other models are passed over.
  Rods(const FiberField& field, const std::vector<Material>& materials);

  [[nodiscard]] std::string_view name() const override { return "rods"; }
  [[nodiscard]] bool is_elastic() const override { return true; }
  void add_sparsity(Pattern::Builder& builder) const override;
  void add(const State& state, Assembler& assembler) const override;
  [[nodiscard]] double energy(const State& state) const override;
  /// Objects to fibers that collapsed (axial_law.h).
  [[nodiscard]] std::string inadmissibility(const State& start, const State& state) const override;
  [[nodiscard]] std::string doubt(const State& state) const override;

 private:
  void add_element(const Vec3* q, const Vec3* last_step, Index fiber, const ElementNodes& nodes,
                   Assembler& assembler) const;

  const FiberField& field_;
  std::vector<double> axial_stiffness_, bending_stiffness_;  // per fiber, EA and EI
};

}  // namespace trame::micro
