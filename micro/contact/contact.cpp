#include "micro/contact/contact.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace trame::micro {

Contact::Contact(const FiberField& field, const ContactLaw& law, std::vector<double> modulus)
    : field_(field), law_(law), modulus_(std::move(modulus)) {}

namespace {

ContactHistory remember(const FiberField& field, const ContactElement& e, Index traction) {
  ContactHistory h;
  h.fiber_a = e.fiber_a;
  h.fiber_b = e.fiber_b;
  h.image = e.pair.image();
  // Fibers that come back together have slid on past where they do.
  const double whole =
      field.come_back_together(e.fiber_a, e.fiber_b) ? std::floor(e.s_a / field.mesh().length(e.fiber_a)) : 0;
  const Vec2 back = whole_periods(field, e.fiber_a, e.fiber_b, whole);
  h.s_a = e.s_a - back[0];
  h.s_b = e.s_b - back[1];
  h.normal = e.normal;
  h.traction = traction;
  h.penalty_scale = e.next_scale;
  h.touches = e.gap() < 0;
  h.gap_offset = e.gap_offset;
  h.length = e.length;
  h.point = e.crossing;
  h.preload = e.next_preload;
  h.raised_at = e.raised_at;
  h.stuck = e.stuck;
  return h;
}

bool is_before(const ContactElement& e, const Proximity& pair, double s_a) {
  return std::tie(e.fiber_a, e.fiber_b, e.pair.image(), e.s_a) <
         std::make_tuple(pair.fiber_a(), pair.fiber_b(), pair.image(), s_a);
}

/// Elements in the order of their fibers and of where their feet have slid to.
std::vector<const ContactElement*> in_order(const std::vector<ContactElement>& elements) {
  std::vector<const ContactElement*> sorted;
  sorted.reserve(elements.size());
  for (const ContactElement& e : elements) sorted.push_back(&e);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const ContactElement* p, const ContactElement* q) { return is_before(*p, q->pair, q->s_a); });
  return sorted;
}

/// How far an element is from a place found anew, in arc length. Samples are where their mean arc length is: between
/// feet of shortest chords and of smallest gaps there is little, unless sections are much inclined.
double distance_along(const ContactElement& e, const Proximity& p) {
  const double a = e.s_a - p.s_a(), b = e.s_b - p.s_b();
  if (p.point) return 0.5 * (std::abs(a) + std::abs(b));
  const double sense = p.hold.sense;
  if (e.pair.hold.sense != sense) return std::numeric_limits<double>::infinity();
  return std::abs(e.pair.hold.mean_arc_length - p.hold.mean_arc_length) + 0.125 * std::abs(a - sense * b);
}

/// Looks for what is nearest to a place, `search(place, nearest, least)`; where both fibers come back together, also
/// from a period before and after.
template <typename T, typename Search>
const T* nearest_to(const FiberField& field, const Proximity& p, double near, const Search& search) {
  const T* nearest = nullptr;
  search(p, nearest, near);
  if (!field.come_back_together(p.fiber_a(), p.fiber_b())) return nearest;
  for (const double n : {-1.0, 1.0}) {
    Proximity moved = p;
    const Vec2 ds = whole_periods(field, p.fiber_a(), p.fiber_b(), n);
    moved.chord.a.s += ds[0];
    moved.chord.b.s += ds[1];
    moved.hold.mean_arc_length += moved.hold.along().dot(ds);
    search(moved, nearest, near);
  }
  return nearest;
}

/// The element of an earlier search in the same increment at the same place.
const ContactElement* same_place(const FiberField& field, const std::vector<const ContactElement*>& before,
                                 const Proximity& place, double near) {
  return nearest_to<ContactElement>(
      field, place, near, [&](const Proximity& p, const ContactElement*& best, double& least) {
        const double farthest = p.point ? 2 * near : 5 * near;  // of one foot
        auto e = std::partition_point(before.begin(), before.end(),
                                      [&](const ContactElement* x) { return is_before(*x, p, p.s_a() - farthest); });
        for (; e != before.end() && (*e)->fiber_a == p.fiber_a() && (*e)->fiber_b == p.fiber_b() &&
               (*e)->pair.image() == p.image() && (*e)->s_a < p.s_a() + farthest;
             ++e) {
          if (const double distance = distance_along(**e, p); (*e)->crossing == p.point && distance < least) {
            least = distance;
            best = *e;
          }
        }
      });
}

}  // namespace

