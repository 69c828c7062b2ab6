#include "micro/contact/surface_contact.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace trame::micro {

namespace {

/// Linear forms of what a place depends on: centre line and section vectors of the fiber, position and rotation of the
/// body. Dense and small; nodes come in when they are scattered.
constexpr int at_center = 0, at_sections = 3, at_position = 9, at_rotation = 12, form_size = 15;
using Form = Eigen::Matrix<double, form_size, 1>;
using FormMatrix = Eigen::Matrix<double, form_size, form_size>;

/// A vector of the fiber by its derivative of a function: `derivative`·δv, with δv seen from the body.
struct Dependence {
  int at;
  Vec3 value;  ///< v; of the centre line, from the position of the body
  Vec3 derivative;
};
using Dependences = std::array<Dependence, 3>;

/// The form of a function of vectors seen from the body: Σ a·(δv − δθ × v), with δc − δp for δv of the centre line.
Form form_of(const Dependences& dependences) {
  Form form = Form::Zero();
  for (const Dependence& d : dependences) {
    form.segment<3>(d.at) += d.derivative;
    form.segment<3>(at_rotation) -= d.value.cross(d.derivative);
  }
  form.segment<3>(at_position) -= form.segment<3>(at_center);
  return form;
}

/// What second derivatives of the same function have besides, because the body turns:
///   Σ a·(−δθ × δv + ½ δθ × (δθ × v)).
void add_turning(const Dependences& dependences, double factor, FormMatrix& k) {
  const auto add = [&](int row, int column, const Mat3& m) {
    k.block<3, 3>(row, column) += factor * m;
    k.block<3, 3>(column, row) += factor * m.transpose();
  };
  for (const Dependence& d : dependences) {
    const Mat3 s = skew(d.derivative), outer = d.derivative * d.value.transpose();
    add(at_rotation, d.at, s);
    if (d.at == at_center) add(at_rotation, at_position, -s);
    k.block<3, 3>(at_rotation, at_rotation) +=
        factor * (0.5 * (outer + outer.transpose()) - d.derivative.dot(d.value) * Mat3::Identity());
  }
}

/// The vectors of the fiber as they are seen from the body, as 9 rows of forms.
Eigen::Matrix<double, 9, form_size> seen_from_body(const Dependences& dependences) {
  Eigen::Matrix<double, 9, form_size> l = Eigen::Matrix<double, 9, form_size>::Zero();
  for (const Dependence& d : dependences) {
    l.block<3, 3>(d.at, d.at).setIdentity();
    l.block<3, 3>(d.at, at_rotation) = skew(d.value);
  }
  l.block<3, 3>(at_center, at_position) = -Mat3::Identity();
  return l;
}

/// Scatters forms to the nodes of a place and of the body.
class Scatter {
 public:
  Scatter(const CurveShape& shape, Index body_node) {
    for (int n = 0; n < shape.slots.n_slots; ++n)
      for (int v = 0; v < shape.slots.vectors(n); ++v) {
        const bool is_section = shape.slots.n_vectors == 3 && v > 0;
        parts_[n_++] = {shape.slots.node[n], v, is_section ? at_sections + 3 * (v - 1) : at_center,
                        is_section ? shape.section[n] : shape.r[n][v]};
      }
    parts_[n_++] = {body_node, 0, at_position, 1};
    parts_[n_++] = {body_node, 1, at_rotation, 1};
  }
  [[nodiscard]] bool touches(const Assembler& assembler) const {
    return std::any_of(parts_.begin(), parts_.begin() + n_, [&](const Part& p) { return assembler.owns(p.node); });
  }
  /// Calls visit(node, vector, coefficient).
  template <typename Visit>
  void for_each_coefficient(const Form& form, Visit&& visit) const {
    for (int i = 0; i < n_; ++i)
      visit(parts_[i].node, parts_[i].vector, Vec3(parts_[i].weight * form.segment<3>(parts_[i].at)));
  }
  void add_force(const Form& force, Assembler& assembler) const {
    for_each_coefficient(force, [&](Index node, int v, const Vec3& f) { assembler.add_force(node, v, f); });
  }
  void add_tangent(const FormMatrix& k, Assembler& assembler) const {
    for (int j = 0; j < n_; ++j) {
      const Part& q = parts_[j];
      if (!assembler.owns(q.node)) continue;
      for (int i = 0; i < n_; ++i) {
        const Part& p = parts_[i];
        if (p.node < q.node) continue;
        const double weight = p.weight * q.weight;
        const auto block = assembler.block(p.node, q.node);
        for (int c = 0; c < 3; ++c) {
          double* values = block.data + static_cast<std::size_t>(3 * q.vector + c) * block.stride + 3 * p.vector;
          for (int r = 0; r < 3; ++r) values[r] += weight * k(p.at + r, q.at + c);
        }
      }
    }
  }

