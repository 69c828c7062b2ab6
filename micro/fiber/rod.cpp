#include "micro/fiber/rod.h"

#include <algorithm>
#include <numbers>

#include "micro/fiber/collapse.h"

namespace trame::micro {

namespace {

struct QuadraturePoint {
  double t, weight;  // on [−1, 1], weights summing to 1
};
constexpr std::array<QuadraturePoint, 3> lobatto = {{{-1, 1.0 / 6}, {0, 4.0 / 6}, {1, 1.0 / 6}}};
constexpr double gauss = 0.57735026918962576451;  // 1/√3
constexpr std::array<QuadraturePoint, 2> gauss_points = {{{-gauss, 0.5}, {gauss, 0.5}}};

Vec3 combine(const std::array<double, 4>& c, const Vec3* q) {
  return c[0] * q[0] + c[1] * q[1] + c[2] * q[2] + c[3] * q[3];
}

}  // namespace

Rods::Rods(const FiberField& field, const std::vector<Material>& materials) : field_(field) {
  for (Index f = 0; f < field.mesh().n_fibers(); ++f) {
    const double r = field.mesh().radius[f], area = std::numbers::pi * r * r;
    axial_stiffness_.push_back(materials[f].young_modulus_axial * area);
    bending_stiffness_.push_back(materials[f].young_modulus_axial * area * r * r / 4);
  }
}

void Rods::add_sparsity(Pattern::Builder& builder) const {
  for (Index f = 0; f < field_.mesh().n_fibers(); ++f) {
    if (field_.model(f) != FiberModel::rod) continue;
    for (Index e = 0; e < field_.mesh().n_elements(f); ++e)
      builder.add_clique(std::array{field_.element_node(f, e), field_.element_node(f, e) + 1});
  }
}

double Rods::energy(const State& state) const {
  double sum = 0;
  for (Index f = 0; f < field_.mesh().n_fibers(); ++f) {
    if (field_.model(f) != FiberModel::rod) continue;
    const double h = field_.element_length(f);
    for (Index e = 0; e < field_.mesh().n_elements(f); ++e) {
      const Vec3* q = state.q.data() + field_.layout().first_vector(field_.element_node(f, e));
      for (const auto& p : lobatto) {
        const double strain = 0.5 * (combine(hermite_shape_derivative(p.t, h), q).squaredNorm() - 1);
        sum += 0.5 * h * p.weight * axial_stiffness_[f] * strain * strain;
      }
      for (const auto& p : gauss_points)
        sum += 0.5 * h * p.weight * bending_stiffness_[f] *
               combine(hermite_shape_second_derivative(p.t, h), q).squaredNorm();
    }
  }
  return sum;
}

std::string Rods::inadmissibility(const State& start, const State& state) const {
  for (Index f = 0; f < field_.mesh().n_fibers(); ++f) {
    if (field_.model(f) != FiberModel::rod) continue;
    const double h = field_.element_length(f);
    for (Index e = 0; e < field_.mesh().n_elements(f); ++e) {
      const Index first = field_.layout().first_vector(field_.element_node(f, e));
      for (const auto& p : lobatto) {
        const auto c = hermite_shape_derivative(p.t, h);
        const Vec3 tangent = combine(c, state.q.data() + first);
        const double strain = 0.5 * (tangent.squaredNorm() - 1);
        // A rod has no section to tell inside from outside: a tangent that turns over in one step stands for it.
        const bool turned_over = tangent.dot(combine(c, start.q.data() + first)) <= 0;
        if (turned_over || strain <= softening_strain)
          return collapse_text(field_, f, h * (e + 0.5 * (1 + p.t)), strain, turned_over);
      }
    }
  }
  return {};
}

void Rods::add(const State& state, Assembler& assembler) const {
  for (Index f = 0; f < field_.mesh().n_fibers(); ++f) {
    if (field_.model(f) != FiberModel::rod) continue;
    if (!assembler.touches(field_.element_node(f, 0), field_.last_node(f))) continue;
    for (Index e = 0; e < field_.mesh().n_elements(f); ++e) {
      const Index first = field_.element_node(f, e), v = field_.layout().first_vector(first);
      if (!assembler.touches(first, first + 1)) continue;
      const Vec3* last_step = assembler.last_step() ? assembler.last_step() + v : nullptr;
      add_element(state.q.data() + v, last_step, f, first, assembler);
    }
  }
}

void Rods::add_element(const Vec3* q, const Vec3* last_step, Index fiber, Index first_node,
                       Assembler& assembler) const {
  const double h = field_.element_length(fiber);
  std::array<Vec3, 4> force;
  force.fill(Vec3::Zero());
  Eigen::Matrix<double, 12, 12> k = Eigen::Matrix<double, 12, 12>::Zero();
  // w (c cᵀ) ⊗ M added to K, for M = scalar·I + factor·d dᵀ.
  const auto add_tangent = [&](const std::array<double, 4>& c, double scalar, double factor, const Vec3& d) {
    const Mat3 m = scalar * Mat3::Identity() + factor * d * d.transpose();
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j <= i; ++j) k.block<3, 3>(3 * i, 3 * j) += c[i] * c[j] * m;
  };
  for (const auto& p : lobatto) {
    const auto c = hermite_shape_derivative(p.t, h);
    const Vec3 d = combine(c, q);
    const double w = h * p.weight * axial_stiffness_[fiber], strain = 0.5 * (d.squaredNorm() - 1);
    const double expected = last_step ? strain - 0.5 * combine(c, last_step).squaredNorm() : strain;
    const double of_force = assembler.expects_forces() ? expected : strain;
    for (int i = 0; i < 4; ++i) force[i] += w * of_force * c[i] * d;
    const bool project = assembler.tangent() == Assembler::Tangent::projected;
    if (assembler.wants_tangent()) add_tangent(c, w * (project ? std::max(expected, 0.0) : expected), w, d);
  }
  for (const auto& p : gauss_points) {
    const auto c = hermite_shape_second_derivative(p.t, h);
    const Vec3 d = combine(c, q);
    const double w = h * p.weight * bending_stiffness_[fiber];
    for (int i = 0; i < 4; ++i) force[i] += w * c[i] * d;
    if (assembler.wants_tangent()) add_tangent(c, w, 0, d);
  }
  for (int i = 0; i < 4; ++i) assembler.add_force(first_node + i / 2, i % 2, force[i]);
  if (!assembler.wants_tangent()) return;
  k.triangularView<Eigen::StrictlyUpper>() = k.transpose();
  for (int a = 0; a < 2; ++a)
    for (int c = 0; c <= a; ++c) {
      if (!assembler.owns(first_node + c)) continue;
      const auto block = assembler.block(first_node + a, first_node + c);
      for (int col = 0; col < 6; ++col)
        for (int row = 0; row < 6; ++row) block.data[col * block.stride + row] += k(6 * a + row, 6 * c + col);
    }
}

}  // namespace trame::micro
