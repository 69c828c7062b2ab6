#include "micro/contact/contact.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace trame::micro {

Contact::Contact(const FiberField& field, const ContactLaw& law, std::vector<double> modulus)
    : field_(field), law_(law), modulus_(std::move(modulus)) {}

double Contact::mean_radius(Index a, Index b) const {
  return 0.5 * (field_.mesh().radius[a] + field_.mesh().radius[b]);
}
double Contact::regularisation(const ContactElement& e) const {
  return law_.regularisation * mean_radius(e.fiber_a, e.fiber_b);
}

void Contact::begin_step(const State& start, double stage_time) {
  constexpr double faded_at = 0.75;
  if (law_.friction) start_ = start;
  fading_ = std::max(0.0, 1 - stage_time / faded_at);
}

void Contact::forgive(const State& start) {
  begin_step(start, 0);
  update(start, Update::everything);
  history_.clear();
  tractions_.clear();
  for (const StickSlip& s : stick_slip_) tractions_.push_back(s.traction_start);
  for (const ContactElement& e : elements_) {
    const double penetration = std::max(0.0, -e.gap(field_.layout(), start));
    const auto traction = law_.friction ? static_cast<Index>(history_.size()) : -1;
    history_.push_back(
        {e.fiber_a, e.fiber_b, e.s_a, e.s_b, e.normal, traction, e.penalty_scale, penetration > 0, penetration});
  }
  fading_n_ = 1;
  note_loaded_particles();
}

/// The history entry of the same two fibers nearest in arc length, within one sample length; a crossing keeps its
/// identity where it slides farther.
const ContactHistory* Contact::find_history(const Proximity& p) const {
  const double reach = (p.crossing ? 4 : 1) * p.length;
  const auto key = std::make_pair(p.fiber_a, p.fiber_b);
  auto h = std::lower_bound(
      history_.begin(), history_.end(), std::make_tuple(p.fiber_a, p.fiber_b, p.s_a - reach),
      [](const ContactHistory& c, const auto& k) { return std::make_tuple(c.fiber_a, c.fiber_b, c.s_a) < k; });
  const ContactHistory* best = nullptr;
  double best_distance = reach;
  for (; h != history_.end() && std::make_pair(h->fiber_a, h->fiber_b) == key && h->s_a <= p.s_a + reach; ++h) {
    const double distance = 0.5 * (std::abs(h->s_a - p.s_a) + std::abs(h->s_b - p.s_b));
    if (distance < best_distance) {
      best_distance = distance;
      best = &*h;
    }
  }
  return best;
}

void Contact::set_history(std::vector<ContactHistory> history, std::vector<Vec3> tractions) {
  history_ = std::move(history);
  if (law_.friction) tractions_ = std::move(tractions);
  for (ContactHistory& h : history_) {
    h.allowance = 0;  // it was for the stage that is over
    if (!law_.friction) h.traction = -1;
  }
  note_loaded_particles();
}

/// Only penalties that adapt differ from place to place.
void Contact::note_loaded_particles() {
  if (!law_.adapt_penalty) return;
  loaded_.clear();
  for (const ContactHistory& h : history_)
    if (h.touches) {
      loaded_.push_back({h.fiber_a, h.s_a, std::log(h.penalty_scale)});
      loaded_.push_back({h.fiber_b, h.s_b, std::log(h.penalty_scale)});
    }
  std::sort(loaded_.begin(), loaded_.end(), [](const LoadedParticle& a, const LoadedParticle& b) {
    return std::tie(a.fiber, a.s, a.log_scale) < std::tie(b.fiber, b.s, b.log_scale);
  });
}

/// A pair that touches for the first time starts with the geometric mean of the penalties in force nearby on both
/// fibers: a soft one among hard ones would have to take their load, and let fibers through each other.
double Contact::starting_scale(const Proximity& p) const {
  double sum = 0;
  int n = 0;
  const auto collect = [&](Index fiber, double s) {
    const double reach = 4 * field_.mesh().radius[fiber];
    auto l = std::lower_bound(loaded_.begin(), loaded_.end(), std::make_pair(fiber, s - reach),
                              [](const LoadedParticle& a, const auto& k) { return std::make_pair(a.fiber, a.s) < k; });
    for (; l != loaded_.end() && l->fiber == fiber && l->s < s + reach; ++l, ++n) sum += l->log_scale;
  };
  collect(p.fiber_a, p.s_a);
  collect(p.fiber_b, p.s_b);
  return n > 0 ? std::exp(sum / n) : 1;
}