 private:
  struct Part {
    Index node;
    int vector, at;
    double weight;
  };
  std::array<Part, 3 * Slots::most + 2> parts_{};
  int n_ = 0;
};

using Element = SurfaceContactElement;

/// How the gap depends on what it is seen from.
Dependences of_gap(const Element& e) {
  const Element::Gap& g = e.measured;
  Dependences d{{{at_center, g.arm, g.force_direction}, {}, {}}};
  for (int a = 0; a < 2; ++a) d[1 + a] = {at_sections + 3 * a, g.section[a], -e.radius * g.w[a] * g.view.normal};
  return d;
}

/// How the particle moves in a direction, seen from the body.
Dependences of_particle(const Element& e, const Vec3& direction) {
  const Element::Gap& g = e.measured;
  Dependences d{{{at_center, g.arm, direction}, {}, {}}};
  for (int a = 0; a < 2; ++a) d[1 + a] = {at_sections + 3 * a, g.section[a], e.particle[a] * direction};
  return d;
}

/// Adds force and tangent of the penalty, at the state last followed.
void add_penalty(const Element& e, double p_reg, const Scatter& scatter, Assembler& assembler) {
  const double f = e.force(p_reg);
  if (f <= 0) return;
  const Element::Gap& g = e.measured;
  const Dependences of = of_gap(e);
  const Form gradient = form_of(of);
  scatter.add_force(-f * gradient, assembler);
  if (!assembler.wants_tangent()) return;
  FormMatrix k = e.stiffness(p_reg) * gradient * gradient.transpose();
  const bool exact = assembler.tangent() == Assembler::Tangent::exact;
  const Mat3 hessian = g.view.hessian();
  // −f δ²g of the vectors seen from the body. What turns the section about its centre against the surface is positive.
  Eigen::Matrix<double, 9, 9> second = Eigen::Matrix<double, 9, 9>::Zero();
  if (g.size > 0) {
    Eigen::Matrix<double, 9, 1> spin;
    spin << hessian * (-g.w[1] * g.section[0] + g.w[0] * g.section[1]), -g.w[1] * g.view.normal, g.w[0] * g.view.normal;
    second += f * e.radius / g.size * spin * spin.transpose();
  }
  if (exact) {
    const Vec3 outermost = e.radius * (g.w[0] * g.section[0] + g.w[1] * g.section[1]);
    second.block<3, 3>(0, 0) -= f * (hessian - g.view.hessian_change_along(outermost));
    for (int a = 0; a < 2; ++a) {
      second.block<3, 3>(3 + 3 * a, 0) += f * e.radius * g.w[a] * hessian;
      second.block<3, 3>(0, 3 + 3 * a) += f * e.radius * g.w[a] * hessian;
    }
    add_turning(of, -f, k);
  }
  const auto seen = seen_from_body(of);
  k += seen.transpose() * second * seen;
  scatter.add_tangent(k, assembler);
}

/// Adds force and tangent of friction, given in the frame of space.
void add_friction(const Element& e, const Friction& t, const Vec3& normal, const Scatter& scatter,
                  Assembler& assembler) {
  scatter.add_force(form_of(of_particle(e, t.force)), assembler);
  if (!assembler.wants_tangent()) return;
  Eigen::Matrix<double, form_size, 3> motion;
  for (int d = 0; d < 3; ++d) motion.col(d) = form_of(of_particle(e, Vec3::Unit(d)));
  const Mat3 across = Mat3::Identity() - normal * normal.transpose();
  const Mat3 stiffness =
      t.stiffness_across * across + (t.stiffness_along - t.stiffness_across) * t.direction * t.direction.transpose();
  FormMatrix k = motion * stiffness * motion.transpose();
  if (assembler.tangent() == Assembler::Tangent::exact) add_turning(of_particle(e, t.force), 1, k);
  scatter.add_tangent(k, assembler);
}

Friction turned(Friction t, const Mat3& rotation) {
  t.force = rotation * t.force;
  t.direction = rotation * t.direction;
  return t;
}

template <class T>
auto place_of(const T& x) {
  return std::tie(x.surface, x.fiber, x.sample);
}

/// The one at the same place in a list that is sorted by places; nullptr where there is none.
template <class T>
const T* at_place(const std::vector<T>& sorted, const Element& place) {
  const auto found = std::lower_bound(sorted.begin(), sorted.end(), place,
                                      [](const T& x, const Element& y) { return place_of(x) < place_of(y); });
  return found != sorted.end() && place_of(*found) == place_of(place) ? &*found : nullptr;
}

}  // namespace

