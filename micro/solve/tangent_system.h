#pragma once
/// \file
/// The linear system of Newton's method: tangent and forces of a set of effects, prescribed motion, damping.

#include <memory>
#include <span>
#include <vector>

#include "micro/core/timers.h"
#include "micro/solve/effect.h"

namespace trame::micro {

using Effects = std::vector<std::unique_ptr<Effect>>;

/// Dofs that are not free: where `fixed[d]` is set, dof d moves by `motion[d]`.
struct PrescribedMotion {
  std::vector<char> fixed;
  std::vector<double> motion;
};

/// Matrix and forces as last assembled. Keeps what is worth keeping between systems of the same layout.
class TangentSystem {
 public:
  /// Of the nodes of a region, which must outlive it; all others have to be prescribed, and stay where they are.
  TangentSystem(const Layout& layout, int n_threads, Timers& timers, const Region& region = everywhere);

  /// Makes the pattern cover the sparsity of the effects; a pattern that covers it already is kept. Returns true for a
  /// new one.
  bool cover_sparsity(const Effects& effects);
  void forget_pattern() { pattern_ = {}; }

  /// Forces at `state`, and the tangent where one is wanted. `last_step` is the change of all vectors that has led
  /// there.
  void assemble(const Effects& effects, const State& state, std::span<const Vec3> last_step, Assembler::Tangent tangent,
                Assembler::Stress of_forces = Assembler::Stress::actual);

  /// Turns the matrix and `right_side` (= −force) into the system of the free dofs: what remains of the prescribed
  /// motion goes to the right-hand side, its rows and columns become those of the identity, with 0 on their right-hand
  /// side. Prescribed dofs stand in body nodes, which come first: their couplings to fibers are in their own columns,
  /// those among bodies in columns of bodies.
  void impose(const PrescribedMotion& prescribed, double remaining, std::span<double> right_side);
  void scale_diagonal(double factor);
  void add_to_diagonal(Index vector, double stiffness);
  /// Dofs of bodies that nothing resists, as those of a plate that touches nothing yet: they go as far as `farthest`,
  /// in the unit of their vector, where `load` drives them.
  void hold_loose_bodies(std::span<const double> load, double farthest, std::span<const double> unit);

  [[nodiscard]] const Layout& layout() const { return layout_; }
  [[nodiscard]] const Pattern& pattern() const { return pattern_; }
  [[nodiscard]] const std::vector<double>& values() const { return values_; }
  [[nodiscard]] const std::vector<double>& force() const { return force_; }
  /// Of each vector: sizes of the forces of elasticity, and of all others.
  [[nodiscard]] const std::vector<double>& inner() const { return inner_; }
  [[nodiscard]] const std::vector<double>& outer() const { return outer_; }
  [[nodiscard]] Index node_of(Index vector) const { return node_of_[vector]; }
  [[nodiscard]] bool is_position(Index vector) const { return vector == layout_.first_vector(node_of_[vector]); }
  /// Norms of K_ii q_i over all forces and all moments: what round-off is a share of.
  [[nodiscard]] std::pair<double, double> diagonal_forces(const State& state) const;

 private:
  /// Turns what effects have added, by x, y and z, into forces and stiffness of dofs that count along other axes.
  void turn_to_dofs(bool with_tangent);

  const Layout& layout_;
  int n_threads_;
  Timers& timers_;
  const Region& region_;
  Pattern pattern_;
  std::vector<Index> owned_from_;  // n_threads + 1 node limits
  std::vector<Index> node_of_;     // of each vector
  std::vector<double> values_, force_, inner_, outer_;
};

/// The largest of a set of changes of all vectors, given as a function of the vector, in their units.
struct Largest {
  double size = 0;
  Index vector = 0;
};
template <typename Change>
[[nodiscard]] Largest largest(std::span<const double> unit, const Change& change) {
  Largest result;
  for (std::size_t v = 0; v < unit.size(); ++v) {
    const double size = change(static_cast<Index>(v)) / unit[v];
    if (size > result.size) result = {size, static_cast<Index>(v)};
  }
  return result;
}
/// The same of a step, which has three dofs a vector.
[[nodiscard]] inline Largest largest(std::span<const double> unit, const std::vector<double>& step) {
  return largest(unit, [&](Index v) { return Eigen::Map<const Vec3>(step.data() + 3 * v).norm(); });
}

}  // namespace trame::micro
