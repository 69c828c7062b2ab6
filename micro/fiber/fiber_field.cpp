#include "micro/fiber/fiber_field.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

namespace trame::micro {

std::array<double, 3> quadratic_shape(double t) { return {0.5 * t * (t - 1), 1 - t * t, 0.5 * t * (t + 1)}; }
std::array<double, 3> quadratic_shape_derivative(double t) { return {t - 0.5, -2 * t, t + 0.5}; }

std::array<double, 4> hermite_shape(double t, double h) {
  return {(2 - 3 * t + t * t * t) / 4, h * (1 - t - t * t + t * t * t) / 8, (2 + 3 * t - t * t * t) / 4,
          h * (-1 - t + t * t + t * t * t) / 8};
}
std::array<double, 4> hermite_shape_derivative(double t, double h) {
  return {(-3 + 3 * t * t) / (2 * h), (-1 - 2 * t + 3 * t * t) / 4, (3 - 3 * t * t) / (2 * h),
          (-1 + 2 * t + 3 * t * t) / 4};
}
std::array<double, 4> hermite_shape_second_derivative(double t, double h) {
  return {6 * t / (h * h), (-1 + 3 * t) / h, -6 * t / (h * h), (1 + 3 * t) / h};
}

FiberField::FiberField(const FiberMesh& mesh, std::vector<FiberModel> models, Layout& layout)
    : mesh_(&mesh), layout_(&layout), models_(std::move(models)) {
  for (Index f = 0; f < mesh.n_fibers(); ++f) {
    first_system_node_.push_back(layout.n_nodes());
    element_length_.push_back(mesh.length(f) / mesh.n_elements(f));
    const bool enriched = models_[f] == FiberModel::enriched;
    const Index n_nodes = enriched ? mesh.n_nodes(f) : mesh.n_elements(f) + 1;
    for (Index i = 0; i < n_nodes; ++i) layout.add_node(enriched ? 3 : 2);
  }
  first_system_node_.push_back(layout.n_nodes());
}

FiberField::Local FiberField::locate(Index fiber, double s) const {
  const double h = element_length_[fiber];
  const Index e = std::clamp(static_cast<Index>(s / h), Index{0}, mesh_->n_elements(fiber) - 1);
  return {e, 2 * (s / h - e) - 1};
}

CurvePointAndTangent FiberField::curve(const State& state, Index fiber, double s) const {
  const auto [e, t] = locate(fiber, s);
  const double h = element_length_[fiber];
  const Vec3* q = state.q.data() + layout_->first_vector(element_node(fiber, e));
  if (models_[fiber] == FiberModel::enriched) {
    const auto n = quadratic_shape(t), d = quadratic_shape_derivative(t);
    return {n[0] * q[0] + n[1] * q[3] + n[2] * q[6], (2 / h) * (d[0] * q[0] + d[1] * q[3] + d[2] * q[6])};
  }
  const auto n = hermite_shape(t, h), d = hermite_shape_derivative(t, h);
  return {n[0] * q[0] + n[1] * q[1] + n[2] * q[2] + n[3] * q[3], d[0] * q[0] + d[1] * q[1] + d[2] * q[2] + d[3] * q[3]};
}

CurveJet FiberField::jet(const State& state, Index fiber, Index element, double s) const {
  const double h = element_length_[fiber], t = 2 * (s / h - element) - 1;
  const Vec3* q = state.q.data() + layout_->first_vector(element_node(fiber, element));
  if (models_[fiber] == FiberModel::enriched) {
    const auto n = quadratic_shape(t), d = quadratic_shape_derivative(t);
    return {n[0] * q[0] + n[1] * q[3] + n[2] * q[6], (2 / h) * (d[0] * q[0] + d[1] * q[3] + d[2] * q[6]),
            (4 / (h * h)) * (q[0] - 2 * q[3] + q[6])};
  }
  const auto n = hermite_shape(t, h), d = hermite_shape_derivative(t, h), c = hermite_shape_second_derivative(t, h);
  const auto sum = [q](const std::array<double, 4>& w) -> Vec3 {
    return w[0] * q[0] + w[1] * q[1] + w[2] * q[2] + w[3] * q[3];
  };
  return {sum(n), sum(d), sum(c)};
}

FiberField::CurveForms FiberField::curve_forms(Index fiber, Index element, double s) const {
  const double h = element_length_[fiber], t = 2 * (s / h - element) - 1;
  CurveForms forms;
  FiberPoint &r = forms.r, &tangent = forms.tangent;
  r.first_node = tangent.first_node = element_node(fiber, element);
  if (models_[fiber] == FiberModel::enriched) {
    r.n_nodes = r.n_vectors = tangent.n_nodes = tangent.n_vectors = 3;
    const auto n = quadratic_shape(t), d = quadratic_shape_derivative(t);
    for (int a = 0; a < 3; ++a) {
      r.weight[a] = {n[a], 0, 0};
      tangent.weight[a] = {2 / h * d[a], 0, 0};
    }
  } else {
    r.n_nodes = r.n_vectors = tangent.n_nodes = tangent.n_vectors = 2;
    const auto n = hermite_shape(t, h), d = hermite_shape_derivative(t, h);
    for (int a = 0; a < 2; ++a) {
      r.weight[a] = {n[2 * a], n[2 * a + 1], 0};
      tangent.weight[a] = {d[2 * a], d[2 * a + 1], 0};
    }
  }
  return forms;
}

std::array<Vec3, 2> FiberField::section(const State& state, Index fiber, double s) const {
  assert(models_[fiber] == FiberModel::enriched);
  const auto [e, t] = locate(fiber, s);
  const Vec3* q = state.q.data() + layout_->first_vector(element_node(fiber, e));
  const auto n = quadratic_shape(t);
  return {n[0] * q[1] + n[1] * q[4] + n[2] * q[7], n[0] * q[2] + n[1] * q[5] + n[2] * q[8]};
}

std::string FiberField::describe(Index fiber, double s) const {
  return fmt::format("fiber {} of yarn {} at {:.0f} % of its length", fiber,
                     mesh_->yarns[mesh_->yarn_of_fiber[fiber]].name, 100 * s / mesh_->length(fiber));
}

FiberPoint FiberField::particle(Index fiber, double s, const Vec2& xi) const {
  const auto [e, t] = locate(fiber, s);
  FiberPoint p;
  p.first_node = element_node(fiber, e);
  if (models_[fiber] == FiberModel::enriched) {
    p.n_nodes = p.n_vectors = 3;
    const auto n = quadratic_shape(t);
    for (int a = 0; a < 3; ++a) p.weight[a] = {n[a], n[a] * xi[0], n[a] * xi[1]};
  } else {
    p.n_nodes = p.n_vectors = 2;
    const auto n = hermite_shape(t, element_length_[fiber]);
    p.weight[0] = {n[0], n[1], 0};
    p.weight[1] = {n[2], n[3], 0};
  }
  return p;
}

void FiberField::read_configuration(const FiberConfiguration& configuration, State& state) const {
  // Sections stand normal to a rod. Those of an enriched beam are right at its nodes, where ties hold them; the
  // direction of dr/ds is not: it is off by κ'h²/12, which stiff ties would answer.
  const auto rod_tangent = [&](Index i) -> Vec3 {
    return configuration.tangent[i].norm() * configuration.g1[i].cross(configuration.g2[i]).normalized();
  };
  for (Index f = 0; f < mesh_->n_fibers(); ++f) {
    const bool enriched = models_[f] == FiberModel::enriched;
    Vec3* q = state.q.data() + layout_->first_vector(first_system_node_[f]);
    for (Index i = mesh_->first_node[f]; i < mesh_->first_node[f + 1]; i += enriched ? 1 : 2) {
      *q++ = configuration.r[i];
      *q++ = enriched ? configuration.g1[i] : rod_tangent(i);
      if (enriched) *q++ = configuration.g2[i];
    }
  }
}

namespace {

/// Turns section vectors by the smallest rotation that takes direction `from` to direction `to`. What the ends of a rod
/// are tied to keeps its tangent there, and so its sections: carried along the fiber instead, they would come out
/// turned at the other end.
void carry_section(const Vec3& from, const Vec3& to, Vec3& g1, Vec3& g2) {
  const Vec3 t = to.normalized();
  const Vec3 g = Eigen::Quaterniond::FromTwoVectors(from, to) * g1;
  g1 = (g - g.dot(t) * t).normalized();
  g2 = t.cross(g1);
}

/// dr/ds of an enriched element of length h whose node vectors begin at q.
Vec3 derivative(const Vec3* q, double t, double h) {
  const auto d = quadratic_shape_derivative(t);
  return (2 / h) * (d[0] * q[0] + d[1] * q[3] + d[2] * q[6]);
}

/// Tangent at node i of an enriched fiber whose node vectors begin at q. The length of the derivative is right to third
/// order at the Gauss points only, and there the elastic energy takes it: at the ends of an element it is off by
/// κ²h²/12, a strain that a rod, which takes it there, would have to work off. So the length is that at the nearest
/// Gauss points.
Vec3 node_tangent(const Vec3* q, Index i, Index n_nodes, double h) {
  constexpr double gauss_point = 0.5773502691896257;  // 1/√3
  Vec3 direction = Vec3::Zero();
  double stretch = 0;
  int n = 0;
  for (Index e = std::max(i - 1, 0) / 2; e <= std::min(i, n_nodes - 2) / 2; ++e) {
    const double t = static_cast<double>(i - 2 * e - 1);  // −1, 0, 1
    direction += derivative(q + 6 * e, t, h).normalized();
    for (const double at : {-gauss_point, gauss_point})
      if (at * t >= 0) {
        stretch += derivative(q + 6 * e, at, h).norm();
        ++n;
      }
  }
  return stretch / n * direction.normalized();
}

}  // namespace

void FiberField::write_configuration(const State& state, FiberConfiguration& configuration) const {
  configuration.resize(mesh_->n_nodes());
  for (Index f = 0; f < mesh_->n_fibers(); ++f) {
    const Index first = mesh_->first_node[f];
    const Vec3* q = state.q.data() + layout_->first_vector(first_system_node_[f]);
    for (Index i = first; i < mesh_->first_node[f + 1]; ++i) {
      if (models_[f] == FiberModel::enriched) {
        const Vec3* node = q + 3 * (i - first);
        configuration.r[i] = node[0];
        configuration.g1[i] = node[1];
        configuration.g2[i] = node[2];
        configuration.tangent[i] = node_tangent(q, i - first, mesh_->n_nodes(f), element_length_[f]);
      } else {
        const auto [r, tangent] = curve(state, f, mesh_->arc_length[i]);
        configuration.r[i] = r;
        carry_section(std::exchange(configuration.tangent[i], tangent), tangent, configuration.g1[i],
                      configuration.g2[i]);
      }
    }
  }
}

}  // namespace trame::micro