SurfaceContact::SurfaceContact(const FiberField& field, const RigidBodies& bodies, std::vector<BodySurface> surfaces,
                               const ContactLaw& law, std::vector<double> modulus)
    : field_(field), bodies_(bodies), surfaces_(std::move(surfaces)), law_(law), modulus_(std::move(modulus)) {}

double SurfaceContact::regularisation(const Element& e) const { return law_.regularisation * e.radius; }

void SurfaceContact::begin_step(const State& start, double) {
  preloads_are_due_ = true;
  start_ = start;
  got_behind_.clear();
  // What an attempt that came to nothing has raised is not kept.
  for (Element& e : elements_) e.penetration_before = 0;
}

/// A straight fiber between two places, beside a surface of radius ρ, comes nearer to it by spacing²/(8 (ρ + R)).
SurfaceContact::Places SurfaceContact::places(Index surface, Index fiber) const {
  constexpr double nearer = 0.005;  // than at the places, in radii
  const FiberMesh& mesh = field_.mesh();
  const double radius = mesh.radius[fiber], length = mesh.length(fiber);
  const double curved = smallest_radius_of_curvature(surfaces_[surface].surface) + radius;
  const double wanted =
      std::min(law_.search.spacing * field_.element_length(fiber), std::sqrt(8 * nearer * radius * curved));
  const Index n = std::max<Index>(1, static_cast<Index>(std::ceil(length / wanted)));
  const bool ends = mesh.period(fiber) < 0;
  return {length / n, n + (ends ? 1 : 0), ends};
}

Element SurfaceContact::make_element(Index surface, Index fiber, Index sample) const {
  const Places at = places(surface, fiber);
  Element e;
  e.surface = surface;
  e.fiber = fiber;
  e.sample = sample;
  e.s = sample * at.spacing;
  e.length = at.ends && (sample == 0 || sample == at.n - 1) ? 0.5 * at.spacing : at.spacing;
  e.radius = field_.mesh().radius[fiber];
  e.shape = field_.shape(fiber, e.s);
  return e;
}

void SurfaceContact::measure(const State& state, Element& e) const {
  constexpr double edge_on = 1e-6;  // a section seen so has no outermost particle
  const BodySurface& on = surfaces_[e.surface];
  const Pose pose = bodies_.pose(state, on.body);
  Element::Gap& g = e.measured;
  g.rotation = pose.rotation;
  g.arm = field_.curve(state, e.shape).r - pose.position;
  g.view = view(on.surface, pose.rotation.transpose() * g.arm).turned(pose.rotation);
  g.force_direction = g.view.normal;
  if (field_.model(e.fiber) == FiberModel::rod) {
    g.value = g.view.distance - e.radius;
    return;
  }
  g.section = field_.section(state, e.shape);
  g.w = Vec2(g.view.normal.dot(g.section[0]), g.view.normal.dot(g.section[1]));
  g.size = g.w.norm();
  g.value = g.view.distance - e.radius * g.size;
  if (g.size < edge_on) {
    g.w.setZero();
    g.size = 0;
    return;
  }
  g.w /= g.size;
  g.force_direction -= g.view.hessian() * (e.radius * (g.w[0] * g.section[0] + g.w[1] * g.section[1]));
}