double Contact::mean_radius(Index a, Index b) const {
  return 0.5 * (field_.mesh().radius[a] + field_.mesh().radius[b]);
}
double Contact::spacing(Index a, Index b) const {
  return law_.search.spacing * std::min(field_.element_length(a), field_.element_length(b));
}
double Contact::regularisation(const ContactElement& e) const {
  return law_.regularisation * mean_radius(e.fiber_a, e.fiber_b);
}

void Contact::begin_step(const State& start, double stage_time) {
  constexpr double faded_at = 0.75;
  start_ = start;
  fading_ = std::max(0.0, 1 - stage_time / faded_at);
  preloads_are_due_ = true;
  // What an attempt that came to nothing has raised is not kept.
  for (ContactElement& e : elements_) e.penetration_before = 0;
}

void Contact::offset_gaps(const State& start) {
  begin_step(start, 0);
  update(start);
  std::vector<ContactHistory> history;
  tractions_.clear();
  for (const StickSlip& s : stick_slip_) tractions_.push_back(s.traction_start);
  for (const ContactElement& e : elements_) {
    const auto traction = law_.friction ? static_cast<Index>(history.size()) : -1;
    history.push_back(remember(field_, e, traction));
    history.back().gap_offset = std::max(0.0, -e.gap());
  }
  history_ = std::move(history);
  known_.clear();
  elements_.clear();
  stick_slip_.clear();
  slip_energy_n_.reset();
  fading_n_ = 1;
  note_loaded_particles();
}

/// The history entry of the same two fibers nearest in arc length, within one sample length, of the same kind if there
/// is one; a point keeps its identity where it slides farther.
const ContactHistory* Contact::find_history(const Proximity& place) const {
  const double sum = 2 * mean_radius(place.fiber_a(), place.fiber_b());
  const double along = spacing(place.fiber_a(), place.fiber_b());
  const double reach = place.point ? std::max(4 * sum, along) : along;
  const auto key = [](const ContactHistory& h) { return std::tie(h.fiber_a, h.fiber_b, h.image); };
  return nearest_to<ContactHistory>(
      field_, place, reach, [&](const Proximity& p, const ContactHistory*& best, double& best_distance) {
        const auto pair = std::make_tuple(p.fiber_a(), p.fiber_b(), p.image());
        auto h = std::lower_bound(history_.begin(), history_.end(),
                                  std::make_tuple(p.fiber_a(), p.fiber_b(), p.image(), p.s_a() - reach),
                                  [](const ContactHistory& c, const auto& k) { return c.place() < k; });
        for (; h != history_.end() && key(*h) == pair && h->s_a <= p.s_a() + reach; ++h) {
          double distance = 0.5 * (std::abs(h->s_a - p.s_a()) + std::abs(h->s_b - p.s_b()));
          if (h->point != p.point) distance = 0.5 * (distance + reach);
          if (distance < best_distance) {
            best_distance = distance;
            best = &*h;
          }
        }
      });
}

void Contact::set_history(std::vector<ContactHistory> history, std::vector<Vec3> tractions) {
  history_ = std::move(history);
  if (law_.friction) tractions_ = std::move(tractions);
  for (ContactHistory& h : history_) {
    h.gap_offset = h.raised_at = 0;  // they were for the stage that is over
    if (!law_.friction) h.traction = -1;
  }
  note_loaded_particles();
}

double Contact::in_first_period(Index fiber, double s) const {
  const double length = field_.mesh().length(fiber);
  return field_.mesh().period(fiber) < 0 ? s : s - length * std::floor(s / length);
}

