#pragma once
/// \file
/// Fibers as continuous curves over the unknowns of a system, whatever their model.

#include <array>
#include <string>

#include "micro/fiber/fiber_mesh.h"
#include "micro/fiber/fiber_model.h"
#include "micro/solve/system.h"

namespace trame::micro {

/// A material point x(s, ξ) as a linear form of the unknowns: x = Σ weight[a][v] q(node first_node + a, vector v).
/// Vectors of a node are (r, g₁, g₂) for enriched beams and (r, dr/ds) for rods; a rod has no ξ.
struct FiberPoint {
  Index first_node = 0;
  int n_nodes = 0;    ///< up to 4 enriched, 2 rod
  int n_vectors = 0;  ///< per node: 3 enriched, 2 rod
  std::array<std::array<double, 3>, 4> weight{};

  [[nodiscard]] Vec3 evaluate(const Layout& layout, const State& state) const {
    Vec3 x = Vec3::Zero();
    const Vec3* q = state.q.data() + layout.first_vector(first_node);
    for (int a = 0; a < n_nodes; ++a)
      for (int v = 0; v < n_vectors; ++v) x += weight[a][v] * q[a * n_vectors + v];
    return x;
  }
};

/// A place of a fiber as linear forms of its nodes' vectors: the centre line and its derivatives by arc length, and the
/// section vectors of an enriched beam. Weights of the centre line are for r and, in a rod, dr/ds.
struct CurveShape {
  using Weights = std::array<std::array<double, 2>, 4>;
  Index first_node = 0;  ///< of the system
  int n_nodes = 0, n_vectors = 0;
  Weights r{}, tangent{}, curvature{};
  std::array<double, 4> section{};
};

/// Centre line at a point, with its derivatives by arc length up to the second.
struct CurveJet {
  Vec3 r, tangent, curvature;
};

/// Where the unknowns of each fiber stand, and the curves that they describe, which all have a continuous tangent: a
/// rod is the cubic through its nodes' vectors; the centre line of an enriched beam is taken through its nodes as
/// cubics with the slope of the parabola through each node and its two neighbours (Catmull, Rom, 1974). Its elements'
/// own parabolas meet at angles, at which contacts would jump. Section vectors are those of the elements, so that an
/// even pressure squeezes sections evenly.
class FiberField {
 public:
  /// Adds the nodes of all fibers to `layout`, fiber by fiber. `models` has one entry per fiber.
  FiberField(const FiberMesh& mesh, std::vector<FiberModel> models, Layout& layout);

  [[nodiscard]] const FiberMesh& mesh() const { return *mesh_; }
  [[nodiscard]] const Layout& layout() const { return *layout_; }
  [[nodiscard]] FiberModel model(Index fiber) const { return models_[fiber]; }
  [[nodiscard]] double element_length(Index fiber) const { return element_length_[fiber]; }
  /// System node of the first node of element e of a fiber (3 nodes for enriched beams, 2 for rods).
  [[nodiscard]] Index element_node(Index fiber, Index e) const {
    return first_system_node_[fiber] + (models_[fiber] == FiberModel::enriched ? 2 * e : e);
  }
  [[nodiscard]] Index last_node(Index fiber) const { return first_system_node_[fiber + 1] - 1; }

  /// The place at arc length s; beyond an end the curve goes on as the last stretch.
  [[nodiscard]] CurveShape shape(Index fiber, double s) const;
  [[nodiscard]] CurveJet curve(const State& state, Index fiber, double s) const {
    return curve(state, shape(fiber, s));
  }
  [[nodiscard]] CurveJet curve(const State& state, const CurveShape& shape) const;
  /// Section vectors at a place of an enriched fiber.
  [[nodiscard]] std::array<Vec3, 2> section(const State& state, const CurveShape& shape) const;
  /// Their derivatives by arc length, as smooth as those of the centre line.
  [[nodiscard]] std::array<Vec3, 2> section_slope(const State& state, const CurveShape& shape) const;
  /// "fiber 3 of yarn warp/1 at 40 % of its length", for messages.
  [[nodiscard]] std::string describe(Index fiber, double s) const;
  /// The particle (s, ξ) as a linear form; ξ is ignored for rods.
  [[nodiscard]] FiberPoint particle(Index fiber, double s, const Vec2& xi) const;

  /// Unknowns of a configuration, and back. The latter fills every node of the mesh; sections of rods are those
  /// that `configuration` holds, turned at each node with the tangent.
  void read_configuration(const FiberConfiguration& configuration, State& state) const;
  void write_configuration(const State& state, FiberConfiguration& configuration) const;

 private:
  const FiberMesh* mesh_;
  const Layout* layout_;
  std::vector<FiberModel> models_;
  std::vector<Index> first_system_node_;
  std::vector<double> element_length_;
};

/// Values and derivatives (by t ∈ [−1, 1]) of the quadratic Lagrange functions at −1, 0, 1.
[[nodiscard]] std::array<double, 3> quadratic_shape(double t);
[[nodiscard]] std::array<double, 3> quadratic_shape_derivative(double t);

/// Cubic Hermite functions of an element of length h for (r₁, r₁', r₂, r₂'), ' by arc length, and their derivatives by
/// arc length.
[[nodiscard]] std::array<double, 4> hermite_shape(double t, double h);
[[nodiscard]] std::array<double, 4> hermite_shape_derivative(double t, double h);
[[nodiscard]] std::array<double, 4> hermite_shape_second_derivative(double t, double h);

}  // namespace trame::micro