/// Penalty and preload with which it begins the step.
void SurfaceContact::take_up(Element& e, const SurfaceContactHistory* known) const {
  e.unit_penalty = law_.penalty * modulus_[e.fiber] * e.length;
  e.set_scale(known ? known->penalty_scale : 1);
  if (known) {
    e.preload = known->preload;
    e.raised_at = known->raised_at;
    e.stuck = known->stuck;
  }
  e.next_scale = e.penalty_scale;
  e.next_preload = e.preload;
}

const SurfaceContactHistory* SurfaceContact::find_history(const Element& e) const { return at_place(history_, e); }

void SurfaceContact::set_history(std::vector<SurfaceContactHistory> history) {
  history_ = std::move(history);
  for (SurfaceContactHistory& h : history_) {
    h.raised_at = 0;  // it was for the stage that is over
    if (!law_.friction) h.traction.setZero();
  }
}

Vec3 SurfaceContact::relative_position(const Element& e, const State& state) const {
  const Pose pose = bodies_.pose(state, surfaces_[e.surface].body);
  Vec3 x = field_.curve(state, e.shape).r - pose.position;
  if (field_.model(e.fiber) == FiberModel::enriched) {
    const auto [g1, g2] = field_.section(state, e.shape);
    x += e.particle[0] * g1 + e.particle[1] * g2;
  }
  return pose.rotation.transpose() * x;
}

/// At the place as it is: the limit is that of the force there, the slip that of the particle which touches.
StickSlip SurfaceContact::make_stick_slip(Element& e, const SurfaceContactHistory* known) const {
  StickSlip s;
  if (surfaces_[e.surface].friction_coefficient == 0) return s;
  e.particle = -e.radius * e.measured.w;
  s.x_start = relative_position(e, start_);
  s.normal = e.measured.rotation.transpose() * e.measured.force_direction.normalized();
  s.slip_limit = surfaces_[e.surface].friction_coefficient * e.normal_force(regularisation(e));
  s.tangential_stiffness = s.slip_limit / (law_.reversible_slip * e.radius);
  if (known) {
    s.begin_with(s.tangential(known->traction));
  }
  return s;
}

/// Those within the search margin. What lies between is stepped over: no place is nearer than the way to it is long.
std::vector<Index> SurfaceContact::near_places(const State& state, Index surface, Index fiber) const {
  constexpr double most_stretch = 2;  // of a fiber
  const Places at = places(surface, fiber);
  const double margin = law_.search.search_margin * field_.mesh().radius[fiber];
  std::vector<Index> near;
  for (Index sample = 0; sample < at.n;) {
    Element e = make_element(surface, fiber, sample);
    measure(state, e);
    if (e.gap() <= margin) near.push_back(sample);
    sample += std::max<Index>(1, static_cast<Index>((e.gap() - margin) / (most_stretch * at.spacing)));
  }
  return near;
}