/// Only penalties that adapt differ from place to place.
void Contact::note_loaded_particles() {
  if (!law_.adapt_penalty) return;
  loaded_.clear();
  for (const ContactHistory& h : history_)
    if (h.touches) {
      loaded_.push_back({h.fiber_a, in_first_period(h.fiber_a, h.s_a), std::log(h.penalty_scale)});
      loaded_.push_back({h.fiber_b, in_first_period(h.fiber_b, h.s_b), std::log(h.penalty_scale)});
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
  const auto collect_around = [&](const Foot& foot) {
    const double s = in_first_period(foot.fiber, foot.s);
    collect(foot.fiber, s);
    if (field_.mesh().period(foot.fiber) < 0) return;
    for (const double n_periods : {-1.0, 1.0}) collect(foot.fiber, s + n_periods * field_.mesh().length(foot.fiber));
  };
  collect_around(p.chord.a);
  collect_around(p.chord.b);
  return n > 0 ? std::exp(sum / n) : 1;
}

ContactElement Contact::make_element(const Proximity& p, const State& state, const ContactHistory* known,
                                     const ContactElement* before) const {
  ContactElement e;
  e.pair = p;
  e.feet_at_iteration = {p.chord.a, p.chord.b};
  e.lean_at_iteration = p.lean;
  e.fiber_a = p.fiber_a();
  e.fiber_b = p.fiber_b();
  e.length = p.length;
  e.crossing = p.point;
  e.radius_a = field_.mesh().radius[e.fiber_a];
  e.radius_b = field_.mesh().radius[e.fiber_b];
  for (const Index fiber : {e.fiber_a, e.fiber_b})
    if (field_.model(fiber) == FiberModel::rod) e.offset += field_.mesh().radius[fiber];
  if (known) {
    e.has_side = true;
    e.side = before ? before->side : known->normal;
    e.gap_offset = known->gap_offset;
    // A preload belongs to one element and not to all that come up around it.
    const double near = p.point ? mean_radius(e.fiber_a, e.fiber_b) : 0.5 * spacing(e.fiber_a, e.fiber_b);
    const Vec2 ds = without_periods(field_, e.fiber_a, e.fiber_b, {known->s_a - p.s_a(), known->s_b - p.s_b()});
    if (known->point == p.point && 0.5 * (std::abs(ds[0]) + std::abs(ds[1])) < near) {
      e.preload = known->preload;
      e.raised_at = known->raised_at;
      e.stuck = known->stuck;
    }
  } else if (before && before->gap() < 0) {  // what is apart may turn
    e.has_side = before->has_side;
    e.side = before->side;
  }
  e.offset -= fading_ * e.gap_offset;
  e.unit_penalty = law_.penalty * std::min(modulus_[e.fiber_a], modulus_[e.fiber_b]) * e.length;
  e.set_scale(known ? known->penalty_scale : law_.adapt_penalty ? starting_scale(p) : 1);
  e.next_scale = e.penalty_scale;
  e.next_preload = e.preload;
  measure(field_, state, e);
  hold_in_valley(field_, state, e);
  if (!e.has_side && e.measured.inverse_distance != 0) {
    e.has_side = true;
    e.side = e.measured.normal;
  }
  place_particles(field_, e);
  (void)e.covered.cover(field_, e.pair.chord.a, e.pair.chord.b);
  return e;
}

/// Friction at the feet as they are: the limit is that of the force there, the slip that of the particles there.
StickSlip Contact::make_stick_slip(ContactElement& e, const ContactHistory* known) const {
  StickSlip s;
  place_particles(field_, e);
  s.normal = e.measured.force_direction.normalized();
  s.x_start = e.relative_position(field_.layout(), start_);
  s.slip_limit = law_.friction_coefficient * e.normal_force(regularisation(e));
  s.tangential_stiffness = s.slip_limit / (law_.reversible_slip * mean_radius(e.fiber_a, e.fiber_b));
  if (known && known->traction >= 0) {
    // Tractions go with the length that the element stands for.
    const double share = known->length > 0 ? e.length / known->length : 1;
    s.begin_with(share * s.tangential(tractions_[known->traction]));
  }
  return s;
}

void Contact::update(const State& state, bool keep) {
  ++n_searches_;
  // Of the elements of the last search in this increment those stay that are at the same place, with the preloads that
  // they have come to. With `keep` they stay as they are, and what has pressed since stays even if it would no longer
  // be found: what comes and goes with each search would never settle.
  std::vector<ContactElement> before = std::exchange(elements_, {});
  followed_.clear();
  for (ContactElement& e : before) e.has_pressed = keep && (e.has_pressed || e.force(regularisation(e)) > 0);
  const std::vector<StickSlip> stick_slip_before = std::exchange(stick_slip_, {});
  const std::vector<const ContactElement*> sorted_before = in_order(before);
  struct Found {
    Proximity pair;
    const ContactElement* before;
  };
  std::vector<Found> found;
  std::vector<char> found_again(before.size(), 0);
  std::vector<KnownPoint> known_points;
  for (const ContactHistory& h : history_)
    if (h.point && (h.touches || h.preload > 0))
      known_points.push_back({h.fiber_a, h.fiber_b, h.image, h.s_a, h.s_b, h.length});
  for (Proximity& p : find_proximities(field_, state, law_.search, known_points)) {
    const double near = p.point ? mean_radius(p.fiber_a(), p.fiber_b()) : 0.25 * spacing(p.fiber_a(), p.fiber_b());
    const ContactElement* same = same_place(field_, sorted_before, p, near);
    if (same && found_again[same - before.data()]) {
      if (keep) continue;  // a second lowest point beside the one that it is
      same = nullptr;
    }
    if (same) found_again[same - before.data()] = 1;
    if (same && keep) p = same->pair;
    found.push_back({p, same});
  }
  for (std::size_t i = 0; i < before.size() && keep; ++i)
    if (!found_again[i] && before[i].has_pressed) found.push_back({before[i].pair, &before[i]});
  if (keep)
    std::stable_sort(found.begin(), found.end(), [](const Found& x, const Found& y) {
      const Proximity &p = x.pair, &q = y.pair;
      return std::make_tuple(p.fiber_a(), p.fiber_b(), p.image(), p.s_a(), p.s_b()) <
             std::make_tuple(q.fiber_a(), q.fiber_b(), q.image(), q.s_a(), q.s_b());
    });
  elements_.resize(found.size());
  known_.resize(found.size());
  if (law_.friction) stick_slip_.resize(found.size());
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < found.size(); ++i) {
    known_[i] = find_history(found[i].pair);
    ContactElement& e = elements_[i] = make_element(found[i].pair, state, known_[i], found[i].before);
    if (const ContactElement* same = found[i].before; same && (keep || same->penetration_before > 0)) {
      e.preload = same->preload;
      e.stuck = same->stuck;
      e.penetration_before = same->penetration_before;
      e.set_scale(same->penalty_scale);
    }
    e.has_pressed = keep && ((found[i].before && found[i].before->has_pressed) || e.force(regularisation(e)) > 0);
    if (!law_.friction) continue;
    if (keep && found[i].before) {
      stick_slip_[i] = stick_slip_before[found[i].before - before.data()];
      e.a = found[i].before->a;
      e.b = found[i].before->b;
    } else {
      stick_slip_[i] = make_stick_slip(e, known_[i]);
    }
  }
  if (slip_energy_n_) return;
  slip_energy_n_ = slip_energy_at_start(stick_slip_);
  elements_n_ = elements_;
}

