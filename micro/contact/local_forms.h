#pragma once
/// \file
/// Forces and tangents of a pair of feet on two fibers, whatever acts between them.

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "micro/contact/closest_points.h"

namespace trame::micro {

/// Nodes of two fibers that the sparsity covers: those that the feet depend on, and the next ones where a foot
/// is near a node. Empty at first.
struct CoveredNodes {
  /// First and last, counted on where a fiber comes back to its start.
  std::array<std::pair<Index, Index>, 2> range{{{0, -1}, {0, -1}}};
  std::array<bool, 2> periods{};  ///< whether the period vectors are among them

  /// Makes them cover the feet. Returns whether they did not.
  bool cover(const FiberField& field, const Foot& a, const Foot& b);
  void add_sparsity(const FiberField& field, const Foot& a, const Foot& b, Pattern::Builder& builder) const;
};

/// Linear forms of what a contact depends on at its feet: for each side the position r, its derivative r', and the
/// section vectors g₁, g₂ of an enriched beam with their derivatives. Forms and matrices are dense and small; nodes
/// come in when they are scattered.
class LocalForms {
 public:
  static constexpr int max_size = 36;
  using Form = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_size, 1>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_size, max_size>;

  LocalForms(const FiberField& field, const Foot& a, const Foot& b)
      : shape_{field.shape(a), field.shape(b)},
        size_(shape_[0].slots.n_vectors == 3 || shape_[1].slots.n_vectors == 3 ? max_size : max_size / 3) {}

  [[nodiscard]] bool touches(const Assembler& assembler) const {
    return shape_[0].slots.touches(assembler) || shape_[1].slots.touches(assembler);
  }
  [[nodiscard]] Form zero() const { return Form::Zero(size_); }
  [[nodiscard]] Matrix zero_matrix() const { return Matrix::Zero(size_, size_); }

  /// Coefficients of δr and δr' of side 0 (a) or 1 (b).
  [[nodiscard]] static auto position(Form& form, int side) { return form.segment<3>(6 * side); }
  [[nodiscard]] static auto tangent(Form& form, int side) { return form.segment<3>(6 * side + 3); }
  /// form += direction·δc, c = r_b − r_a.
  static void add_chord(Form& form, const Vec3& direction) {
    position(form, 0) -= direction;
    position(form, 1) += direction;
  }
  /// form += direction·(v₁ δg₁ + v₂ δg₂); nothing for rods.
  void add_section(Form& form, int side, const Vec2& v, const Vec3& direction) const {
    if (shape_[side].slots.n_vectors < 3) return;
    for (int w = 0; w < 2; ++w) form.segment<3>(section_at(side, w)) += v[w] * direction;
  }
  /// form += direction·(v₁ δg₁' + v₂ δg₂'); nothing for rods.
  void add_section_slope(Form& form, int side, const Vec2& v, const Vec3& direction) const {
    if (shape_[side].slots.n_vectors < 3) return;
    for (int w = 0; w < 2; ++w) form.segment<3>(section_at(side, w) + 3) += v[w] * direction;
  }

  /// k += factor form formᵀ, and factor (p qᵀ + q pᵀ), in its lower triangle.
  static void add_square(const Form& form, double factor, Matrix& k) {
    for (int c = 0; c < k.cols(); ++c) k.col(c).tail(k.rows() - c) += factor * form[c] * form.tail(k.rows() - c);
  }
  static void add_product(const Form& p, const Form& q, double factor, Matrix& k) {
    for (int c = 0; c < k.cols(); ++c) {
      const Eigen::Index n = k.rows() - c;
      k.col(c).tail(n) += factor * q[c] * p.tail(n) + factor * p[c] * q.tail(n);
    }
  }

  /// Calls visit(node, vector, coefficient) for all vectors that a form depends on.
  template <typename Visit>
  void for_each_coefficient(const Form& form, Visit&& visit) const {
    for_each_node([&](Index node, int side, int n) {
      for (int v = 0; v < shape_[side].slots.vectors(n); ++v) {
        const Parts p = parts(side, n, v);
        visit(node, v, Vec3(p.weight * form.segment<3>(p.at) + p.weight_of_slope * form.segment<3>(p.at + 3)));
      }
    });
  }
  void scatter_force(const Form& force, Assembler& assembler) const;
  /// Adds a symmetric matrix of which the lower triangle is given.
  void scatter_tangent(Matrix& k, Assembler& assembler) const;

 private:
  /// Calls visit(node, side, its slot on that side).
  template <typename Visit>
  void for_each_node(Visit&& visit) const {
    for (int side = 0; side < 2; ++side)
      for (int n = 0; n < shape_[side].slots.n_slots; ++n) visit(shape_[side].slots.node[n], side, n);
  }
  [[nodiscard]] static int section_at(int side, int v) { return 12 + 12 * side + 6 * v; }
  /// Where a vector of a node stands in a form, followed by its slope, and its weights in both.
  struct Parts {
    int at;
    double weight, weight_of_slope;
  };
  [[nodiscard]] Parts parts(int side, int node, int vector) const {
    const CurveShape& s = shape_[side];
    if (s.slots.n_vectors == 3 && vector > 0)
      return {section_at(side, vector - 1), s.section[node], s.tangent[node][0]};
    return {6 * side, s.r[node][vector], s.tangent[node][vector]};
  }

  std::array<CurveShape, 2> shape_;
  int size_;
};

}  // namespace trame::micro
