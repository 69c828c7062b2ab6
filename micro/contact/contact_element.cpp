#include "micro/contact/contact_element.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace trame::micro {

double slip_energy_at_start(const std::vector<StickSlip>& stick_slip) {
  double sum = 0;
  for (const StickSlip& s : stick_slip)
    if (s.tangential_stiffness > 0) sum += 0.5 * s.traction_start.squaredNorm() / s.tangential_stiffness;
  return sum;
}

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

Vec3 friction_by_limit(const StickSlip& stick_slip, const Vec3& relative_position) {
  const double k = stick_slip.tangential_stiffness, limit = stick_slip.slip_limit;
  constexpr double shortened = 1 - 1e-9;
  // The trial traction goes with the limit by its stiffness, and by what there was where the limit has shortened that.
  Vec3 trial = k / limit * stick_slip.tangential(relative_position - stick_slip.x_start);
  if (stick_slip.traction_start.norm() > shortened * limit) trial += stick_slip.traction_start / limit;
  const Friction f = friction(stick_slip, relative_position);
  if (!f.slides) return trial;
  return f.direction + f.stiffness_across / k * (trial - f.direction * f.direction.dot(trial));
}

namespace {

/// A section in direction `outward` at a foot.
struct SeenSection {
  double size = 0;   // R |w|
  double slope = 0;  // its derivative by arc length
  Gap::Section section;
};

SeenSection see_section(const FiberField& field, const State& state, const Foot& foot, double radius,
                        const Vec3& outward) {
  SeenSection seen;
  if (field.model(foot.fiber) != FiberModel::enriched) return seen;
  const CurveShape shape = field.shape(foot);
  const auto [g1, g2] = field.section(state, shape);
  const Vec2 w(outward.dot(g1), outward.dot(g2));
  const double size = w.norm();
  if (size < 1e-6) return seen;  // a section seen edge on has no outermost particle
  Gap::Section& section = seen.section;
  section.w = w / size;
  section.curvature = radius / size;
  section.outermost = radius * (section.w[0] * g1 + section.w[1] * g2);
  section.beside = -section.w[1] * g1 + section.w[0] * g2;
  const auto [slope1, slope2] = field.section_slope(state, shape);
  section.outermost_slope = radius * (section.w[0] * slope1 + section.w[1] * slope2);
  section.beside_slope = -section.w[1] * slope1 + section.w[0] * slope2;
  const auto [second1, second2] = field.section_curvature(state, shape);
  section.outermost_curvature = radius * (section.w[0] * second1 + section.w[1] * second2);
  seen.size = radius * size;
  seen.slope = outward.dot(section.outermost_slope);
  return seen;
}

/// ∂²g/∂e∂e' and the forms B_e, with all that goes with inclined sections. The slopes of sections are smoothed; how
/// sections turn as a foot moves along an element is not, which is all that is left out.
Gap::Sliding sliding(const Gap& g, const Proximity& pair) {
  Gap::Sliding s;
  const Chord& chord = pair.chord;
  if (g.inverse_distance == 0 || chord.n_free == 0) return s;
  Eigen::Matrix2d a = Eigen::Matrix2d::Identity();
  const Vec3 &n = g.normal, x = g.a.outermost - g.b.outermost, turned = g.inverse_distance * g.across(x);
  const double held_by = pair.point ? pair.hold.stiffness : 0, held = held_by * pair.hold.distance(chord);
  std::array<Vec3, 2> along, x_along;         // ∂c/∂e, ∂x/∂e
  std::array<double, 2> longer, longer_held;  // ∂(n·c)/∂e, ∂D/∂e
  for (int i = 0; i < chord.n_free; ++i) {
    const Vec2& f = chord.free[i];
    along[i] = f[1] * chord.at_b.tangent - f[0] * chord.at_a.tangent;
    x_along[i] = f[0] * g.a.outermost_slope - f[1] * g.b.outermost_slope;
    longer[i] = n.dot(along[i]);
    longer_held[i] = g.share * longer[i] + g.inverse_length * held * f.dot(pair.hold.along());
    s.normal[i] = g.inverse_distance * g.across(along[i]);
    s.spin[i] = {g.a.beside.dot(s.normal[i]) + f[0] * n.dot(g.a.beside_slope),
                 g.b.beside.dot(s.normal[i]) + f[1] * n.dot(g.b.beside_slope)};
    s.of_chord[i] = g.inverse_length * (along[i] - longer_held[i] * g.share * n) +
                    g.inverse_distance *
                        (x.dot(n) * s.normal[i] + longer[i] * turned + s.normal[i].dot(x) * n - g.across(x_along[i]));
    for (int j = 0; j <= i; ++j) {
      const Vec2& h = chord.free[j];
      const Vec3 bends = f[1] * h[1] * chord.at_b.curvature - f[0] * h[0] * chord.at_a.curvature,
                 x_bends = f[0] * h[0] * g.a.outermost_curvature - f[1] * h[1] * g.b.outermost_curvature;
      const double of_length = g.inverse_length * (along[i].dot(along[j]) - longer_held[i] * longer_held[j] +
                                                   held_by * f.dot(pair.hold.along()) * h.dot(pair.hold.along())),
                   of_normal = x.dot(n) * s.normal[i].dot(s.normal[j]) +
                               g.inverse_distance * (longer[i] * s.normal[j].dot(x) + longer[j] * s.normal[i].dot(x)),
                   of_sections = s.normal[i].dot(x_along[j]) + s.normal[j].dot(x_along[i]) + n.dot(x_bends) +
                                 g.a.curvature * s.spin[i][0] * s.spin[j][0] +
                                 g.b.curvature * s.spin[i][1] * s.spin[j][1];
      a(i, j) = a(j, i) = of_length + g.force_direction.dot(bends) + of_normal - of_sections;
    }
  }
  // A valley that is level to round-off holds no foot.
  const double steep = g.inverse_length * (chord.at_a.tangent.squaredNorm() + chord.at_b.tangent.squaredNorm());
  if (std::abs(a.determinant()) < 1e-12 * (chord.n_free == 2 ? steep * steep : steep)) return s;
  s.n = chord.n_free;
  s.inverse = a.inverse();
  return s;
}

/// All of the gap but how its feet slide.
void measure_at_feet(const FiberField& field, const State& state, ContactElement& e) {
  Gap& g = e.measured;
  const Vec3& c = e.pair.chord.c;
  const double distance = c.norm();
  // Axes nearer than 5 % of a radius give no reliable direction: the pair keeps the one that it had.
  const bool reliable = distance > 0.025 * (e.radius_a + e.radius_b);
  g.normal = reliable ? Vec3(c / distance) : e.has_side ? e.side : distance > 0 ? Vec3(c / distance) : Vec3::UnitZ();
  // A direction that has turned over means that the axes passed through each other: push back.
  if (reliable && e.has_side && g.normal.dot(e.side) < -0.5) g.normal = -g.normal;
  g.inverse_distance = reliable ? 1 / g.normal.dot(c) : 0;
  const SeenSection a = see_section(field, state, e.pair.chord.a, e.radius_a, g.normal),
                    b = see_section(field, state, e.pair.chord.b, e.radius_b, -g.normal);
  g.a = a.section;
  g.b = b.section;
  const double d = g.normal.dot(c), held = e.pair.hold.distance(e.pair.chord),
               length = std::copysign(std::hypot(d, std::sqrt(e.pair.hold.stiffness) * held), d);
  g.inverse_length = reliable ? 1 / length : 0;
  g.share = reliable ? d / length : 1;
  g.value = length - e.offset - a.size - b.size;
  const Vec3 turned = g.inverse_distance * g.across(g.a.outermost - g.b.outermost);
  g.force_direction = g.share * g.normal - turned;
  g.lean = Vec2::Zero();
  if (reliable)
    g.lean = length *
             Vec2(turned.dot(e.pair.chord.at_a.tangent) - a.slope, -turned.dot(e.pair.chord.at_b.tangent) - b.slope);
  e.normal = g.normal;
  e.s_a = e.pair.chord.a.s;
  e.s_b = e.pair.chord.b.s;
}

}  // namespace