bool Contact::concerns(const ContactElement& e, const Region& region) const {
  return region.has(field_.element_node(e.fiber_a, 0)) || region.has(field_.element_node(e.fiber_b, 0));
}

bool Contact::follow(const State& state, Follow what, const Region& region) {
  bool grown = false;
  // An iteration begins where the last trial was.
  const bool is_followed = state.q == followed_;
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    ContactElement& e = elements_[i];
    if (is_followed || !concerns(e, region)) continue;
    // From where the feet were when the iteration began: a long step that is tried and given up leaves no trace.
    e.pair.chord.a = e.feet_at_iteration[0];
    e.pair.chord.b = e.feet_at_iteration[1];
    e.pair.lean = e.lean_at_iteration;
    micro::follow(field_, state, e);
  }
  followed_ = state.q;
  if (law_.friction && renews_limits(what)) {
#pragma omp parallel for schedule(static)
    for (std::size_t i = 0; i < elements_.size(); ++i)
      if (concerns(elements_[i], region)) stick_slip_[i] = make_stick_slip(elements_[i], known_[i]);
  }
  if (is_trial(what)) return false;
#pragma omp parallel for schedule(static) reduction(|| : grown)
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    ContactElement& e = elements_[i];
    if (!concerns(e, region)) continue;
    e.feet_at_iteration = {e.pair.chord.a, e.pair.chord.b};
    e.lean_at_iteration = e.pair.lean;
    e.turn_side();
    grown = e.covered.cover(field_, e.pair.chord.a, e.pair.chord.b) || grown;
  }
  return grown;
}

