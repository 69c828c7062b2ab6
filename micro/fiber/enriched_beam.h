#pragma once
/// \file
/// Elastic energy of enriched beams: x(s, ξ) = r + ξ₁ g₁ + ξ₂ g₂, 9 dofs a node, 3-node elements, 2 Gauss points.
/// With z = (r', g₁, g₂, g₁', g₂') every strain measure is e = ½ zᵀ(A ⊗ I₃)z − e_ref; see micro/fiber/README.md. Two
/// points hardly see sections that swell and shrink from node to node, nor does contact at samples between nodes; so
/// the second difference ê of (E_11, E_22, 2E_12) over the nodes of an element adds ½ (h/2) (8/45) êᵀ D ê, what a third
/// point would see of it.

#include "micro/fiber/fiber_field.h"
#include "micro/solve/effect.h"

namespace trame::micro {

class EnrichedBeams final : public Effect {
 public:
  /// Strain measures: six constant over the section, two of bending, four of torsion and shear, three of twist–stretch.
  static constexpr int n_measures = 12, n_measures_twist_stretch = 15;

  /// `reference` is free of stress. `materials` per fiber. Fibers of other models are passed over.
  EnrichedBeams(const FiberField& field, std::vector<Material> materials, const FiberConfiguration& reference,
                bool twist_stretch);

  [[nodiscard]] std::string_view name() const override { return "enriched beams"; }
  [[nodiscard]] bool is_elastic() const override { return true; }
  void add_sparsity(Pattern::Builder& builder) const override;
  void add(const State& state, Assembler& assembler) const override;
  [[nodiscard]] double energy(const State& state) const override;
  /// Objects to fibers that collapsed (axial_law.h).
  [[nodiscard]] std::string inadmissibility(const State& start, const State& state) const override;
  [[nodiscard]] std::string doubt(const State& state) const override;
  /// Strain measures in use, and values of them that are kept for the stress-free shape.
  [[nodiscard]] int n_measures_in_use() const { return n_measures_; }
  [[nodiscard]] std::size_t n_reference_values() const { return reference_.size(); }

 private:
  using Z = Eigen::Matrix<double, 3, 5>;
  using Measures = Eigen::Matrix<double, n_measures_twist_stretch, 1>;
  using MeasureMatrix = Eigen::Matrix<double, 5, 5>;
  using Stiffness = Eigen::Matrix<double, n_measures_twist_stretch, n_measures_twist_stretch>;
  struct Section {
    Stiffness stiffness;                                          // D
    std::array<MeasureMatrix, n_measures_twist_stretch> measure;  // A_k
    double axial_stiffness;                                       // E_L A, of what axial_law.h adds
  };
  /// Calls visit(fiber, arc length, E_ss, z).
  template <typename Visit>
  void for_each_gauss_point(const State& state, Visit&& visit) const;
  [[nodiscard]] Measures measures(const Z& z, const Section& section) const;
  [[nodiscard]] Measures reference(Index fiber, Index element, int gauss_point) const;
  /// ê of an element whose node vectors begin at q, without its reference.
  [[nodiscard]] static Vec3 swelling(const Vec3* q);
  /// Strains are quadratic in z: what a step z changed them by beyond first order is `measures(z)`, or `swelling`.
  void add_swelling(const Vec3* q, const Vec3* last_step, const Section& section, const Vec3& reference,
                    const ElementNodes& nodes, double weight, Assembler& assembler) const;
  void add_gauss_point(const Z& z, const Z& last_step, const Section& section, const Measures& reference,
                       const ElementNodes& nodes, const std::array<double, 3>& n, const std::array<double, 3>& dn,
                       double weight, Assembler& assembler) const;

  const FiberField& field_;
  int n_measures_;
  std::vector<Section> sections_;  // distinct ones
  std::vector<Index> section_of_fiber_;
  std::vector<Index> first_element_;      // per fiber
  std::vector<double> reference_;         // those in use, at two Gauss points per element
  std::vector<Vec3> reference_swelling_;  // per element
};

/// 6 × 6 stiffness of a transversely isotropic material for (E_ss, E_11, E_22, 2E_12, 2E_s1, 2E_s2), axis s, in Pa.
[[nodiscard]] Eigen::Matrix<double, 6, 6> material_stiffness(const Material& material);

}  // namespace trame::micro