ContactElement Contact::make_element(const Proximity& p, const State& state, const ContactHistory* known) const {
  ContactElement e;
  e.fiber_a = p.fiber_a;
  e.fiber_b = p.fiber_b;
  e.s_a = p.s_a;
  e.s_b = p.s_b;
  e.length = p.length;
  e.crossing = p.crossing;
  e.radius_a = field_.mesh().radius[p.fiber_a];
  e.radius_b = field_.mesh().radius[p.fiber_b];
  const double distance = p.chord.norm();
  e.normal = distance > 0 ? Vec3(p.chord / distance) : Vec3::UnitZ();
  // Axes nearer than 5 % of a radius give no reliable direction: keep the one that the pair had.
  if (known && distance < 0.05 * mean_radius(p.fiber_a, p.fiber_b)) e.normal = known->normal;
  // A direction that turned over since the last increment means that the axes passed through each other: push back.
  if (known && e.normal.dot(known->normal) < -0.5) e.normal = known->normal;

  const auto particle = [&](Index fiber, double s, const Vec3& outward) {
    const double radius = field_.mesh().radius[fiber];
    Vec2 xi = Vec2::Zero();
    if (field_.model(fiber) == FiberModel::enriched) {
      const auto [g1, g2] = field_.section(state, fiber, s);
      xi = radius * Vec2(outward.dot(g1), outward.dot(g2)).normalized();
    } else {
      e.offset += radius;
    }
    return field_.particle(fiber, s, xi);
  };
  if (known) e.allowance = known->allowance;
  e.offset -= fading_ * e.allowance;
  e.a = particle(p.fiber_a, p.s_a, e.normal);
  e.b = particle(p.fiber_b, p.s_b, -e.normal);
  e.penalty_scale = known ? known->penalty_scale : law_.adapt_penalty ? starting_scale(p) : 1;
  e.penalty = law_.penalty * std::min(modulus_[p.fiber_a], modulus_[p.fiber_b]) * p.length * e.penalty_scale;
  return e;
}

StickSlip Contact::make_stick_slip(const ContactElement& e, const State& state, const ContactHistory* known) const {
  const Layout& layout = field_.layout();
  StickSlip s;
  s.x_start = e.relative_position(layout, start_);
  s.slip_limit = law_.friction_coefficient * penalty_force(e.gap(layout, state), e.penalty, regularisation(e));
  s.tangential_stiffness = s.slip_limit / (law_.reversible_slip * mean_radius(e.fiber_a, e.fiber_b));
  if (known && known->traction >= 0) {
    // What the limit no longer bears is gone without a slip.
    s.traction_start = e.tangential(tractions_[known->traction]);
    if (const double size = s.traction_start.norm(); size > s.slip_limit) s.traction_start *= s.slip_limit / size;
  }
  return s;
}

void Contact::update(const State& state, Update what) {
  std::vector<Proximity> proximities;
  if (what == Update::everything) {
    proximities = find_proximities(field_, state, law_.search);
    ++n_searches_;
  } else {
    for (const ContactElement& e : elements_)
      proximities.push_back(
          facing(field_, state, {e.fiber_a, e.fiber_b, e.s_a, e.s_b, Vec3::Zero(), e.length, e.crossing}));
  }
  elements_.resize(proximities.size());
  if (law_.friction) stick_slip_.resize(proximities.size());
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < proximities.size(); ++i) {
    const ContactHistory* known = find_history(proximities[i]);
    elements_[i] = make_element(proximities[i], state, known);
    if (law_.friction) stick_slip_[i] = make_stick_slip(elements_[i], state, known);
  }
  if (!slip_energy_n_) slip_energy_n_ = slip_energy_at_start();
}

double Contact::slip_energy_at_start() const {
  double sum = 0;
  for (const StickSlip& s : stick_slip_)
    if (s.tangential_stiffness > 0) sum += 0.5 * s.traction_start.squaredNorm() / s.tangential_stiffness;
  return sum;
}

double Contact::slip_energy(const State& state) const {
  double sum = 0;
  for (std::size_t i = 0; i < stick_slip_.size(); ++i)
    if (stick_slip_[i].tangential_stiffness > 0)
      sum += 0.5 * friction_of(i, state).force.squaredNorm() / stick_slip_[i].tangential_stiffness;
  return sum;
}

void Contact::announce(Pattern::Builder& builder) const {
  for (const ContactElement& e : elements_) announce_contact_element(e, builder);
}

