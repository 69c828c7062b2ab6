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

FiberField::FiberField(const FiberMesh& mesh, std::vector<FiberModel> models, Layout& layout,
                       std::array<Index, 2> period_nodes)
    : mesh_(&mesh), layout_(&layout), period_nodes_(period_nodes), models_(std::move(models)) {
  for (Index f = 0; f < mesh.n_fibers(); ++f) {
    first_system_node_.push_back(layout.n_nodes());
    element_length_.push_back(mesh.length(f) / mesh.n_elements(f));
    const bool enriched = models_[f] == FiberModel::enriched, comes_back = mesh.period(f) >= 0;
    assert(!comes_back || mesh.n_elements(f) > 1);
    const Index n_nodes = (enriched ? mesh.n_nodes(f) : mesh.n_elements(f) + 1) - (comes_back ? 1 : 0);
    for (Index i = 0; i < n_nodes; ++i) layout.add_node(enriched ? 3 : 2);
  }
  first_system_node_.push_back(layout.n_nodes());
}

ElementNodes FiberField::element(Index fiber, Index e) const {
  const bool enriched = models_[fiber] == FiberModel::enriched;
  ElementNodes nodes{.n_nodes = enriched ? 3 : 2, .n_vectors = enriched ? 3 : 2};
  for (int a = 0; a < nodes.n_nodes; ++a) nodes.node[a] = element_node(fiber, e) + a;
  if (const int period = mesh_->period(fiber); period >= 0 && e == mesh_->n_elements(fiber) - 1) {
    nodes.node[nodes.n_nodes - 1] = first_system_node_[fiber];
    nodes.period_node = period_nodes_[period];
  }
  return nodes;
}

namespace {

/// n / d and what remains, rounded towards −∞.
std::pair<Index, Index> floor_division(Index n, Index d) {
  const Index quotient = n / d - (n % d < 0 ? 1 : 0);
  return {quotient, n - quotient * d};
}

}  // namespace

