#include "micro/weave/crossing_order.h"

#include <algorithm>
#include <cmath>

namespace trame::micro {

bool plan_crossing(const FiberField& field, const State& state, Index a, Index b, double& s_a, double& s_b) {
  const double length_a = field.mesh().length(a), length_b = field.mesh().length(b);
  const double tolerance = 1e-9 * (length_a + length_b);
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
    s_a = std::clamp(s_a + da, 0.0, length_a);
    s_b = std::clamp(s_b + db, 0.0, length_b);
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

CrossingOrder::CrossingOrder(const FiberField& field, std::vector<YarnCrossing> crossings, double start_depth,
                             double penalty, double p_reg, std::optional<double> target_penetration)
    : field_(field), crossings_(std::move(crossings)), penalty_scale_(crossings_.size(), 1.0),
      start_depth_(start_depth), penalty_(penalty), p_reg_(p_reg), target_penetration_(target_penetration),
      depth_n_(start_depth) {}

void CrossingOrder::begin_step(const State&, double stage_time) {
  depth_ = start_depth_ + stage_time * (1 - start_depth_);
}

void CrossingOrder::update(const State& state, bool) {
  std::vector<std::vector<Element>> found(crossings_.size());
#pragma omp parallel for schedule(dynamic, 1)
  for (std::size_t i = 0; i < crossings_.size(); ++i)
    for_each_pair(field_, state, crossings_[i], [&](Index a, Index b, double s_a, double s_b) {
      const double reach = field_.mesh().radius[a] + field_.mesh().radius[b];
      Element e{a, b, s_a, s_b, reach, {}};
      e.gap.a = field_.particle(a, s_a, Vec2::Zero());
      e.gap.b = field_.particle(b, s_b, Vec2::Zero());
      e.gap.normal = -Vec3::UnitZ();
      e.gap.offset = depth_ * reach;
      e.gap.penalty = penalty_ * penalty_scale_[i];
      if (e.gap.gap(field_.layout(), state) > 0.5 * reach) return;  // far from being active
      found[i].push_back(e);
    });
  elements_.clear();
  element_start_.assign(1, 0);
  for (const auto& part : found) {
    elements_.insert(elements_.end(), part.begin(), part.end());
    element_start_.push_back(elements_.size());
  }
}

void CrossingOrder::announce(Pattern::Builder& builder) const {
  for (const Element& e : elements_) announce_fixed_gap(e.gap, builder);
}

void CrossingOrder::add(const State& state, Assembler& assembler) const {
  for (const Element& e : elements_) add_fixed_gap(e.gap, field_.layout(), state, p_reg_, assembler);
}

double CrossingOrder::energy(const State& state) const {
  double sum = 0;
  for (const Element& e : elements_)
    sum += penalty_energy(e.gap.gap(field_.layout(), state), e.gap.penalty, p_reg_);
  return sum;
}

void CrossingOrder::commit(const State& state) {
  double force = 0;
  for (const Element& e : elements_)
    force += e.reach * penalty_force(e.gap.gap(field_.layout(), state), e.gap.penalty, p_reg_);
  work_ += 0.5 * (force_n_ + force) * (depth_ - depth_n_);
  depth_n_ = depth_;
  force_n_ = force;
  if (!target_penetration_) return;
  for (std::size_t i = 0; i < crossings_.size(); ++i) {
    double penetration = 0;
    for (std::size_t e = element_start_[i]; e < element_start_[i + 1]; ++e)
      penetration = std::max(penetration, -elements_[e].gap.gap(field_.layout(), state));
    penalty_scale_[i] = adapted_penalty_scale(penalty_scale_[i], penetration / *target_penetration_);
  }
}

std::vector<ContactHistory> CrossingOrder::history(const State& state) const {
  std::vector<ContactHistory> history;
  for (std::size_t i = 0; i < crossings_.size(); ++i)
    for (std::size_t n = element_start_[i]; n < element_start_[i + 1]; ++n) {
      const Element& e = elements_[n];
      if (e.gap.gap(field_.layout(), state) >= 0) continue;
      ContactHistory h;
      h.touches = h.point = true;
      h.penalty_scale = penalty_scale_[i];
      const bool in_order = e.fiber_a < e.fiber_b;
      h.fiber_a = in_order ? e.fiber_a : e.fiber_b;
      h.fiber_b = in_order ? e.fiber_b : e.fiber_a;
      h.s_a = in_order ? e.s_a : e.s_b;
      h.s_b = in_order ? e.s_b : e.s_a;
      h.normal = in_order ? e.gap.normal : Vec3(-e.gap.normal);
      history.push_back(h);
    }
  return history;
}

}  // namespace trame::micro