void Contact::add(const State& state, Assembler& assembler) const {
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    add_contact_element(elements_[i], field_.layout(), state, regularisation(elements_[i]), assembler);
    if (law_.friction) add_friction(elements_[i], stick_slip_[i], field_.layout(), state, assembler);
  }
}

Friction Contact::friction_of(std::size_t i, const State& state) const {
  return friction(elements_[i], stick_slip_[i], elements_[i].relative_position(field_.layout(), state));
}

double Contact::penalty_energy_of(const State& state) const {
  double sum = 0;
  for (const ContactElement& e : elements_)
    sum += penalty_energy(e.gap(field_.layout(), state), e.penalty, regularisation(e));
  return sum;
}

double Contact::energy(const State& state) const {
  double sum = penalty_energy_of(state);
  for (std::size_t i = 0; i < stick_slip_.size(); ++i) sum += friction_of(i, state).energy;
  return sum;
}

double Contact::stored_energy(const State& state) const { return penalty_energy_of(state) + slip_energy(state); }

double Contact::max_penetration_over_radius(const State& state) const {
  double largest = 0;
  for (const ContactElement& e : elements_)
    largest = std::max(largest, -e.gap(field_.layout(), state) / mean_radius(e.fiber_a, e.fiber_b));
  return largest;
}

bool Contact::wants_repeat(const State& state) const {
  constexpr double tolerated = 5.0 / 3;
  return law_.adapt_penalty && max_penetration_over_radius(state) > tolerated * law_.target_penetration;
}

void Contact::commit(const State& state) {
  double allowance_force = 0;
  for (const ContactElement& e : elements_)
    allowance_force += e.allowance * penalty_force(e.gap(field_.layout(), state), e.penalty, regularisation(e));
  adaptation_work_ += coming_adaptation_work_ + 0.5 * (allowance_force_n_ + allowance_force) * (fading_n_ - fading_);
  allowance_force_n_ = allowance_force;
  fading_n_ = fading_;
  coming_adaptation_work_ = law_.adapt_penalty ? adapt_penalties(state) : 0;
  history_.resize(elements_.size());
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    const ContactElement& e = elements_[i];
    const auto traction = law_.friction ? static_cast<Index>(i) : -1;
    const bool touches = e.gap(field_.layout(), state) < 0;
    history_[i] = {e.fiber_a, e.fiber_b, e.s_a, e.s_b, e.normal, traction, e.penalty_scale, touches, e.allowance};
  }
  limit_work_ += slip_energy_at_start() - *slip_energy_n_;
  slip_energy_n_ = slip_energy(state);
  tractions_.resize(stick_slip_.size());
  for (std::size_t i = 0; i < stick_slip_.size(); ++i) {
    const Friction slip = friction_of(i, state);
    dissipated_ += slip.dissipated;
    tractions_[i] = slip.force;
  }
  note_loaded_particles();
}

/// Zone by zone: up to eight consecutive samples of a pair. Zones without any contact keep their penalty, so that a
/// fiber does not meet one that its neighbours have worn down. Returns the work that it does.
double Contact::adapt_penalties(const State& state) {
  constexpr std::size_t zone_samples = 8;
  double work = 0;
  for (std::size_t begin = 0; begin < elements_.size();) {
    const ContactElement& first = elements_[begin];
    std::size_t end = begin;
    double penetration = 0, scale = 0;
    while (end < elements_.size() && end - begin < zone_samples && elements_[end].fiber_a == first.fiber_a &&
           elements_[end].fiber_b == first.fiber_b &&
           (end == begin || elements_[end].s_a - elements_[end - 1].s_a < 2 * first.length)) {
      const ContactElement& e = elements_[end++];
      penetration = std::max(penetration, -e.gap(field_.layout(), state));
      scale = std::max(scale, e.penalty_scale);
    }
    const double target = law_.target_penetration * mean_radius(first.fiber_a, first.fiber_b);
    scale = adapted_penalty_scale(scale, penetration / target);
    for (; begin < end; ++begin) {
      ContactElement& e = elements_[begin];
      const double energy = penalty_energy(e.gap(field_.layout(), state), e.penalty, regularisation(e));
      // ∫ (∂ψ/∂k) dk at a constant force, at which the energy of the quadratic penalty goes with k^−½.
      work += 2 * energy * (1 - std::sqrt(e.penalty_scale / scale));
      e.penalty_scale = scale;
    }
  }
  return work;
}

}  // namespace trame::micro
