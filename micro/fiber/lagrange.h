#pragma once
/// \file
/// Polynomials through the nodes of an element by arc length, wherever its nodes lie. The solver's own elements, whose
/// middle node is half-way, have theirs in fiber_field.h.

#include <array>
#include <vector>

#include "micro/core/types.h"

namespace trame::micro {

/// Lagrange polynomials of up to three nodes and their derivatives, at one place.
struct LagrangeShape {
  int n_nodes = 3;
  std::array<double, 3> value{}, slope{};

  /// What nodal values from entry `first` on give there, and its derivative by arc length.
  [[nodiscard]] Vec3 interpolate(const std::vector<Vec3>& nodal, Index first) const { return sum(value, nodal, first); }
  [[nodiscard]] Vec3 derivative(const std::vector<Vec3>& nodal, Index first) const { return sum(slope, nodal, first); }

 private:
  [[nodiscard]] Vec3 sum(const std::array<double, 3>& weight, const std::vector<Vec3>& nodal, Index first) const {
    Vec3 x = Vec3::Zero();
    for (int i = 0; i < n_nodes; ++i) x += weight[i] * nodal[first + i];
    return x;
  }
};

/// At arc length s, for `n_nodes` nodes (2 or 3) at the arc lengths `node`, all different.
[[nodiscard]] inline LagrangeShape lagrange_shape(const double* node, double s, int n_nodes = 3) {
  LagrangeShape shape{.n_nodes = n_nodes};
  for (int i = 0; i < n_nodes; ++i) {
    double scale = 1, product = 1, derivative = 0;
    for (int j = 0; j < n_nodes; ++j) {
      if (j == i) continue;
      scale /= node[i] - node[j];
      derivative = derivative * (s - node[j]) + product;
      product *= s - node[j];
    }
    shape.value[i] = scale * product;
    shape.slope[i] = scale * derivative;
  }
  return shape;
}

}  // namespace trame::micro
