#include "micro/contact/contact_element.h"

namespace trame::micro {

Friction friction(const ContactElement& element, const Vec3& relative_position) {
  Friction f;
  if (element.tangential_stiffness <= 0) return f;
  const double k = element.tangential_stiffness;
  const Vec3 trial = element.traction_start + k * element.tangential(relative_position - element.x_start);
  const double size = trial.norm();
  f.slides = size > element.slip_limit;
  f.direction = size > 0 ? Vec3(trial / size) : Vec3::Zero();
  if (!f.slides) {
    f.force = trial;
    f.stiffness_along = f.stiffness_across = k;
    f.energy = 0.5 * size * size / k;
  } else {
    f.force = element.slip_limit * f.direction;
    f.stiffness_across = k * element.slip_limit / size;
    f.energy = element.slip_limit * (size - 0.5 * element.slip_limit) / k;
  }
  return f;
}

namespace {

struct Side {
  const FiberPoint* point;
  double sign;
};

/// K += wᵢ wⱼ M for two node ranges; only blocks of owned columns.
void add_block(const Side& row_side, int row_node, const Side& column_side, int column_node, const Mat3& m,
               Assembler& assembler) {
  const FiberPoint &p = *row_side.point, &q = *column_side.point;
  const Index i = p.first_node + row_node, j = q.first_node + column_node;
  if (i < j || !assembler.owns(j)) return;
  const auto block = assembler.block(i, j);
  const double sign = row_side.sign * column_side.sign;
  for (int w = 0; w < q.n_vectors; ++w) {
    const double weight_w = sign * q.weight[column_node][w];
    for (int v = 0; v < p.n_vectors; ++v) {
      const double weight = weight_w * p.weight[row_node][v];
      for (int c = 0; c < 3; ++c) {
        double* column = block.data + static_cast<std::size_t>(3 * w + c) * block.stride + 3 * v;
        for (int r = 0; r < 3; ++r) column[r] += weight * m(r, c);
      }
    }
  }
}

}  // namespace

void add_contact_element(const ContactElement& e, const Layout& layout, const State& state, double p_reg,
                         Assembler& assembler) {
  if (!assembler.touches(e.a.first_node, e.a.first_node + e.a.n_nodes - 1) &&
      !assembler.touches(e.b.first_node, e.b.first_node + e.b.n_nodes - 1))
    return;
  const Vec3 x = e.relative_position(layout, state);
  const double gap = e.gap(x);
  const Friction f = friction(e, x);
  if (gap >= 0 && f.stiffness_across == 0) return;

  const Vec3 force = -penalty_force(gap, e.penalty, p_reg) * e.normal + f.force;
  const std::array<Side, 2> sides = {{{&e.a, -1.0}, {&e.b, 1.0}}};
  for (const Side& side : sides)
    for (int n = 0; n < side.point->n_nodes; ++n)
      for (int v = 0; v < side.point->n_vectors; ++v)
        assembler.add_force(side.point->first_node + n, v, side.sign * side.point->weight[n][v] * force);
  if (!assembler.wants_tangent()) return;

  const Mat3 nn = e.normal * e.normal.transpose();
  const Mat3 m = penalty_stiffness(gap, e.penalty, p_reg) * nn + f.stiffness_across * (Mat3::Identity() - nn) +
                 (f.stiffness_along - f.stiffness_across) * f.direction * f.direction.transpose();
  for (const Side& row : sides)
    for (const Side& column : sides)
      for (int i = 0; i < row.point->n_nodes; ++i)
        for (int j = 0; j < column.point->n_nodes; ++j) add_block(row, i, column, j, m, assembler);
}

void announce_contact_element(const ContactElement& e, Pattern::Builder& builder) {
  std::array<Index, 6> nodes{};
  int n = 0;
  for (int i = 0; i < e.a.n_nodes; ++i) nodes[n++] = e.a.first_node + i;
  for (int i = 0; i < e.b.n_nodes; ++i) nodes[n++] = e.b.first_node + i;
  builder.add_clique({nodes.data(), static_cast<std::size_t>(n)});
}

}  // namespace trame::micro
