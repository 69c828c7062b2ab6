#include "micro/contact/contact_element.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace trame::micro {

Friction friction(const StickSlip& stick_slip, const Vec3& relative_position) {
  Friction f;
  if (stick_slip.tangential_stiffness <= 0) return f;
  const double k = stick_slip.tangential_stiffness, limit = stick_slip.slip_limit;
  const Vec3 trial = stick_slip.traction_start + k * stick_slip.tangential(relative_position - stick_slip.x_start);
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

namespace {

/// The linear form of a section vector at a foot: the shape functions of the centre line of an enriched beam.
Vec3 section_vector(const FiberPoint& shape, int v, const Layout& layout, const State& state) {
  const Vec3* q = state.q.data() + layout.first_vector(shape.first_node);
  Vec3 g = Vec3::Zero();
  for (int a = 0; a < shape.n_nodes; ++a) g += shape.weight[a][0] * q[3 * a + v];
  return g;
}

/// Support of a section in direction `outward`; returns R |w|.
double measure_section(const FiberField& field, const State& state, const Foot& foot, double radius,
                       const Vec3& outward, Gap::Section& section) {
  section = {};
  if (field.model(foot.fiber) != FiberModel::enriched) return 0;
  const auto forms = field.curve_forms(foot.fiber, foot.element, foot.s);
  const Vec3 g1 = section_vector(forms.r, 1, field.layout(), state),
             g2 = section_vector(forms.r, 2, field.layout(), state);
  const Vec2 w(outward.dot(g1), outward.dot(g2));
  const double size = w.norm();
  if (size < 1e-6) return 0;  // a section seen edge on has no outermost particle
  section.w = w / size;
  section.curvature = radius / size;
  section.outermost = radius * (section.w[0] * g1 + section.w[1] * g2);
  section.beside = -section.w[1] * g1 + section.w[0] * g2;
  return radius * size;
}

}  // namespace

void measure(const FiberField& field, const State& state, ContactElement& e) {
  Gap& g = e.measured;
  const Vec3& c = e.pair.chord.c;
  const double distance = c.norm();
  // Axes nearer than 5 % of a radius give no reliable direction: the pair keeps the one that it had.
  const bool reliable = distance > 0.025 * (e.radius_a + e.radius_b);
  g.normal = reliable ? Vec3(c / distance) : e.has_side ? e.side : distance > 0 ? Vec3(c / distance) : Vec3::UnitZ();
  // A direction that turned over since the last increment means that the axes passed through each other: push back.
  if (reliable && e.has_side && g.normal.dot(e.side) < -0.5) g.normal = -g.normal;
  g.inverse_distance = reliable ? 1 / g.normal.dot(c) : 0;
  g.value = g.normal.dot(c) - e.offset - measure_section(field, state, e.pair.chord.a, e.radius_a, g.normal, g.a) -
            measure_section(field, state, e.pair.chord.b, e.radius_b, -g.normal, g.b);
  e.normal = g.normal;
  e.s_a = e.pair.chord.a.s;
  e.s_b = e.pair.chord.b.s;
}

void follow(const FiberField& field, const State& state, ContactElement& e) {
  follow(field, state, e.pair);
  measure(field, state, e);
}

void place_particles(const FiberField& field, ContactElement& e) {
  const auto particle = [&](const Foot& foot, double radius, const Gap::Section& section) {
    FiberPoint p = field.curve_forms(foot.fiber, foot.element, foot.s).r;
    if (p.n_vectors == 3)
      for (int a = 0; a < p.n_nodes; ++a)
        for (int v = 0; v < 2; ++v) p.weight[a][v + 1] = p.weight[a][0] * radius * section.w[v];
    return p;
  };
  e.a = particle(e.pair.chord.a, e.radius_a, e.measured.a);
  e.b = particle(e.pair.chord.b, e.radius_b, e.measured.b);
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

bool touches(const FiberPoint& a, const FiberPoint& b, const Assembler& assembler) {
  return assembler.touches(a.first_node, a.first_node + a.n_nodes - 1) ||
         assembler.touches(b.first_node, b.first_node + b.n_nodes - 1);
}

/// How the feet slide: the forms B_e = δ(∂d/∂e), d = n·c, and A = ∂²d/∂e∂e' along their free directions e, so that the
/// feet move by −A⁻¹ B.
struct Sliding {
  int n = 0;
  std::array<Vec3, 2> along;  // ∂c/∂e
  std::array<LocalForms::Form, 2> b;
  Eigen::Matrix2d inverse = Eigen::Matrix2d::Zero();  // of A

  /// form += direction·δc, of the chord between feet that slide.
  void add_chord(LocalForms::Form& form, const Vec3& direction, const LocalForms& local) const {
    local.add_position(form, 1, direction);
    local.add_position(form, 0, -direction);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) form -= direction.dot(along[i]) * inverse(i, j) * b[j];
  }
};

Sliding sliding(const ContactElement& e, const LocalForms& local) {
  Sliding s;
  const Gap& g = e.measured;
  const Chord& chord = e.pair.chord;
  if (g.inverse_distance == 0) return s;
  Eigen::Matrix2d a = Eigen::Matrix2d::Identity();
  const auto across = [&](const Vec3& v) -> Vec3 { return v - g.normal * g.normal.dot(v); };
  for (int i = 0; i < chord.n_free; ++i) {
    const Vec2& f = chord.free[i];
    s.along[i] = f[1] * chord.at_b.tangent - f[0] * chord.at_a.tangent;
    s.b[i] = local.zero();
    const Vec3 turn = g.inverse_distance * across(s.along[i]);
    local.add_position(s.b[i], 1, turn);
    local.add_position(s.b[i], 0, -turn);
    if (f[0] != 0) local.add_tangent(s.b[i], 0, -f[0] * g.normal);
    if (f[1] != 0) local.add_tangent(s.b[i], 1, f[1] * g.normal);
    for (int j = 0; j <= i; ++j)
      a(i, j) = a(j, i) = s.along[j].dot(turn) + g.normal.dot(f[1] * chord.free[j][1] * chord.at_b.curvature -
                                                              f[0] * chord.free[j][0] * chord.at_a.curvature);
  }
  // A valley that is level to round-off holds no foot.
  if (std::abs(a.determinant()) < 1e-12) return s;
  s.n = chord.n_free;
  s.inverse = a.inverse();
  return s;
}

}  // namespace

