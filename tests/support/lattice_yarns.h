#pragma once
/// \file
/// Straight yarns on a hexagonal lattice and states made of them, for tests of what reads states.

#include <cmath>
#include <string>

#include "micro/states/snapshot.h"
#include "tests/support/messages.h"

namespace trame::micro::test {

/// Yarns of n_rows × n_columns fibers along x, rows staggered by half a spacing, one yarn beside the other in y.
struct LatticeYarns {
  Index n_yarns = 1, n_rows = 3, n_columns = 4, n_elements = 5;
  double spacing = 1.0;  ///< between fibers
  double length = 10.0;
  double radius = 0.475;
  double axial_stiffness = 7.0;

  [[nodiscard]] Index n_nodes_per_fiber() const { return 2 * n_elements + 1; }
  [[nodiscard]] Index n_fibers_per_yarn() const { return n_rows * n_columns; }
  /// Area of the equilateral triangles between the fibers of one yarn.
  [[nodiscard]] double section_area() const {
    return 2.0 * (n_rows - 1) * (n_columns - 1) * std::sqrt(3.0) / 4.0 * spacing * spacing;
  }

  [[nodiscard]] FiberMesh mesh() const {
    FiberMesh mesh;
    for (Index y = 0; y < n_yarns; ++y) {
      const YarnFamily family = y % 2 == 0 ? YarnFamily::warp : YarnFamily::weft;
      mesh.yarns.push_back({(y % 2 == 0 ? "warp/" : "weft/") + std::to_string(y / 2 + 1), family,
                            y * n_fibers_per_yarn(), n_fibers_per_yarn()});
      for (Index f = 0; f < n_fibers_per_yarn(); ++f) {
        mesh.first_node.push_back(mesh.first_node.back() + n_nodes_per_fiber());
        mesh.radius.push_back(radius);
        mesh.axial_stiffness.push_back(axial_stiffness);
        mesh.yarn_of_fiber.push_back(y);
        for (Index n = 0; n < n_nodes_per_fiber(); ++n)
          mesh.arc_length.push_back(length * n / (n_nodes_per_fiber() - 1));
      }
    }
    return mesh;
  }

  [[nodiscard]] FiberConfiguration configuration() const {
    FiberConfiguration fibers;
    const FiberMesh mesh = this->mesh();
    for (Index y = 0; y < n_yarns; ++y)
      for (Index row = 0; row < n_rows; ++row)
        for (Index column = 0; column < n_columns; ++column)
          for (Index n = 0; n < n_nodes_per_fiber(); ++n) {
            const double across = y * (n_columns + 2) + column + 0.5 * (row % 2);
            fibers.r.emplace_back(length * n / (n_nodes_per_fiber() - 1), across * spacing,
                                  row * spacing * std::sqrt(3.0) / 2.0);
            fibers.g1.emplace_back(0, 1, 0);
            fibers.g2.emplace_back(0, 0, 1);
            fibers.tangent.emplace_back(1, 0, 0);
          }
    return fibers;
  }
};

/// The configuration moved by the affine map x ↦ F x, sections and tangents with it.
inline FiberConfiguration mapped(FiberConfiguration fibers, const Mat3& F) {
  for (auto* vectors : {&fibers.r, &fibers.g1, &fibers.g2, &fibers.tangent})
    for (Vec3& v : *vectors) v = F * v;
  return fibers;
}

using trame::test::input_error;

}  // namespace trame::micro::test
