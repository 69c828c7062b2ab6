#include "micro/weave/crossing_order.h"

#include <algorithm>
#include <cmath>

namespace trame::micro {

bool plan_crossing(const FiberField& field, const State& state, Index a, Index b, double& s_a, double& s_b) {
  const FiberField::Ends ends_a = field.ends(a), ends_b = field.ends(b);
  const double tolerance = 1e-9 * (field.mesh().length(a) + field.mesh().length(b));
  for (int iteration = 0; iteration < 30; ++iteration) {
    const auto pa = field.curve(state, a, s_a);
    const auto pb = field.curve(state, b, s_b);
    const Vec3 d = pb.r - pa.r;
    // t_a δ_a − t_b δ_b = d in the plane.
    const double determinant = -pa.tangent.x() * pb.tangent.y() + pa.tangent.y() * pb.tangent.x();
    if (std::abs(determinant) < 1e-6) return false;
    const double da = (-d.x() * pb.tangent.y() + d.y() * pb.tangent.x()) / determinant;
    const double db = (pa.tangent.x() * d.y() - pa.tangent.y() * d.x()) / determinant;
    if (std::hypot(da, db) < tolerance) return true;
    const double before_a = s_a, before_b = s_b;
    s_a = std::clamp(s_a + da, ends_a.start, ends_a.end);
    s_b = std::clamp(s_b + db, ends_b.start, ends_b.end);
    // Held at an end that it wants to leave: the fibers do not reach each other.
    if (std::hypot(s_a - before_a, s_b - before_b) < tolerance) return false;
  }
  return false;
}

namespace {

/// Calls visit(upper fiber, lower fiber, s_upper, s_lower) for the pairs of fibers of a crossing; returns how many do
/// not cross.
template <typename Visit>
int for_each_pair(const FiberField& field, const State& state, const YarnCrossing& crossing, Visit&& visit) {
  const Yarn &upper = field.mesh().yarns[crossing.upper_yarn], &lower = field.mesh().yarns[crossing.lower_yarn];
  // The crossing of one pair is the first guess of the next.
  double s_a = 0.5 * field.mesh().length(upper.first_fiber), s_b = 0.5 * field.mesh().length(lower.first_fiber);
  int n_missed = 0;
  for (Index a = upper.first_fiber; a < upper.first_fiber + upper.n_fibers; ++a)
    for (Index b = lower.first_fiber; b < lower.first_fiber + lower.n_fibers; ++b)
      if (double at_a = s_a, at_b = s_b; plan_crossing(field, state, a, b, at_a, at_b)) {
        s_a = at_a;
        s_b = at_b;
        visit(a, b, s_a, s_b);
      } else {
        ++n_missed;
      }
  return n_missed;
}

}  // namespace

std::optional<double> smallest_separation(const FiberField& field, const State& state, const YarnCrossing& crossing) {
  std::optional<double> smallest;
  const int n_missed = for_each_pair(field, state, crossing, [&](Index a, Index b, double s_a, double s_b) {
    const double dz = field.curve(state, a, s_a).r.z() - field.curve(state, b, s_b).r.z();
    smallest = std::min(smallest.value_or(dz), dz);
  });
  return n_missed == 0 ? smallest : std::nullopt;
}

void CrossingOrder::begin_step(const State& start, double stage_time) {
  start_ = start;
  depth_ = settings_.start_depth + stage_time * (1 - settings_.start_depth);
}

void CrossingOrder::update(const State& state, bool) {
  std::vector<std::vector<Element>> found(crossings_.size());
#pragma omp parallel for schedule(dynamic, 1)
  for (std::size_t i = 0; i < crossings_.size(); ++i)
    for_each_pair(field_, state, crossings_[i], [&](Index a, Index b, double s_a, double s_b) {
      Element e;
      e.a = {a, s_a};
      e.b = {b, s_b};
      e.reach = field_.mesh().radius[a] + field_.mesh().radius[b];
      e.penalty = settings_.penalty * penalty_scale_[i];
      follow(state, e);
      if (e.gap > 0.5 * e.reach) return;  // far from being active
      e.feet_at_iteration = {e.a, e.b};
      e.covered.cover(field_, e.a, e.b);
      found[i].push_back(e);
    });
  elements_.clear();
  element_start_.assign(1, 0);
  for (const auto& part : found) {
    elements_.insert(elements_.end(), part.begin(), part.end());
    element_start_.push_back(elements_.size());
  }
  if (!elements_n_) elements_n_ = elements_;
}

bool CrossingOrder::follow(const State& state, Element& e) const {
  double s_a = e.a.s, s_b = e.b.s;
  const bool crosses = plan_crossing(field_, state, e.a.fiber, e.b.fiber, s_a, s_b);
  if (crosses) {
    e.a.s = s_a;
    e.b.s = s_b;
  }
  const auto height = [&](const Foot& foot) { return field_.curve(state, foot.fiber, foot.s).r.z(); };
  e.gap = height(e.a) - height(e.b) - depth_ * e.reach;
  return crosses;
}

bool CrossingOrder::follow(const State& state, Follow what, const Region& region) {
  const auto is_free = [&](const Foot& foot) { return region.has(field_.element_node(foot.fiber, 0)); };
  bool grown = false;
#pragma omp parallel for schedule(static) reduction(|| : grown)
  for (Element& e : elements_) {
    if (!is_free(e.a) && !is_free(e.b)) continue;
    e.a = e.feet_at_iteration[0];
    e.b = e.feet_at_iteration[1];
    follow(state, e);
    if (is_trial(what)) continue;
    e.feet_at_iteration = {e.a, e.b};
    grown = e.covered.cover(field_, e.a, e.b) || grown;
  }
  return grown;
}

void CrossingOrder::add_sparsity(Pattern::Builder& builder) const {
  for (const Element& e : elements_) e.covered.add_sparsity(field_, e.a, e.b, builder);
}

/// Forces are vertical, at crossings that go with the fibers. That has no potential where fibers are inclined; the
/// tangent is that of crossings that stand.
void CrossingOrder::add(const State&, Assembler& assembler) const {
  for (const Element& e : elements_) {
    const double f = penalty_force(e.gap, e.penalty, settings_.p_reg);
    if (f <= 0) continue;
    const LocalForms local(field_, e.a, e.b);
    if (!local.touches(assembler)) continue;
    LocalForms::Form gradient = local.zero();
    LocalForms::position(gradient, 0) = Vec3::UnitZ();
    LocalForms::position(gradient, 1) = -Vec3::UnitZ();
    local.scatter_force(-f * gradient, assembler);
    if (!assembler.wants_tangent()) continue;
    LocalForms::Matrix k = local.zero_matrix();
    LocalForms::add_square(gradient, penalty_stiffness(e.gap, e.penalty, settings_.p_reg), k);
    local.scatter_tangent(k, assembler);
  }
}

double CrossingOrder::energy(const State& state) const {
  double sum = 0;
  for (Element e : elements_) {
    follow(state, e);
    sum += penalty_energy(e.gap, e.penalty, settings_.p_reg);
  }
  return sum;
}

/// A guide that lifts fibers stores nothing; what it does, comes from outside.
Ledger CrossingOrder::ledger(const State&) const {
  Ledger ledger;
  ledger[Source::separation] = work_n_;
  return ledger;
}

/// Of the forces of `elements`, on the material points on which they act, on the way from the last accepted state to
/// `state`.
double CrossingOrder::work(const std::vector<Element>& elements, const State& state) const {
  double sum = 0;
  for (const Element& e : elements) {
    const double force = penalty_force(e.gap, e.penalty, settings_.p_reg);
    if (force <= 0) continue;
    const auto rise = [&](const Foot& foot) {
      return field_.curve(state, foot.fiber, foot.s).r.z() - field_.curve(start_, foot.fiber, foot.s).r.z();
    };
    sum += force * (rise(e.a) - rise(e.b));
  }
  return sum;
}

void CrossingOrder::commit(const State& state) {
  work_n_ += 0.5 * (work(*elements_n_, state) + work(elements_, state));
  elements_n_ = elements_;
  if (!settings_.target_penetration) return;
  for (std::size_t i = 0; i < crossings_.size(); ++i) {
    double penetration = 0;
    for (std::size_t e = element_start_[i]; e < element_start_[i + 1]; ++e)
      penetration = std::max(penetration, -elements_[e].gap);
    penalty_scale_[i] = adapted_penalty_scale(penalty_scale_[i], penetration / *settings_.target_penetration);
  }
}

void CrossingOrder::keep(Archive& archive) {
  archive(penalty_scale_, work_n_, elements_n_);
  archive.require(penalty_scale_.size() == crossings_.size(), "crossings of another weave");
  for (const Element& e : elements_n_.value_or(std::vector<Element>()))
    archive.require(e.a.is_on(field_.mesh()) && e.b.is_on(field_.mesh()), "a crossing that cannot be");
}

std::vector<ContactHistory> CrossingOrder::history() const {
  std::vector<ContactHistory> history;
  for (std::size_t i = 0; i < crossings_.size(); ++i)
    for (std::size_t n = element_start_[i]; n < element_start_[i + 1]; ++n) {
      const Element& e = elements_[n];
      if (e.gap >= 0) continue;
      ContactHistory h;
      h.touches = h.point = true;
      h.penalty_scale = penalty_scale_[i];
      const bool in_order = e.a.fiber < e.b.fiber;
      const Foot &first = in_order ? e.a : e.b, &second = in_order ? e.b : e.a;
      h.fiber_a = first.fiber;
      h.fiber_b = second.fiber;
      h.s_a = first.s;
      h.s_b = second.s;
      h.normal = in_order ? Vec3(-Vec3::UnitZ()) : Vec3::UnitZ();
      history.push_back(h);
    }
  return history;
}

}  // namespace trame::micro