void measure(const FiberField& field, const State& state, ContactElement& e) {
  measure_at_feet(field, state, e);
  e.measured.sliding = sliding(e.measured, e.pair);
}

void hold_in_valley(const FiberField& field, const State& state, ContactElement& e) {
  const Gap& g = e.measured;
  if (!e.pair.point || g.sliding.n < 2 || g.inverse_length <= 0) return;
  const double valley = along_valley(g.sliding.inverse.inverse(), e.pair.hold.sense),
               least = Hold::least_valley / (e.radius_a + e.radius_b);
  if (valley >= least) return;
  e.pair.hold.stiffness += (least - valley) / g.inverse_length;
  measure(field, state, e);
}

/// The feet go to where the gap is lowest by Newton's method on what leans on the chord, as sections tilt against it
/// when a foot moves. Steps that do not bring them nearer are halved.
void follow(const FiberField& field, const State& state, ContactElement& e) {
  constexpr int most_rounds = 20;
  constexpr double settled = 1e-9, worth_while = 0.9;
  Vec2 lean = e.pair.lean, more = Vec2::Zero();
  double least = std::numeric_limits<double>::infinity();
  for (int round = 0; round < most_rounds; ++round) {
    follow(field, state, e.pair);
    measure(field, state, e);
    const Gap& g = e.measured;
    const Chord& chord = e.pair.chord;
    Vec2 rest = Vec2::Zero();  // of what feet that are free feel, by free directions
    for (int i = 0; i < chord.n_free; ++i) rest[i] = chord.free[i].dot(g.lean - e.pair.lean);
    const double size = rest.norm();
    if (size <= settled * chord.c.norm()) return;
    if (!(size <= worth_while * least)) {  // too far
      more *= 0.5;
    } else {
      lean = e.pair.lean;
      least = size;
      Vec2 motion = Vec2::Zero();
      for (int i = 0; i < g.sliding.n; ++i)
        motion += chord.free[i] * g.inverse_length * g.sliding.inverse.row(i).dot(rest);
      const Vec2 along = e.pair.hold.along();
      more = chord.hessian() * motion + e.pair.hold.stiffness * along * along.dot(motion);
    }
    e.pair.lean = lean + more;
  }
  e.pair.lean = lean;
  follow(field, state, e.pair);
  measure(field, state, e);
}

