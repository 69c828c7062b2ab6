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

namespace {

/// Weights of the stretch from node k on, x = 0…1 along it, of a curve through n nodes a distance apart: those of the
/// nodes k − 1 to k + 2, of which ends have three.
void smooth_weights(Index k, Index n, double x, double spacing, Index first, CurveShape& shape) {
  const auto set = [&](Index node, double r, double slope, double second) {
    shape.r[node - first][0] = r;
    shape.tangent[node - first][0] = slope / spacing;
    shape.curvature[node - first][0] = second / (spacing * spacing);
  };
  if (k == 0 || k == n - 2) {
    const Index middle = k == 0 ? 1 : k;
    const double y = k == 0 ? x - 1 : x;  // from the middle
    set(middle - 1, 0.5 * y * (y - 1), y - 0.5, 1);
    set(middle, 1 - y * y, -2 * y, -2);
    set(middle + 1, 0.5 * y * (y + 1), y + 0.5, 1);
    return;
  }
  set(k - 1, 0.5 * x * (-1 + x * (2 - x)), -0.5 + x * (2 - 1.5 * x), 2 - 3 * x);
  set(k, 1 + 0.5 * x * x * (-5 + 3 * x), x * (-5 + 4.5 * x), -5 + 9 * x);
  set(k + 1, 0.5 * x * (1 + x * (4 - 3 * x)), 0.5 + x * (4 - 4.5 * x), 4 - 9 * x);
  set(k + 2, 0.5 * x * x * (x - 1), x * (-1 + 1.5 * x), -1 + 3 * x);
}

}  // namespace

CurveShape FiberField::shape(Index fiber, double s) const {
  const bool enriched = models_[fiber] == FiberModel::enriched;
  const Index n = first_system_node_[fiber + 1] - first_system_node_[fiber];
  const double spacing = mesh_->length(fiber) / (n - 1);
  const Index k = std::clamp(static_cast<Index>(s / spacing), Index{0}, n - 2);
  const double x = s / spacing - k;
  CurveShape shape;
  if (enriched) {
    const Index first = std::clamp(k - 1, Index{0}, std::max(n - 4, Index{0}));
    shape.first_node = first_system_node_[fiber] + first;
    shape.n_nodes = static_cast<int>(std::min(n, Index{4}));
    shape.n_vectors = 3;
    smooth_weights(k, n, x, spacing, first, shape);
    const Index element = k / 2;
    const auto of_element = quadratic_shape(x + static_cast<double>(k - 2 * element) - 1);
    for (int a = 0; a < 3; ++a) shape.section[2 * element + a - first] = of_element[a];
    return shape;
  }
  shape.first_node = first_system_node_[fiber] + k;
  shape.n_nodes = shape.n_vectors = 2;
  const double t = 2 * x - 1;
  const auto r = hermite_shape(t, spacing), d = hermite_shape_derivative(t, spacing),
             c = hermite_shape_second_derivative(t, spacing);
  for (int a = 0; a < 2; ++a) {
    shape.r[a] = {r[2 * a], r[2 * a + 1]};
    shape.tangent[a] = {d[2 * a], d[2 * a + 1]};
    shape.curvature[a] = {c[2 * a], c[2 * a + 1]};
  }
  return shape;
}

CurveJet FiberField::curve(const State& state, const CurveShape& shape) const {
  const Vec3* q = state.q.data() + layout_->first_vector(shape.first_node);
  const bool enriched = shape.n_vectors == 3;
  const auto sum = [&](const CurveShape::Weights& w) {
    Vec3 x = Vec3::Zero();
    for (int a = 0; a < shape.n_nodes; ++a) {
      x += w[a][0] * q[a * shape.n_vectors];
      if (!enriched) x += w[a][1] * q[a * shape.n_vectors + 1];
    }
    return x;
  };
  return {sum(shape.r), sum(shape.tangent), sum(shape.curvature)};
}

namespace {

/// Of the section vectors at nodes, which begin at q, with a weight for each node.
template <typename Weight>
std::array<Vec3, 2> sum_sections(const Vec3* q, int n_nodes, Weight&& weight) {
  std::array<Vec3, 2> g{Vec3::Zero(), Vec3::Zero()};
  for (int a = 0; a < n_nodes; ++a)
    for (int v = 0; v < 2; ++v) g[v] += weight(a) * q[3 * a + v + 1];
  return g;
}

}  // namespace

std::array<Vec3, 2> FiberField::section(const State& state, const CurveShape& shape) const {
  assert(shape.n_vectors == 3);
  return sum_sections(state.q.data() + layout_->first_vector(shape.first_node), shape.n_nodes,
                      [&](int a) { return shape.section[a]; });
}

std::array<Vec3, 2> FiberField::section_slope(const State& state, const CurveShape& shape) const {
  assert(shape.n_vectors == 3);
  return sum_sections(state.q.data() + layout_->first_vector(shape.first_node), shape.n_nodes,
                      [&](int a) { return shape.tangent[a][0]; });
}

std::string FiberField::describe(Index fiber, double s) const {
  return fmt::format("fiber {} of yarn {} at {:.0f} % of its length", fiber,
                     mesh_->yarns[mesh_->yarn_of_fiber[fiber]].name, 100 * s / mesh_->length(fiber));
}

FiberPoint FiberField::particle(Index fiber, double s, const Vec2& xi) const {
  const CurveShape at = shape(fiber, s);
  FiberPoint p{at.first_node, at.n_nodes, at.n_vectors, {}};
  for (int a = 0; a < p.n_nodes; ++a)
    p.weight[a] = p.n_vectors == 3 ? std::array{at.r[a][0], at.section[a] * xi[0], at.section[a] * xi[1]}
                                   : std::array{at.r[a][0], at.r[a][1], 0.0};
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
        const CurveJet at = curve(state, f, mesh_->arc_length[i]);
        configuration.r[i] = at.r;
        carry_section(std::exchange(configuration.tangent[i], at.tangent), at.tangent, configuration.g1[i],
                      configuration.g2[i]);
      }
    }
  }
}

}  // namespace trame::micro