void add_contact_element(const FiberField& field, const ContactElement& e, double p_reg, Assembler& assembler) {
  const LocalForms local(field, e.pair.chord.a, e.pair.chord.b);
  if (!local.touches(assembler)) return;
  const double f = e.force(p_reg);
  if (f <= 0) return;
  const Gap& g = e.measured;
  const Vec3 &n = g.normal, x = g.a.outermost - g.b.outermost;
  const Sliding slide = sliding(e, local);

  // δg = n·δc − x·δn − R_a n·(w_a δg_a) + R_b n·(w_b δg_b),  δn = P δc/(n·c). Left out: that the feet slide to sections
  // of another size. It is of the order of a section's strain per radius, and jumps where elements join.
  LocalForms::Form gradient = local.zero();
  const Vec3 m = g.force_direction();
  local.add_position(gradient, 1, m);
  local.add_position(gradient, 0, -m);
  local.add_section(gradient, 0, e.radius_a * g.a.w, -n);
  local.add_section(gradient, 1, e.radius_b * g.b.w, n);
  local.scatter_force(-f * gradient, assembler);
  if (!assembler.wants_tangent()) return;

  LocalForms::Matrix k = LocalForms::Matrix::Zero(local.size(), local.size());
  const auto add_square = [&](const LocalForms::Form& form, double factor) {
    k.template selfadjointView<Eigen::Lower>().rankUpdate(form, factor);
  };
  add_square(gradient, e.stiffness(p_reg));
  // −f δ²g. First what is positive: the outline's curvature, which keeps sections from spinning under pressure.
  const bool exact = assembler.tangent() == Assembler::Tangent::exact && g.inverse_distance != 0;
  const auto add_outline = [&](int side, const Gap::Section& section) {
    if (section.curvature == 0) return;
    LocalForms::Form turn = local.zero();
    local.add_section(turn, side, Vec2(-section.w[1], section.w[0]), n);
    if (exact) {
      slide.add_chord(turn, g.inverse_distance * (section.beside - n * n.dot(section.beside)), local);
    }
    add_square(turn, f * section.curvature);
  };
  add_outline(0, g.a);
  add_outline(1, g.b);
  if (exact) {
    // The normal turns with the chord, which the feet follow. Of the distance itself that takes from the curvature,
    // below.
    const Vec3 e1 = n.unitOrthogonal(), e2 = n.cross(e1);
    const double by_outlines = x.dot(n) * g.inverse_distance * g.inverse_distance;
    for (const Vec3& across : {e1, e2}) {
      LocalForms::Form chord = local.zero(), sliding_chord = local.zero(), sections = local.zero();
      local.add_position(chord, 1, across);
      local.add_position(chord, 0, -across);
      slide.add_chord(sliding_chord, across, local);
      local.add_section(sections, 0, e.radius_a * g.a.w, across);
      local.add_section(sections, 1, e.radius_b * g.b.w, -across);
      add_square(chord, -f * g.inverse_distance);
      add_square(sliding_chord, -f * by_outlines);
      k.template selfadjointView<Eigen::Lower>().rankUpdate(sliding_chord, sections, f * g.inverse_distance);
    }
    for (int i = 0; i < slide.n; ++i) {
      add_square(slide.b[i], f * slide.inverse(i, i));
      for (int j = 0; j < i; ++j)
        k.template selfadjointView<Eigen::Lower>().rankUpdate(slide.b[i], slide.b[j], f * slide.inverse(i, j));
    }
  }
  local.scatter_tangent(k, assembler);
}

void add_friction(const ContactElement& e, const StickSlip& stick_slip, const Layout& layout, const State& state,
                  Assembler& assembler) {
  if (stick_slip.tangential_stiffness <= 0 || !touches(e.a, e.b, assembler)) return;
  const Friction t = friction(stick_slip, e.relative_position(layout, state));
  const LinearForm form{{&e.a, &e.b}, {-1, 1}};
  add_force(form, t.force, assembler);
  if (!assembler.wants_tangent()) return;
  const Mat3 nn = stick_slip.normal * stick_slip.normal.transpose();
  add_tangent(form,
              t.stiffness_across * (Mat3::Identity() - nn) +
                  (t.stiffness_along - t.stiffness_across) * t.direction * t.direction.transpose(),
              assembler);
}

}  // namespace trame::micro