void SurfaceContact::update(const State& state, bool keep) {
  std::vector<Element> before = std::exchange(elements_, {});
  for (Element& e : before) e.has_pressed = keep && (e.has_pressed || e.force(regularisation(e)) > 0);
  const std::vector<StickSlip> stick_slip_before = std::exchange(stick_slip_, {});
  const Index n_fibers = field_.mesh().n_fibers(), n_surfaces = static_cast<Index>(surfaces_.size());
  std::vector<std::vector<Element>> found(static_cast<std::size_t>(n_surfaces) * n_fibers);
#pragma omp parallel for schedule(dynamic, 16)
  for (std::size_t i = 0; i < found.size(); ++i) {
    const auto surface = static_cast<Index>(i / n_fibers), fiber = static_cast<Index>(i % n_fibers);
    std::vector<Index> samples = near_places(state, surface, fiber);
    // With `keep`, what has pressed stays.
    auto same = std::lower_bound(before.begin(), before.end(), std::make_tuple(surface, fiber, Index{0}),
                                 [](const Element& e, const auto& place) { return place_of(e) < place; });
    for (; same != before.end() && same->surface == surface && same->fiber == fiber; ++same)
      if (same->has_pressed) samples.push_back(same->sample);
    std::sort(samples.begin(), samples.end());
    samples.erase(std::unique(samples.begin(), samples.end()), samples.end());
    for (const Index sample : samples) {
      Element e = make_element(surface, fiber, sample);
      measure(state, e);
      take_up(e, find_history(e));
      const Element* last = at_place(before, e);
      if (last && (keep || last->penetration_before > 0)) {
        static_cast<AugmentedPenalty&>(e) = *last;
        e.particle = last->particle;
      }
      e.has_pressed = keep && ((last && last->has_pressed) || e.force(regularisation(e)) > 0);
      found[i].push_back(e);
    }
  }
  for (std::vector<Element>& of_fiber : found)
    elements_.insert(elements_.end(), std::make_move_iterator(of_fiber.begin()),
                     std::make_move_iterator(of_fiber.end()));
  if (const std::string what = behind(elements_); !what.empty() && got_behind_.empty())
    got_behind_ = what + " on the way; smaller increments may help";
  known_.resize(elements_.size());
  if (law_.friction) stick_slip_.resize(elements_.size());
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    known_[i] = find_history(elements_[i]);
    if (!law_.friction) continue;
    const Element* same = keep ? at_place(before, elements_[i]) : nullptr;
    stick_slip_[i] = same ? stick_slip_before[same - before.data()] : make_stick_slip(elements_[i], known_[i]);
  }
  if (!slip_energy_n_) slip_energy_n_ = slip_energy_at_start(stick_slip_);
}

std::string SurfaceContact::behind(const std::vector<Element>& elements) const {
  const auto e =
      std::find_if(elements.begin(), elements.end(), [](const Element& x) { return x.measured.view.distance < 0; });
  return e == elements.end() ? ""
                             : fmt::format("{} is behind the surface of body \"{}\"", field_.describe(e->fiber, e->s),
                                           surfaces_[e->surface].body_name);
}

std::string SurfaceContact::behind_at(const State& state) const {
  for (Index surface = 0; surface < static_cast<Index>(surfaces_.size()); ++surface)
    for (Index fiber = 0; fiber < field_.mesh().n_fibers(); ++fiber) {
      std::vector<Element> near;
      for (const Index sample : near_places(state, surface, fiber)) {
        near.push_back(make_element(surface, fiber, sample));
        measure(state, near.back());
      }
      if (std::string what = behind(near); !what.empty()) return what;
    }
  return {};
}

bool SurfaceContact::follow(const State& state, Follow what, const Region& region) {
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    if (!region.has(elements_[i].shape.slots.node[0])) continue;
    measure(state, elements_[i]);
    if (law_.friction && renews_limits(what)) stick_slip_[i] = make_stick_slip(elements_[i], known_[i]);
  }
  return false;
}

void SurfaceContact::limit_reach(const State& state, std::span<double> reach) const {
  constexpr double bulge = 1.5;  // radii: and what is nearer between nodes
  const FiberMesh& mesh = field_.mesh();
  const Layout& layout = field_.layout();
  for (const BodySurface& on : surfaces_) {
    const Pose pose = bodies_.pose(state, on.body);
    double all_apart = std::numeric_limits<double>::infinity();
    for (Index f = 0; f < mesh.n_fibers(); ++f) {
      double apart = std::numeric_limits<double>::infinity();
      const auto each_node = [&](const auto& visit) {
        for (Index n = field_.element_node(f, 0); n <= field_.last_node(f); ++n) visit(layout.first_vector(n));
      };
      each_node([&](Index v) {
        apart = std::min(apart, view(on.surface, pose.rotation.transpose() * (state.q[v] - pose.position)).distance);
      });
      apart = std::max(0.0, apart - bulge * mesh.radius[f] - 0.5 * field_.element_length(f));
      each_node([&](Index v) { reach[v] = std::min(reach[v], 0.5 * apart); });
      all_apart = std::min(all_apart, apart);
    }
    const Index position = layout.first_vector(bodies_.node(on.body)), rotation = position + 1;
    reach[position] = std::min(reach[position], 0.5 * all_apart);
    reach[rotation] = 0;
  }
}