void Contact::limit_reach(const State& state, std::span<double> reach) const {
  const FiberMesh& mesh = field_.mesh();
  const Layout& layout = field_.layout();
  std::vector<Eigen::AlignedBox3d> boxes(mesh.n_fibers());
  for (Index f = 0; f < mesh.n_fibers(); ++f) {
    for (Index n = field_.element_node(f, 0); n <= field_.last_node(f); ++n)
      boxes[f].extend(state.q[layout.first_vector(n)]);
    boxes[f].min().array() -= 1.5 * mesh.radius[f];  // and what bulges between nodes
    boxes[f].max().array() += 1.5 * mesh.radius[f];
  }
#pragma omp parallel for schedule(dynamic, 16)
  for (Index f = 0; f < mesh.n_fibers(); ++f) {
    // In a periodic cell there are images all around.
    const bool has_company = law_.search.self_contact || field_.is_periodic();
    double apart = has_company ? 0 : std::numeric_limits<double>::infinity();
    for (Index g = 0; g < mesh.n_fibers() && apart > 0; ++g)
      if (g != f) apart = std::min(apart, boxes[f].exteriorDistance(boxes[g]));
    for (Index n = field_.element_node(f, 0); n <= field_.last_node(f); ++n)
      reach[layout.first_vector(n)] = std::min(reach[layout.first_vector(n)], 0.5 * apart);
  }
}

double Contact::slip_energy(const State& state) const {
  double sum = 0;
  for (std::size_t i = 0; i < stick_slip_.size(); ++i)
    if (stick_slip_[i].tangential_stiffness > 0)
      sum += 0.5 * friction_of(i, state).force.squaredNorm() / stick_slip_[i].tangential_stiffness;
  return sum;
}

void Contact::add_sparsity(Pattern::Builder& builder) const {
  for (const ContactElement& e : elements_) e.covered.add_sparsity(field_, e.pair.chord.a, e.pair.chord.b, builder);
}

void Contact::add(const State& state, Assembler& assembler) const {
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    if (!concerns(elements_[i], assembler.region())) continue;
    add_contact_element(field_, elements_[i], regularisation(elements_[i]), assembler);
    if (law_.friction) add_friction(elements_[i], stick_slip_[i], field_.layout(), state, assembler);
  }
}

void Contact::add_unsymmetric(const State& state, UnsymmetricTerms& terms) const {
  // As many parts whatever the number of threads.
  constexpr std::size_t n_parts = 8;
  std::array<UnsymmetricTerms, n_parts> parts;
  const std::size_t n = stick_slip_.size();
#pragma omp parallel for schedule(dynamic, 1)
  for (std::size_t part = 0; part < n_parts; ++part)
    for (std::size_t i = part * n / n_parts; i < (part + 1) * n / n_parts; ++i)
      add_friction_by_limit(field_, elements_[i], stick_slip_[i], law_.friction_coefficient,
                            regularisation(elements_[i]), state, parts[part]);
  for (const UnsymmetricTerms& part : parts) terms.append(part);
}

Friction Contact::friction_of(std::size_t i, const State& state) const {
  return friction(stick_slip_[i], elements_[i].relative_position(field_.layout(), state));
}

