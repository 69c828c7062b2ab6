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
  int n_nodes = 0;    ///< 3 enriched, 2 rod
  int n_vectors = 0;  ///< per node: 3 enriched, 2 rod
  std::array<std::array<double, 3>, 3> weight{};

  [[nodiscard]] Vec3 evaluate(const Layout& layout, const State& state) const {
    Vec3 x = Vec3::Zero();
    const Vec3* q = state.q.data() + layout.first_vector(first_node);
    for (int a = 0; a < n_nodes; ++a)
      for (int v = 0; v < n_vectors; ++v) x += weight[a][v] * q[a * n_vectors + v];
    return x;
  }
};

/// Centre line and its tangent dr/ds at a point.
struct CurvePointAndTangent {
  Vec3 r, tangent;
};

/// Centre line at a point, with its derivatives by arc length up to the second.
struct CurveJet {
  Vec3 r, tangent, curvature;
};

/// Where the unknowns of each fiber stand, and the curves that they describe.
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

  /// Centre line and tangent at arc length s, 0 ≤ s ≤ length.
  [[nodiscard]] CurvePointAndTangent curve(const State& state, Index fiber, double s) const;
  /// The same with the second derivative, from the polynomials of one element, also where s lies beyond its ends. Two
  /// elements of an enriched fiber do not agree on the tangent where they join.
  [[nodiscard]] CurveJet jet(const State& state, Index fiber, Index element, double s) const;
  /// The element that holds s; of two that join there the second.
  [[nodiscard]] Index element_at(Index fiber, double s) const { return locate(fiber, s).element; }
  /// Section vectors at s (enriched fibers only).
  [[nodiscard]] std::array<Vec3, 2> section(const State& state, Index fiber, double s) const;
  /// "fiber 3 of yarn warp/1 at 40 % of its length", for messages.
  [[nodiscard]] std::string describe(Index fiber, double s) const;
  /// The particle (s, ξ) as a linear form; ξ is ignored for rods.
  [[nodiscard]] FiberPoint particle(Index fiber, double s, const Vec2& xi) const;
  /// Position and tangent of the centre line at s, by the polynomials of one element, as linear forms.
  struct CurveForms {
    FiberPoint r, tangent;
  };
  [[nodiscard]] CurveForms curve_forms(Index fiber, Index element, double s) const;

  /// Unknowns of a configuration, and back. The latter fills every node of the mesh; sections of rods are those
  /// that `configuration` holds, turned at each node with the tangent.
  void read_configuration(const FiberConfiguration& configuration, State& state) const;
  void write_configuration(const State& state, FiberConfiguration& configuration) const;

 private:
  struct Local {
    Index element;
    double t;  // −1…1 within the element
  };
  [[nodiscard]] Local locate(Index fiber, double s) const;

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
