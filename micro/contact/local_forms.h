#pragma once
/// \file
/// Forces and tangents of a pair of feet on two fibers, whatever acts between them.

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "micro/contact/closest_points.h"

namespace trame::micro {

/// Elements of two fibers that the sparsity covers: those of the feet, and the next ones where a foot is near
/// a joint. Empty at first.
struct CoveredElements {
  std::array<std::pair<Index, Index>, 2> range{{{0, -1}, {0, -1}}};

  /// Makes them cover the elements of the feet. Returns whether they did not.
  bool cover(const FiberField& field, const Foot& a, const Foot& b);
  void add_sparsity(const FiberField& field, Index fiber_a, Index fiber_b, Pattern::Builder& builder) const;
};

/// Forms of the unknowns of the two elements that a contact couples, as dense vectors: node after node of a, then of b.
class LocalForms {
 public:
  static constexpr int max_size = 54;
  using Form = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_size, 1>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_size, max_size>;

  LocalForms(const FiberField& field, const Foot& a, const Foot& b)
      : curves_{field.curve_forms(a.fiber, a.element, a.s), field.curve_forms(b.fiber, b.element, b.s)},
        begin_{0, 3 * curves_[0].r.n_nodes * curves_[0].r.n_vectors},
        size_(begin_[1] + 3 * curves_[1].r.n_nodes * curves_[1].r.n_vectors) {}

  [[nodiscard]] bool touches(const Assembler& assembler) const {
    return std::any_of(curves_.begin(), curves_.end(), [&](const FiberField::CurveForms& curve) {
      return assembler.touches(curve.r.first_node, curve.r.first_node + curve.r.n_nodes - 1);
    });
  }
  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] Form zero() const { return Form::Zero(size_); }
  /// form += direction·δr, or ·δr', of side 0 (a) or 1 (b).
  void add_position(Form& form, int side, const Vec3& direction) const { add(form, side, curves_[side].r, direction); }
  void add_tangent(Form& form, int side, const Vec3& direction) const {
    add(form, side, curves_[side].tangent, direction);
  }
  /// form += direction·(v₁ δg₁ + v₂ δg₂); nothing for rods.
  void add_section(Form& form, int side, const Vec2& v, const Vec3& direction) const {
    const FiberPoint& shape = curves_[side].r;
    if (shape.n_vectors < 3) return;
    for (int n = 0; n < shape.n_nodes; ++n)
      for (int w = 0; w < 2; ++w)
        form.segment<3>(begin_[side] + 9 * n + 3 * (w + 1)) += shape.weight[n][0] * v[w] * direction;
  }

  void scatter_force(const Form& force, Assembler& assembler) const {
    for_each_node([&](Index node, int at, int n_vectors) {
      if (!assembler.owns(node)) return;
      for (int v = 0; v < n_vectors; ++v) assembler.add_force(node, v, force.segment<3>(at + 3 * v));
    });
  }
  /// Adds a symmetric matrix of which the lower triangle is given.
  void scatter_tangent(const Matrix& k, Assembler& assembler) const {
    for_each_node([&](Index j, int at_j, int n_j) {
      if (!assembler.owns(j)) return;
      for_each_node([&](Index i, int at_i, int n_i) {
        if (i < j) return;
        const auto block = assembler.block(i, j);
        for (int c = 0; c < 3 * n_j; ++c)
          for (int r = 0; r < 3 * n_i; ++r)
            block.data[static_cast<std::size_t>(c) * block.stride + r] +=
                at_i + r >= at_j + c ? k(at_i + r, at_j + c) : k(at_j + c, at_i + r);
      });
    });
  }

 private:
  template <typename Visit>
  void for_each_node(Visit&& visit) const {
    for (int side = 0; side < 2; ++side) {
      const FiberPoint& p = curves_[side].r;
      for (int n = 0; n < p.n_nodes; ++n) visit(p.first_node + n, begin_[side] + 3 * n * p.n_vectors, p.n_vectors);
    }
  }
  void add(Form& form, int side, const FiberPoint& p, const Vec3& direction) const {
    for (int n = 0; n < p.n_nodes; ++n)
      for (int v = 0; v < p.n_vectors; ++v)
        if (p.weight[n][v] != 0)
          form.segment<3>(begin_[side] + 3 * (n * p.n_vectors + v)) += p.weight[n][v] * direction;
  }

  std::array<FiberField::CurveForms, 2> curves_;
  std::array<int, 2> begin_;
  int size_;
};

}  // namespace trame::micro
