#include "micro/fiber/rod.h"

#include <algorithm>
#include <numbers>

#include "micro/fiber/axial_law.h"

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
    for (Index e = 0; e < field_.mesh().n_elements(f); ++e) field_.element(f, e).add_clique(builder);
  }
}

double Rods::energy(const State& state) const {
  double sum = 0;
  for (Index f = 0; f < field_.mesh().n_fibers(); ++f) {
    if (field_.model(f) != FiberModel::rod) continue;
    const double h = field_.element_length(f);
    ElementNodes::Buffer buffer;
    for (Index e = 0; e < field_.mesh().n_elements(f); ++e) {
      const Vec3* q = field_.element(f, e).gather(field_.layout(), state.q.data(), buffer);
      for (const auto& p : lobatto) {
        const double strain = 0.5 * (combine(hermite_shape_derivative(p.t, h), q).squaredNorm() - 1);
        sum += h * p.weight * axial_stiffness_[f] * axial_law(strain).energy;
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
    ElementNodes::Buffer buffer, start_buffer;
    for (Index e = 0; e < field_.mesh().n_elements(f); ++e) {
      const ElementNodes nodes = field_.element(f, e);
      const Vec3* q = nodes.gather(field_.layout(), state.q.data(), buffer);
      const Vec3* q_start = nodes.gather(field_.layout(), start.q.data(), start_buffer);
      for (const auto& p : lobatto) {
        const auto c = hermite_shape_derivative(p.t, h);
        const Vec3 tangent = combine(c, q);
        const double strain = 0.5 * (tangent.squaredNorm() - 1);
        // A rod has no section to tell inside from outside: a tangent that turns over in one step stands for it.
        const bool turned_over = tangent.dot(combine(c, q_start)) <= 0;
        if (turned_over || stretch_of(strain) <= least_stretch)
          return collapse_text(field_, f, h * (e + 0.5 * (1 + p.t)), strain, turned_over);
      }
    }
  }
  return {};
}

std::string Rods::doubt(const State& state) const {
  MostPressed most;
  for (Index f = 0; f < field_.mesh().n_fibers(); ++f) {
    if (field_.model(f) != FiberModel::rod) continue;
    const double h = field_.element_length(f);
    ElementNodes::Buffer buffer;
    for (Index e = 0; e < field_.mesh().n_elements(f); ++e) {
      const Vec3* q = field_.element(f, e).gather(field_.layout(), state.q.data(), buffer);
      for (const auto& p : lobatto)
        most.see(f, h * (e + 0.5 * (1 + p.t)), 0.5 * (combine(hermite_shape_derivative(p.t, h), q).squaredNorm() - 1));
    }
  }
  return most.text(field_);
}

void Rods::add(const State& state, Assembler& assembler) const {
  for (Index f = 0; f < field_.mesh().n_fibers(); ++f) {
    if (field_.model(f) != FiberModel::rod) continue;
    if (!field_.touches(f, assembler)) continue;
    ElementNodes::Buffer buffer, step_buffer;
    for (Index e = 0; e < field_.mesh().n_elements(f); ++e) {
      const ElementNodes nodes = field_.element(f, e);
      if (!nodes.touches(assembler)) continue;
      const Vec3* last_step =
          assembler.last_step() ? nodes.gather(field_.layout(), assembler.last_step(), step_buffer) : nullptr;
      add_element(nodes.gather(field_.layout(), state.q.data(), buffer), last_step, f, nodes, assembler);
    }
  }
}

void Rods::add_element(const Vec3* q, const Vec3* last_step, Index fiber, const ElementNodes& nodes,
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
    const AxialLaw law = axial_law(strain);
    const double expected =
        last_step ? law.stress - law.stiffness * 0.5 * combine(c, last_step).squaredNorm() : law.stress;
    const double of_force = assembler.expects_forces() ? expected : law.stress;
    for (int i = 0; i < 4; ++i) force[i] += w * of_force * c[i] * d;
    const bool project = assembler.tangent() == Assembler::Tangent::projected;
    if (assembler.wants_tangent())
      add_tangent(c, w * (project ? std::max(expected, 0.0) : expected), w * law.stiffness, d);
  }
  for (const auto& p : gauss_points) {
    const auto c = hermite_shape_second_derivative(p.t, h);
    const Vec3 d = combine(c, q);
    const double w = h * p.weight * bending_stiffness_[fiber];
    for (int i = 0; i < 4; ++i) force[i] += w * c[i] * d;
    if (assembler.wants_tangent()) add_tangent(c, w, 0, d);
  }
  for (int i = 0; i < 4; ++i) nodes.add_force(i / 2, i % 2, force[i], assembler);
  if (!assembler.wants_tangent()) return;
  k.triangularView<Eigen::StrictlyUpper>() = k.transpose();
  nodes.add_tangent(k, assembler);
}

}  // namespace trame::micro