void place_particles(const FiberField& field, ContactElement& e) {
  const Foot &a = e.pair.chord.a, &b = e.pair.chord.b;
  e.a = field.particle(a, e.radius_a * e.measured.a.w);
  e.b = field.particle(b, e.radius_b * e.measured.b.w);
}

namespace {

/// Two signed linear forms of the unknowns, sign_a·a + sign_b·b.
struct LinearForm {
  std::array<const FiberPoint*, 2> point;
  std::array<double, 2> sign;
};

/// From a to b, as friction sees them.
LinearForm relative_position(const ContactElement& e) { return {{&e.a, &e.b}, {-1, 1}}; }

/// Calls visit(node, vector, its coefficient).
template <typename Visit>
void for_each_coefficient(const LinearForm& form, Visit&& visit) {
  for (int side = 0; side < 2; ++side) {
    const FiberPoint& p = *form.point[side];
    for (int n = 0; n < p.slots.n_slots; ++n)
      for (int v = 0; v < p.slots.vectors(n); ++v) visit(p.slots.node[n], v, form.sign[side] * p.weight[n][v]);
  }
}

void add_force(const LinearForm& form, const Vec3& force, Assembler& assembler) {
  for_each_coefficient(
      form, [&](Index node, int v, double coefficient) { assembler.add_force(node, v, coefficient * force); });
}

/// The block of slot `row` of p and slot `column` of q += factor wᵢ wⱼ M.
void add_block(const FiberPoint& p, int row, const FiberPoint& q, int column, double factor, const Mat3& m,
               Assembler& assembler) {
  const Index i = p.slots.node[row], j = q.slots.node[column];
  if (i < j || !assembler.owns(j)) return;
  const auto block = assembler.block(i, j);
  for (int w = 0; w < q.slots.vectors(column); ++w)
    for (int v = 0; v < p.slots.vectors(row); ++v) {
      const double weight = factor * q.weight[column][w] * p.weight[row][v];
      if (weight == 0) continue;  // of a section that does not follow the node
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
      for (int i = 0; i < form.point[row]->slots.n_slots; ++i)
        for (int j = 0; j < form.point[column]->slots.n_slots; ++j)
          add_block(*form.point[row], i, *form.point[column], j, form.sign[row] * form.sign[column], m, assembler);
}

bool touches(const FiberPoint& a, const FiberPoint& b, const Assembler& assembler) {
  return a.slots.touches(assembler) || b.slots.touches(assembler);
}

/// δg = c·δc/(±D) − x·δn − R_a n·(w_a δg_a) + R_b n·(w_b δg_b),  δn = P δc/(n·c).
LocalForms::Form gap_gradient(const LocalForms& local, const ContactElement& e) {
  const Gap& g = e.measured;
  LocalForms::Form gradient = local.zero();
  LocalForms::add_chord(gradient, g.force_direction);
  local.add_section(gradient, 0, e.radius_a * g.a.w, -g.normal);
  local.add_section(gradient, 1, e.radius_b * g.b.w, g.normal);
  return gradient;
}

/// How a section turns about its centre against the normal: what moves the particle that is outermost along its
/// outline.
LocalForms::Form spin_form(const LocalForms& local, const Gap& g, int side) {
  const Gap::Section& section = side == 0 ? g.a : g.b;
  LocalForms::Form spin = local.zero();
  local.add_section(spin, side, Vec2(-section.w[1], section.w[0]), g.normal);
  LocalForms::add_chord(spin, g.inverse_distance * g.across(section.beside));
  return spin;
}

/// The forms B_e of how the feet slide.
std::array<LocalForms::Form, 2> sliding_forms(const ContactElement& e, const LocalForms& local,
                                              const std::array<LocalForms::Form, 2>& spin) {
  std::array<LocalForms::Form, 2> b{local.zero(), local.zero()};
  const Gap& g = e.measured;
  for (int i = 0; i < g.sliding.n; ++i) {
    const Vec2& f = e.pair.chord.free[i];
    LocalForms::add_chord(b[i], g.sliding.of_chord[i]);
    LocalForms::tangent(b[i], 0) = -f[0] * g.force_direction;
    LocalForms::tangent(b[i], 1) = f[1] * g.force_direction;
    local.add_section(b[i], 0, e.radius_a * g.a.w, -g.sliding.normal[i]);
    local.add_section(b[i], 1, e.radius_b * g.b.w, g.sliding.normal[i]);
    local.add_section_slope(b[i], 0, e.radius_a * g.a.w, -f[0] * g.normal);
    local.add_section_slope(b[i], 1, e.radius_b * g.b.w, f[1] * g.normal);
    b[i] -= g.a.curvature * g.sliding.spin[i][0] * spin[0] + g.b.curvature * g.sliding.spin[i][1] * spin[1];
  }
  return b;
}

}  // namespace

void add_contact_element(const FiberField& field, const ContactElement& e, double p_reg, Assembler& assembler) {
  const double f = e.force(p_reg);
  if (f <= 0) return;
  const LocalForms local(field, e.pair.chord.a, e.pair.chord.b);
  if (!local.touches(assembler)) return;
  const Gap& g = e.measured;
  const Vec3 &n = g.normal, x = g.a.outermost - g.b.outermost;

  const LocalForms::Form gradient = gap_gradient(local, e);
  local.scatter_force(-f * gradient, assembler);
  if (!assembler.wants_tangent()) return;

  LocalForms::Matrix k = local.zero_matrix();
  LocalForms::add_square(gradient, e.stiffness(p_reg), k);
  // −f δ²g. First what is positive: the outline's curvature, which keeps sections from spinning under pressure.
  const std::array<LocalForms::Form, 2> spin{spin_form(local, g, 0), spin_form(local, g, 1)};
  LocalForms::add_square(spin[0], f * g.a.curvature, k);
  LocalForms::add_square(spin[1], f * g.b.curvature, k);
  if (assembler.tangent() == Assembler::Tangent::exact && g.inverse_distance != 0) {
    // The normal turns with the chord.
    const Vec3 e1 = n.unitOrthogonal(), e2 = n.cross(e1);
    const double by_outlines = x.dot(n) * g.inverse_distance * g.inverse_distance;
    for (const Vec3& across : {e1, e2}) {
      LocalForms::Form chord = local.zero(), sections = local.zero();
      LocalForms::add_chord(chord, across);
      LocalForms::add_square(chord, -f * (g.inverse_length + by_outlines), k);
      if (by_outlines == 0) continue;  // rods
      local.add_section(sections, 0, e.radius_a * g.a.w, across);
      local.add_section(sections, 1, e.radius_b * g.b.w, -across);
      LocalForms::add_product(chord, sections, f * g.inverse_distance, k);
    }
    if (by_outlines != 0) {
      // Sections that stand inclined to the chord know how it grows, too.
      LocalForms::Form longer = local.zero(), turned = local.zero();
      LocalForms::add_chord(longer, n);
      LocalForms::add_chord(turned, g.inverse_distance * g.across(x));
      LocalForms::add_square(longer, -f * g.inverse_length * (1 - g.share * g.share), k);
      LocalForms::add_product(longer, turned, -f * g.inverse_distance, k);
    }
    // The feet slide: B A⁻¹ B off δ²g.
    const std::array<LocalForms::Form, 2> b = sliding_forms(e, local, spin);
    for (int i = 0; i < g.sliding.n; ++i) {
      LocalForms::add_square(b[i], f * g.sliding.inverse(i, i), k);
      for (int j = 0; j < i; ++j) LocalForms::add_product(b[i], b[j], f * g.sliding.inverse(i, j), k);
    }
  }
  local.scatter_tangent(k, assembler);
}

void add_friction_by_limit(const FiberField& field, const ContactElement& e, const StickSlip& stick_slip,
                           double friction_coefficient, double p_reg, const State& state, UnsymmetricTerms& terms) {
  if (stick_slip.tangential_stiffness <= 0) return;
  const Layout& layout = field.layout();
  const Vec3 by_limit = friction_by_limit(stick_slip, e.relative_position(layout, state));
  terms.begin_term();
  for_each_coefficient(relative_position(e), [&](Index node, int v, double coefficient) {
    terms.add_left(layout.first_vector(node) + v, coefficient * by_limit);
  });
  const LocalForms local(field, e.pair.chord.a, e.pair.chord.b);
  const double limit_by_gap = -friction_coefficient * e.stiffness(p_reg) * e.measured.force_direction.norm();
  local.for_each_coefficient(gap_gradient(local, e), [&](Index node, int v, const Vec3& coefficient) {
    terms.add_right(layout.first_vector(node) + v, limit_by_gap * coefficient);
  });
}

void add_friction(const ContactElement& e, const StickSlip& stick_slip, const Layout& layout, const State& state,
                  Assembler& assembler) {
  if (stick_slip.tangential_stiffness <= 0 || !touches(e.a, e.b, assembler)) return;
  const Friction t = friction(stick_slip, e.relative_position(layout, state));
  const LinearForm form = relative_position(e);
  add_force(form, t.force, assembler);
  if (!assembler.wants_tangent()) return;
  const Mat3 nn = stick_slip.normal * stick_slip.normal.transpose();
  add_tangent(form,
              t.stiffness_across * (Mat3::Identity() - nn) +
                  (t.stiffness_along - t.stiffness_across) * t.direction * t.direction.transpose(),
              assembler);
}

}  // namespace trame::micro