double Contact::penalty_energy_at(const State& state) const {
  double sum = 0;
  for (ContactElement e : elements_) {
    micro::follow(field_, state, e);
    sum += e.energy(regularisation(e));
  }
  return sum;
}

double Contact::energy(const State& state) const {
  double sum = penalty_energy_at(state);
  for (std::size_t i = 0; i < stick_slip_.size(); ++i) sum += friction_of(i, state).energy;
  return sum;
}

Ledger Contact::ledger(const State& state) const {
  Ledger ledger = booked_;
  ledger.stored = penalty_energy_at(state) + slip_energy(state);
  return ledger;
}

double Contact::max_penetration_over_radius() const {
  double largest = 0;
  for (const ContactElement& e : elements_) largest = std::max(largest, -e.gap() / mean_radius(e.fiber_a, e.fiber_b));
  return largest;
}

bool Contact::stiffen(const State&, double elastic_energy, double slack) {
  if (!law_.adapt_penalty) return false;
  const Stiffening done = raise_where_too_soft(
      elements_, law_.target_penetration, elastic_energy, slack,
      [&](const ContactElement& e) { return mean_radius(e.fiber_a, e.fiber_b); },
      [&](const ContactElement& e) { return regularisation(e); });
  preloads_are_due_ = done.due;
  return done.raised;
}

std::vector<double> Contact::book_changes(const State& state) {
  const auto at = [](const PenaltyLaw& law, double gap) { return ContactAt{law.force(gap), law.energy(gap)}; };
  // With the last law that it had, and the first one.
  const auto law_of = [&](const ContactElement& e) { return e.law(regularisation(e)); };
  const auto first_law_of = [&](const ContactElement& e) { return PenaltyLaw{e.penalty, 0, regularisation(e)}; };
  const std::size_t n = elements_n_.size();
  std::vector<ContactAt> start(n), end(n);
  std::vector<double> start_gap(n);
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < n; ++i) {
    ContactElement& e = elements_n_[i];
    start[i] = at(law_of(e), e.gap());
    start_gap[i] = e.gap();
    micro::follow(field_, state, e);
    end[i] = at(law_of(e), e.gap());
  }
  std::vector<double> gap_at_start(elements_.size());
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    ContactElement e = elements_[i];
    micro::follow(field_, start_, e);
    gap_at_start[i] = e.gap();
    micro::follow(field_, state, elements_[i]);
  }
  const std::vector<const ContactElement*> sorted = in_order(elements_n_);
  std::vector<double> force_at_start(elements_.size());
  std::vector<char> went_on(n, 0);
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    const ContactElement& e = elements_[i];
    const double along = 0.25 * spacing(e.fiber_a, e.fiber_b);
    const ContactElement* same =
        same_place(field_, sorted, e.pair, e.crossing ? std::max(mean_radius(e.fiber_a, e.fiber_b), along) : along);
    const std::size_t j = same ? same - elements_n_.data() : 0;
    if (!same || std::exchange(went_on[j], 1) != 0) {
      const PenaltyLaw first = first_law_of(e);
      const ContactAt before = at(first, gap_at_start[i]);
      force_at_start[i] = before.force;
      booked_[Source::contacts] += energy_brought(before, at(first, e.gap()));
      booked_[Source::preloads] += work_of_new_law(gap_at_start[i], e.gap(), first, law_of(e));
      continue;
    }
    // It may stand for more or less of the fibers than it did; the rest of what changed is its law. (Of the gap that
    // an offset has closed, the same trapezoid stands in that line.)
    const double share = e.length / same->length;
    force_at_start[i] = share * start[j].force;
    booked_[Source::contacts] += (share - 1) * energy_brought(start[j], end[j]);
    booked_[Source::preloads] +=
        work_of_new_law(start_gap[j], e.gap(), {share * same->penalty, same->preload, regularisation(e)}, law_of(e));
  }
  for (std::size_t j = 0; j < n; ++j)
    if (!went_on[j]) booked_[Source::contacts] -= energy_brought(start[j], end[j]);
  return force_at_start;
}