void SurfaceContact::add_sparsity(Pattern::Builder& builder) const {
  for (const Element& e : elements_) {
    std::vector<Index> nodes(e.shape.slots.node.begin(), e.shape.slots.node.begin() + e.shape.slots.n_slots);
    nodes.push_back(bodies_.node(surfaces_[e.surface].body));
    builder.add_clique(nodes);
  }
}

void SurfaceContact::add(const State& state, Assembler& assembler) const {
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    const Element& e = elements_[i];
    const Index body = surfaces_[e.surface].body;
    const Scatter scatter(e.shape, bodies_.node(body));
    if (!scatter.touches(assembler)) continue;
    add_penalty(e, regularisation(e), scatter, assembler);
    if (!rubs(e) || stick_slip_[i].tangential_stiffness <= 0) continue;
    const Mat3& rotation = bodies_.pose(state, body).rotation;
    add_friction(e, turned(friction_of(i, state), rotation), rotation * stick_slip_[i].normal, scatter, assembler);
  }
}

void SurfaceContact::add_unsymmetric(const State& state, UnsymmetricTerms& terms) const {
  const Layout& layout = field_.layout();
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    const Element& e = elements_[i];
    if (!rubs(e) || stick_slip_[i].tangential_stiffness <= 0) continue;
    const BodySurface& on = surfaces_[e.surface];
    const Scatter scatter(e.shape, bodies_.node(on.body));
    const Vec3 by_limit =
        bodies_.pose(state, on.body).rotation * friction_by_limit(stick_slip_[i], relative_position(e, state));
    const double limit_by_gap =
        -on.friction_coefficient * e.stiffness(regularisation(e)) * e.measured.force_direction.norm();
    terms.begin_term();
    scatter.for_each_coefficient(form_of(of_particle(e, by_limit)), [&](Index node, int v, const Vec3& coefficient) {
      terms.add_left(layout.first_vector(node) + v, coefficient);
    });
    scatter.for_each_coefficient(limit_by_gap * form_of(of_gap(e)), [&](Index node, int v, const Vec3& coefficient) {
      terms.add_right(layout.first_vector(node) + v, coefficient);
    });
  }
}

Friction SurfaceContact::friction_of(std::size_t i, const State& state) const {
  return friction(stick_slip_[i], relative_position(elements_[i], state));
}

double SurfaceContact::slip_energy(const State& state) const {
  double sum = 0;
  for (std::size_t i = 0; i < stick_slip_.size(); ++i)
    if (stick_slip_[i].tangential_stiffness > 0)
      sum += 0.5 * friction_of(i, state).force.squaredNorm() / stick_slip_[i].tangential_stiffness;
  return sum;
}

double SurfaceContact::penalty_energy_at(const State& state) const {
  double sum = 0;
  for (Element e : elements_) {
    measure(state, e);
    sum += e.energy(regularisation(e));
  }
  return sum;
}

double SurfaceContact::energy(const State& state) const {
  double sum = penalty_energy_at(state);
  for (std::size_t i = 0; i < stick_slip_.size(); ++i) sum += friction_of(i, state).energy;
  return sum;
}

Ledger SurfaceContact::ledger(const State& state) const {
  Ledger ledger = booked_;
  ledger.stored = penalty_energy_at(state) + slip_energy(state);
  return ledger;
}

double SurfaceContact::max_penetration_over_radius() const {
  double largest = 0;
  for (const Element& e : elements_) largest = std::max(largest, -e.gap() / e.radius);
  return largest;
}

std::pair<Vec3, Vec3> SurfaceContact::pull(const State& state, Index body) const {
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    const Element& e = elements_[i];
    if (surfaces_[e.surface].body != body) continue;
    Form form = -e.force(regularisation(e)) * form_of(of_gap(e));
    if (rubs(e)) form += form_of(of_particle(e, bodies_.pose(state, body).rotation * friction_of(i, state).force));
    force += form.segment<3>(at_position);
    moment += form.segment<3>(at_rotation);
  }
  return {force, moment};
}

