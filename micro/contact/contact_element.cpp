#include "micro/contact/contact_element.h"

namespace trame::micro {

Friction friction(const ContactElement& element, const StickSlip& stick_slip, const Vec3& relative_position) {
  Friction f;
  if (stick_slip.tangential_stiffness <= 0) return f;
  const double k = stick_slip.tangential_stiffness, limit = stick_slip.slip_limit;
  const Vec3 trial = stick_slip.traction_start + k * element.tangential(relative_position - stick_slip.x_start);
  const double size = trial.norm();
  f.slides = size > limit;
  f.direction = size > 0 ? Vec3(trial / size) : Vec3::Zero();
  if (!f.slides) {
    f.force = trial;
    f.stiffness_along = f.stiffness_across = k;
    f.energy = 0.5 * size * size / k;
  } else {
    f.force = limit * f.direction;
    f.stiffness_across = k * limit / size;
    f.energy = limit * (size - 0.5 * limit) / k;
    f.dissipated = limit * (size - limit) / k;
  }
  return f;
}

Touch touch(const FiberPoint& particle, double radius, const Vec3& outward, const Layout& layout, const State& state) {
  Touch t{particle, {}, 0};
  if (particle.n_vectors < 3 || radius == 0) return t;
  Vec2 w = Vec2::Zero();
  const Vec3* q = state.q.data() + layout.first_vector(particle.first_node);
  for (int a = 0; a < particle.n_nodes; ++a)
    for (int v = 0; v < 2; ++v) w[v] += particle.weight[a][0] * outward.dot(q[3 * a + 1 + v]);
  const double size = w.norm();
  if (size == 0) return t;  // a section seen edge on has no outermost particle
  const Vec2 xi = radius / size * w;
  t.turn = particle;
  for (int a = 0; a < particle.n_nodes; ++a) {
    const double n = particle.weight[a][0];
    t.point.weight[a] = {n, n * xi[0], n * xi[1]};
    t.turn.weight[a] = {0, -n * xi[1], n * xi[0]};
  }
  t.curvature = 1 / (radius * size);
  return t;
}

double ContactElement::gap(const Layout& layout, const State& state) const {
  const Vec3 x_a = touch(a, radius_a, normal, layout, state).point.evaluate(layout, state);
  const Vec3 x_b = touch(b, radius_b, -normal, layout, state).point.evaluate(layout, state);
  return normal.dot(x_b - x_a) - offset;
}

namespace {

/// Two signed linear forms of the unknowns, sign_a·a + sign_b·b.
struct LinearForm {
  std::array<const FiberPoint*, 2> point;
  std::array<double, 2> sign;
};

void add_force(const LinearForm& form, const Vec3& force, Assembler& assembler) {
  for (int side = 0; side < 2; ++side) {
    const FiberPoint& p = *form.point[side];
    for (int n = 0; n < p.n_nodes; ++n)
      for (int v = 0; v < p.n_vectors; ++v)
        assembler.add_force(p.first_node + n, v, form.sign[side] * p.weight[n][v] * force);
  }
}

/// The block of node `row` of p and node `column` of q += factor wᵢ wⱼ M.
void add_block(const FiberPoint& p, int row, const FiberPoint& q, int column, double factor, const Mat3& m,
               Assembler& assembler) {
  const Index i = p.first_node + row, j = q.first_node + column;
  if (i < j || !assembler.owns(j)) return;
  const auto block = assembler.block(i, j);
  for (int w = 0; w < q.n_vectors; ++w)
    for (int v = 0; v < p.n_vectors; ++v) {
      const double weight = factor * q.weight[column][w] * p.weight[row][v];
      for (int c = 0; c < 3; ++c) {
        double* values = block.data + static_cast<std::size_t>(3 * w + c) * block.stride + 3 * v;
        for (int r = 0; r < 3; ++r) values[r] += weight * m(r, c);
      }
    }
}

/// K += (form formᵀ) ⊗ M.
void add_tangent(const LinearForm& form, const Mat3& m, Assembler& assembler) {
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 2; ++column)
      for (int i = 0; i < form.point[row]->n_nodes; ++i)
        for (int j = 0; j < form.point[column]->n_nodes; ++j)
          add_block(*form.point[row], i, *form.point[column], j, form.sign[row] * form.sign[column], m, assembler);
}

void add_tangent(const FiberPoint& point, const Mat3& m, Assembler& assembler) {
  for (int i = 0; i < point.n_nodes; ++i)
    for (int j = 0; j < point.n_nodes; ++j) add_block(point, i, point, j, 1, m, assembler);
}

bool touches(const ContactElement& e, const Assembler& assembler) {
  return assembler.touches(e.a.first_node, e.a.first_node + e.a.n_nodes - 1) ||
         assembler.touches(e.b.first_node, e.b.first_node + e.b.n_nodes - 1);
}

}  // namespace

void add_contact_element(const ContactElement& e, const Layout& layout, const State& state, double p_reg,
                         Assembler& assembler) {
  if (!touches(e, assembler)) return;
  const Touch a = touch(e.a, e.radius_a, e.normal, layout, state);
  const Touch b = touch(e.b, e.radius_b, -e.normal, layout, state);
  const double gap = e.normal.dot(b.point.evaluate(layout, state) - a.point.evaluate(layout, state)) - e.offset;
  const double f = penalty_force(gap, e.penalty, p_reg);
  if (f <= 0) return;
  const LinearForm form{{&a.point, &b.point}, {-1, 1}};
  add_force(form, -f * e.normal, assembler);
  if (!assembler.wants_tangent()) return;
  const Mat3 nn = e.normal * e.normal.transpose();
  add_tangent(form, penalty_stiffness(gap, e.penalty, p_reg) * nn, assembler);
  // −f ∇²g: the outline's curvature, which keeps sections from spinning under pressure.
  if (a.curvature > 0) add_tangent(a.turn, f * a.curvature * nn, assembler);
  if (b.curvature > 0) add_tangent(b.turn, f * b.curvature * nn, assembler);
}

void add_friction(const ContactElement& e, const StickSlip& stick_slip, const Layout& layout, const State& state,
                  Assembler& assembler) {
  if (stick_slip.tangential_stiffness <= 0 || !touches(e, assembler)) return;
  const Friction t = friction(e, stick_slip, e.relative_position(layout, state));
  const LinearForm form{{&e.a, &e.b}, {-1, 1}};
  add_force(form, t.force, assembler);
  if (!assembler.wants_tangent()) return;
  const Mat3 nn = e.normal * e.normal.transpose();
  add_tangent(form,
              t.stiffness_across * (Mat3::Identity() - nn) +
                  (t.stiffness_along - t.stiffness_across) * t.direction * t.direction.transpose(),
              assembler);
}

void announce_contact_element(const ContactElement& e, Pattern::Builder& builder) {
  std::array<Index, 6> nodes{};
  int n = 0;
  for (int i = 0; i < e.a.n_nodes; ++i) nodes[n++] = e.a.first_node + i;
  for (int i = 0; i < e.b.n_nodes; ++i) nodes[n++] = e.b.first_node + i;
  builder.add_clique({nodes.data(), static_cast<std::size_t>(n)});
}

}  // namespace trame::micro