Index FiberField::wrapped_node(Index fiber, Index node) const {
  const Index n = first_system_node_[fiber + 1] - first_system_node_[fiber];
  return first_system_node_[fiber] + (mesh_->period(fiber) < 0 ? node : floor_division(node, n).second);
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

FiberField::Stretch FiberField::stretch(Index fiber, double s) const {
  const double at = s / node_spacing(fiber);
  const Index k = mesh_->period(fiber) < 0 ? std::clamp(static_cast<Index>(at), Index{0}, n_stretches(fiber) - 1)
                                           : static_cast<Index>(std::floor(at));
  return {k, at - k};
}

std::pair<Index, Index> FiberField::nodes_at(Index fiber, double s) const {
  const Index k = stretch(fiber, s).number;
  if (models_[fiber] != FiberModel::enriched) return {k, k + 1};
  if (mesh_->period(fiber) >= 0) return {k - 1, k + 2};
  const Index last = n_stretches(fiber), first = std::clamp(k - 1, Index{0}, std::max(last - 3, Index{0}));
  return {first, std::min(first + 3, last)};
}

CurveShape FiberField::shape(const Foot& foot) const {
  const Index fiber = foot.fiber;
  const int period = mesh_->period(fiber);
  const bool enriched = models_[fiber] == FiberModel::enriched;
  const double spacing = node_spacing(fiber);
  const auto [k, x] = stretch(fiber, foot.s);
  const auto [first, last] = nodes_at(fiber, foot.s);
  CurveShape shape;
  Slots& slots = shape.slots;
  slots.n_vectors = enriched ? 3 : 2;
  slots.n_nodes = slots.n_slots = static_cast<int>(last - first + 1);
  for (int a = 0; a < slots.n_nodes; ++a) slots.node[a] = wrapped_node(fiber, first + a);
  if (enriched) {
    if (period >= 0)  // no end is near
      smooth_weights(1, 4, x, spacing, 0, shape);
    else
      smooth_weights(k, n_stretches(fiber) + 1, x, spacing, first, shape);
    const Index element = floor_division(k, 2).first;
    const auto of_element = quadratic_shape(x + static_cast<double>(k - 2 * element) - 1);
    for (int a = 0; a < 3; ++a) shape.section[2 * element + a - first] = of_element[a];
  } else {
    const double t = 2 * x - 1;
    const auto r = hermite_shape(t, spacing), d = hermite_shape_derivative(t, spacing),
               c = hermite_shape_second_derivative(t, spacing);
    for (int a = 0; a < 2; ++a) {
      shape.r[a] = {r[2 * a], r[2 * a + 1]};
      shape.tangent[a] = {d[2 * a], d[2 * a + 1]};
      shape.curvature[a] = {c[2 * a], c[2 * a + 1]};
    }
  }
  for (int which = 0; which < 2; ++which) {
    // A node that is met again is a period farther. Positions have weights that add up to 1, derivatives to 0.
    double r = foot.image[which], tangent = 0, curvature = 0;
    if (which == period) {
      const Index n_own = n_stretches(fiber), whole = floor_division(first, n_own).first;
      r += whole;
      for (int a = 0; a < slots.n_nodes; ++a) {
        const auto more = static_cast<double>(floor_division(first + a, n_own).first - whole);
        r += more * shape.r[a][0];
        tangent += more * shape.tangent[a][0];
        curvature += more * shape.curvature[a][0];
      }
    }
    if (r == 0 && tangent == 0 && curvature == 0) continue;
    const int slot = slots.n_slots++;
    slots.node[slot] = period_nodes_[which];
    shape.r[slot] = {r, 0};
    shape.tangent[slot] = {tangent, 0};
    shape.curvature[slot] = {curvature, 0};
  }
  return shape;
}

CurveJet FiberField::curve(const State& state, const CurveShape& shape) const {
  const Slots& slots = shape.slots;
  const bool enriched = slots.n_vectors == 3;
  const auto sum = [&](const CurveShape::Weights& w) {
    Vec3 x = Vec3::Zero();
    for (int a = 0; a < slots.n_slots; ++a) {
      const Vec3* q = state.q.data() + layout_->first_vector(slots.node[a]);
      x += w[a][0] * q[0];
      if (!enriched && a < slots.n_nodes) x += w[a][1] * q[1];
    }
    return x;
  };
  return {sum(shape.r), sum(shape.tangent), sum(shape.curvature)};
}

namespace {

/// Of the section vectors at the nodes of a place, with a weight for each node.
template <typename Weight>
std::array<Vec3, 2> sum_sections(const Layout& layout, const State& state, const Slots& slots, Weight&& weight) {
  std::array<Vec3, 2> g{Vec3::Zero(), Vec3::Zero()};
  for (int a = 0; a < slots.n_nodes; ++a)
    for (int v = 0; v < 2; ++v) g[v] += weight(a) * state.q[layout.first_vector(slots.node[a]) + v + 1];
  return g;
}

}  // namespace

std::array<Vec3, 2> FiberField::section(const State& state, const CurveShape& shape) const {
  assert(shape.slots.n_vectors == 3);
  return sum_sections(*layout_, state, shape.slots, [&](int a) { return shape.section[a]; });
}

std::array<Vec3, 2> FiberField::section_slope(const State& state, const CurveShape& shape) const {
  assert(shape.slots.n_vectors == 3);
  return sum_sections(*layout_, state, shape.slots, [&](int a) { return shape.tangent[a][0]; });
}

std::array<Vec3, 2> FiberField::section_curvature(const State& state, const CurveShape& shape) const {
  assert(shape.slots.n_vectors == 3);
  return sum_sections(*layout_, state, shape.slots, [&](int a) { return shape.curvature[a][0]; });
}

std::string FiberField::describe(Index fiber, double s) const {
  return fmt::format("fiber {} of yarn {} at {:.0f} % of its length", fiber,
                     mesh_->yarns[mesh_->yarn_of_fiber[fiber]].name, 100 * s / mesh_->length(fiber));
}

FiberPoint FiberField::particle(const Foot& foot, const Vec2& xi) const {
  const CurveShape at = shape(foot);
  FiberPoint p{at.slots, {}};
  for (int a = 0; a < at.slots.n_slots; ++a)
    p.weight[a] = at.slots.n_vectors == 3 ? std::array{at.r[a][0], at.section[a] * xi[0], at.section[a] * xi[1]}
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
    const bool enriched = models_[f] == FiberModel::enriched, comes_back = mesh_->period(f) >= 0;
    Vec3* q = state.q.data() + layout_->first_vector(first_system_node_[f]);
    const Index first = mesh_->first_node[f], last = mesh_->first_node[f + 1] - 1;
    for (Index i = first; i <= last - (comes_back ? 1 : 0); i += enriched ? 1 : 2) {
      *q++ = configuration.r[i];
      *q++ = enriched ? configuration.g1[i] : rod_tangent(i);
      if (enriched) *q++ = configuration.g2[i];
    }
    if (comes_back)
      state.q[layout_->first_vector(period_nodes_[mesh_->period(f)])] = configuration.r[last] - configuration.r[first];
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
    const Index first = mesh_->first_node[f], n = mesh_->n_nodes(f);
    const bool comes_back = mesh_->period(f) >= 0;
    const Vec3* q = state.q.data() + layout_->first_vector(first_system_node_[f]);
    for (Index i = first; i < first + n - (comes_back ? 1 : 0); ++i) {
      if (models_[f] == FiberModel::enriched) {
        const Vec3* node = q + 3 * (i - first);
        configuration.r[i] = node[0];
        configuration.g1[i] = node[1];
        configuration.g2[i] = node[2];
        if (!comes_back) configuration.tangent[i] = node_tangent(q, i - first, n, element_length_[f]);
      } else {
        const CurveJet at = curve(state, f, mesh_->arc_length[i]);
        configuration.r[i] = at.r;
        carry_section(std::exchange(configuration.tangent[i], at.tangent), at.tangent, configuration.g1[i],
                      configuration.g2[i]);
      }
    }
    if (!comes_back) continue;
    const Index last = first + n - 1;
    configuration.r[last] = configuration.r[first] + period(state, mesh_->period(f));
    configuration.g1[last] = configuration.g1[first];
    configuration.g2[last] = configuration.g2[first];
    if (models_[f] == FiberModel::enriched) set_tangents(state, f, configuration);
    configuration.tangent[last] = configuration.tangent[first];
  }
}

void FiberField::set_tangents(const State& state, Index fiber, FiberConfiguration& configuration) const {
  const double h = element_length_[fiber];
  const Index n = mesh_->n_elements(fiber);
  const Vec3 a = period(state, mesh_->period(fiber));
  ElementNodes::Buffer buffer;
  for (Index e = 0; e < n; ++e) {
    // The element before, then this one.
    std::array<Vec3, 15> q;
    for (const Index which : {(e + n - 1) % n, e}) {
      const Vec3* vectors = element(fiber, which).gather(*layout_, state.q.data(), buffer);
      std::copy(vectors, vectors + 9, q.begin() + (which == e ? 6 : 0));
      if (which > e)
        for (int i = 0; i < 6; i += 3) q[i] -= a;
    }
    const Index node = mesh_->first_node[fiber] + 2 * e;
    configuration.tangent[node] = node_tangent(q.data(), 2, 5, h);
    configuration.tangent[node + 1] = node_tangent(q.data(), 3, 5, h);
  }
}

}  // namespace trame::micro