bool SurfaceContact::stiffen(const State&, double elastic_energy, double slack) {
  if (!law_.adapt_penalty) return false;
  const Stiffening done = raise_where_too_soft(
      elements_, law_.target_penetration, elastic_energy, slack, [](const Element& e) { return e.radius; },
      [&](const Element& e) { return regularisation(e); });
  preloads_are_due_ = done.due;
  return done.raised;
}

std::vector<double> SurfaceContact::book_changes(const State& state) {
  std::vector<double> force_at_start(elements_.size());
  std::vector<char> went_on(history_.size(), 0);
  const auto at = [](const PenaltyLaw& law, double gap) { return ContactAt{law.force(gap), law.energy(gap)}; };
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    const Element& e = elements_[i];
    const double p_reg = regularisation(e);
    const SurfaceContactHistory* known = known_[i];
    const PenaltyLaw first = known ? known->law : PenaltyLaw{e.penalty, 0, p_reg};
    const auto gap_at_start = [&] {
      Element start = e;
      measure(start_, start);
      return start.gap();
    };
    const double start_gap = known ? known->gap : gap_at_start();
    force_at_start[i] = first.force(start_gap);
    booked_[Source::preloads] += work_of_new_law(start_gap, e.gap(), first, e.law(p_reg));
    if (known)
      went_on[known - history_.data()] = 1;
    else
      booked_[Source::contacts] += energy_brought(at(first, start_gap), at(first, e.gap()));
  }
  for (std::size_t j = 0; j < history_.size(); ++j) {
    if (went_on[j]) continue;
    const SurfaceContactHistory& h = history_[j];
    Element e = make_element(h.surface, h.fiber, h.sample);
    measure(state, e);
    booked_[Source::contacts] -= energy_brought(at(h.law, h.gap), at(h.law, e.gap()));
  }
  return force_at_start;
}

void SurfaceContact::commit(const State& state) {
  for (Element& e : elements_) measure(state, e);
  const std::vector<double> force_at_start = book_changes(state);
  booked_[Source::friction_limits] += slip_energy_at_start(stick_slip_) - *slip_energy_n_;
  slip_energy_n_ = slip_energy(state);
  std::vector<SurfaceContactHistory> history(elements_.size());
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    Element& e = elements_[i];
    const double p_reg = regularisation(e), force = e.force(p_reg);
    SurfaceContactHistory& h = history[i];
    if (rubs(e)) {
      const Friction slip = friction_of(i, state);
      // The limit has gone from that of the force at the step's start to what it is.
      if (slip.slides) booked_[Sink::friction] += 0.5 * (1 + force_at_start[i] / force) * slip.dissipated;
      h.traction = slip.force;
    }
    h.law = e.law(p_reg);
    h.gap = e.gap();
    e.accept(e.gap(), force, p_reg, law_.adapt_penalty && preloads_are_due_);
    const double target = deepest_over_target * law_.target_penetration * e.radius;
    if (law_.adapt_penalty && !e.stuck && -e.gap() > target)
      e.adapt(adapted_penalty_scale(e.penalty_scale, -e.gap() / target), p_reg);
    std::tie(h.surface, h.fiber, h.sample) = place_of(e);
    h.penalty_scale = e.next_scale;
    h.preload = e.next_preload;
    h.raised_at = e.raised_at;
    h.stuck = e.stuck;
  }
  history_ = std::move(history);
  known_.clear();
}

void SurfaceContact::keep(Archive& archive) {
  archive(history_, slip_energy_n_, booked_);
  if (!archive.reads()) return;
  for (const SurfaceContactHistory& h : history_)
    archive.require(h.surface >= 0 && h.surface < static_cast<Index>(surfaces_.size()) && h.fiber >= 0 &&
                        h.fiber < field_.mesh().n_fibers() && h.penalty_scale > 0 && std::isfinite(h.penalty_scale) &&
                        h.traction.allFinite(),
                    "a contact that cannot be");
  // Elements are looked for anew in each increment.
  elements_.clear();
  known_.clear();
  stick_slip_.clear();
}

}  // namespace trame::micro