void Contact::commit(const State& state) {
  const std::vector<double> force_at_start = book_changes(state);
  double gap_offset_force = 0;
  for (const ContactElement& e : elements_) gap_offset_force += e.gap_offset * e.force(regularisation(e));
  booked_[Source::gap_offsets] += 0.5 * (gap_offset_force_n_ + gap_offset_force) * (fading_n_ - fading_);
  gap_offset_force_n_ = gap_offset_force;
  fading_n_ = fading_;
  booked_[Source::friction_limits] += slip_energy_at_start(stick_slip_) - *slip_energy_n_;
  slip_energy_n_ = slip_energy(state);
  tractions_.resize(stick_slip_.size());
  for (std::size_t i = 0; i < stick_slip_.size(); ++i) {
    const Friction slip = friction_of(i, state);
    // The limit has gone from that of the force at the step's start to what it is.
    if (slip.slides)
      booked_[Sink::friction] +=
          0.5 * (1 + force_at_start[i] / elements_[i].force(regularisation(elements_[i]))) * slip.dissipated;
    tractions_[i] = slip.force;
  }
  for (ContactElement& e : elements_)
    e.accept(e.gap(), e.force(regularisation(e)), regularisation(e), law_.adapt_penalty && preloads_are_due_);
  if (law_.adapt_penalty) adapt_penalties();
  elements_n_ = elements_;
  history_.resize(elements_.size());
  for (std::size_t i = 0; i < elements_.size(); ++i)
    history_[i] = remember(field_, elements_[i], law_.friction ? static_cast<Index>(i) : -1);
  std::ranges::stable_sort(history_, {}, &ContactHistory::place);
  known_.clear();
  note_loaded_particles();
}

void Contact::keep(Archive& archive) {
  archive(history_, tractions_, fading_n_, gap_offset_force_n_, slip_energy_n_, elements_n_, booked_);
  if (!archive.reads()) return;
  const auto on_fiber = [&](Index fiber, double s) {
    return fiber >= 0 && fiber < field_.mesh().n_fibers() && std::isfinite(s);
  };
  for (const ContactHistory& h : history_)
    archive.require(on_fiber(h.fiber_a, h.s_a) && on_fiber(h.fiber_b, h.s_b) && h.penalty_scale > 0 &&
                        std::isfinite(h.penalty_scale) && h.normal.allFinite() &&
                        h.traction < static_cast<Index>(tractions_.size()),
                    "a contact that cannot be");
  for (const ContactElement& e : elements_n_)
    archive.require(e.pair.chord.a.is_on(field_.mesh()) && e.pair.chord.b.is_on(field_.mesh()),
                    "a contact that cannot be");
  // Elements are looked for anew in each increment.
  elements_.clear();
  known_.clear();
  stick_slip_.clear();
  note_loaded_particles();
}

/// Where penetrations are deep, as they may be on the way to an equilibrium: zone by zone, up to eight consecutive
/// samples of a pair. It acts from the next step on: the elements stay as they are in the equilibrium, for what is
/// recorded of it.
void Contact::adapt_penalties() {
  constexpr std::size_t zone_samples = 8;
  for (std::size_t begin = 0; begin < elements_.size();) {
    const ContactElement& first = elements_[begin];
    std::size_t end = begin;
    double penetration = 0, scale = 0;
    while (end < elements_.size() && end - begin < zone_samples && elements_[end].fiber_a == first.fiber_a &&
           elements_[end].fiber_b == first.fiber_b && elements_[end].pair.image() == first.pair.image() &&
           (end == begin || elements_[end].s_a - elements_[end - 1].s_a < 2 * first.length)) {
      const ContactElement& e = elements_[end++];
      if (!e.stuck) penetration = std::max(penetration, -e.gap());
      scale = std::max(scale, e.penalty_scale);
    }
    const double target = deepest_over_target * law_.target_penetration * mean_radius(first.fiber_a, first.fiber_b);
    if (penetration <= target) {
      begin = end;
      continue;
    }
    scale = adapted_penalty_scale(scale, penetration / target);
    for (; begin < end; ++begin) elements_[begin].adapt(scale, regularisation(elements_[begin]));
  }
}

}  // namespace trame::micro
