#include "micro/contact/proximity.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace trame::micro {

namespace {

struct Sample {
  Index fiber;
  Index number;  // along the fiber
  Image image;
  double s;
  Vec3 r, tangent;
  double curvature;  // |r''|
  std::uint64_t cell;
};

/// Two samples so close that their fibers may touch between them and the next ones.
struct Near {
  const Sample *a, *b;
  double distance;
};

/// A sample of an intermediate geometry, k = its number, and a guess of u.
struct Candidate {
  Foot a, b;
  int sense;
  std::int64_t k;
  double u, distance;
};

std::uint64_t cell_key(std::int64_t x, std::int64_t y, std::int64_t z) {
  constexpr std::int64_t offset = 1 << 20, mask = (1 << 21) - 1;
  const auto part = [](std::int64_t i) { return static_cast<std::uint64_t>((i + offset) & mask); };
  return part(x) << 42 | part(y) << 21 | part(z);
}

double fiber_spacing(const FiberField& field, const ProximitySearch& search, Index fiber) {
  return search.spacing * field.element_length(fiber);
}
/// Spacing of the samples of a pair: fine enough for both.
double pair_spacing(const FiberField& field, const ProximitySearch& search, Index a, Index b) {
  return search.spacing * std::min(field.element_length(a), field.element_length(b));
}
/// Of the samples of a pair whose fibers come back together: a whole number of them in the mean of both periods.
struct Sampling {
  double spacing;
  std::int64_t n;  // in a period; 0: the fibers do not
};
Sampling pair_sampling(const FiberField& field, const ProximitySearch& search, Index a, Index b) {
  const double wanted = pair_spacing(field, search, a, b);
  if (!field.come_back_together(a, b)) return {wanted, 0};
  const double period = 0.5 * (field.mesh().length(a) + field.mesh().length(b));
  const double n = std::max(1.0, std::round(period / wanted));
  return {period / n, static_cast<std::int64_t>(n)};
}
double sum_of_radii(const FiberField& field, Index a, Index b) {
  return field.mesh().radius[a] + field.mesh().radius[b];
}
double smaller_radius(const FiberField& field, Index a, Index b) {
  return std::min(field.mesh().radius[a], field.mesh().radius[b]);
}
double reach(const FiberField& field, const ProximitySearch& search, Index a, Index b) {
  return sum_of_radii(field, a, b) * (1 + 0.5 * search.search_margin);
}
/// Distance of two samples beyond which no points of their stretches, half a spacing to either side, are in reach.
/// Arc lengths are those of the start; fibers are stretched by a few per cent at most.
double sample_reach(const FiberField& field, const ProximitySearch& search, Index a, Index b) {
  constexpr double stretch = 1.1;
  return reach(field, search, a, b) +
         0.5 * stretch * (fiber_spacing(field, search, a) + fiber_spacing(field, search, b));
}
/// A fiber is always near itself along its own course.
double least_arc_between(const FiberField& field, const ProximitySearch& search, Index fiber) {
  return 6 * field.mesh().radius[fiber] + 2 * fiber_spacing(field, search, fiber);
}

/// How far feet may go until they are found: they are looked for from the nearest samples.
double within_samples(const FiberField& field, const ProximitySearch& search, Index a, Index b) {
  return 2 * (fiber_spacing(field, search, a) + fiber_spacing(field, search, b));
}

std::uint64_t cell_of(const Vec3& r, double cell_size) {
  const Eigen::Array<std::int64_t, 3, 1> c = (r / cell_size).array().floor().cast<std::int64_t>();
  return cell_key(c[0], c[1], c[2]);
}

/// Adds the images of samples of a periodic cell that may be near the samples themselves. An image along the period by
/// which a fiber comes back is the fiber itself, farther on.
void add_images(const FiberField& field, const State& state, double cell_size, std::vector<Sample>& samples) {
  if (!field.is_periodic() || samples.empty()) return;
  // Coordinates along the periods, by their duals.
  Eigen::Matrix<double, 3, 2> periods, duals;
  for (int which = 0; which < 2; ++which) {
    periods.col(which) = field.period(state, which);
    if (field.period_nodes()[which] < 0) periods.col(which) = field.period(state, 1 - which).unitOrthogonal();
  }
  duals = periods * (periods.transpose() * periods).inverse();
  Vec2 low = duals.transpose() * samples.front().r, high = low;
  for (const Sample& s : samples) {
    const Vec2 x = duals.transpose() * s.r;
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const Vec2 within = cell_size * duals.colwise().norm().transpose();
  std::array<int, 2> most{};
  for (int which = 0; which < 2; ++which)
    if (field.period_nodes()[which] >= 0)
      most[which] = static_cast<int>(std::ceil(high[which] - low[which] + within[which]));
  std::vector<Index> n_samples(field.mesh().n_fibers(), 0);
  for (const Sample& s : samples) ++n_samples[s.fiber];
  const std::size_t n = samples.size();
  for (int i = -most[0]; i <= most[0]; ++i)
    for (int j = -most[1]; j <= most[1]; ++j) {
      if (i == 0 && j == 0) continue;
      const Vec3 shift = periods * Vec2(i, j);
      for (std::size_t k = 0; k < n; ++k) {
        const Vec2 x = duals.transpose() * (samples[k].r + shift);
        if ((x.array() < (low - within).array()).any() || (x.array() > (high + within).array()).any()) continue;
        Sample image = samples[k];
        image.r += shift;
        image.image = {i, j};
        if (const int own = field.mesh().period(image.fiber); own >= 0) {
          const int whole = std::exchange(image.image[own], 0);
          image.s += whole * field.mesh().length(image.fiber);
          image.number += whole * n_samples[image.fiber];
        }
        image.cell = cell_of(image.r, cell_size);
        samples.push_back(image);
      }
    }
}

/// Samples of all fibers, sorted by grid cell.
std::vector<Sample> sample_fibers(const FiberField& field, const State& state, const ProximitySearch& search,
                                  double cell_size) {
  const FiberMesh& mesh = field.mesh();
  std::vector<std::size_t> first(mesh.n_fibers() + 1, 0);
  for (Index f = 0; f < mesh.n_fibers(); ++f)
    first[f + 1] =
        first[f] + static_cast<std::size_t>(std::ceil(mesh.length(f) / fiber_spacing(field, search, f) - 1e-9));
  std::vector<Sample> samples(first.back());
#pragma omp parallel for schedule(static)
  for (Index f = 0; f < mesh.n_fibers(); ++f) {
    const double step = mesh.length(f) / static_cast<double>(first[f + 1] - first[f]);
    for (std::size_t i = first[f]; i < first[f + 1]; ++i) {
      const double s = (static_cast<double>(i - first[f]) + 0.5) * step;
      const CurveJet jet = field.curve(state, f, s);
      samples[i] = {f,
                    static_cast<Index>(i - first[f]),
                    {},
                    s,
                    jet.r,
                    jet.tangent,
                    jet.curvature.norm(),
                    cell_of(jet.r, cell_size)};
    }
  }
  add_images(field, state, cell_size, samples);
  std::sort(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) {
    return std::tie(a.cell, a.fiber, a.image, a.s) < std::tie(b.cell, b.fiber, b.image, b.s);
  });
  return samples;
}

/// Whether two samples, a the first one, stand for all pairs that are the same but for whole periods (Proximity).
bool is_canonical(const FiberField& field, const Sample& a, const Sample& b) {
  constexpr Image here{};
  if (a.image != here || (a.fiber == b.fiber && b.image < here)) return false;
  const int period = field.mesh().period(a.fiber);
  if (period >= 0 && b.image[period] != 0) return false;
  return !field.come_back_together(a.fiber, b.fiber) || (a.s >= 0 && a.s < field.mesh().length(a.fiber));
}

void keep_if_near(const FiberField& field, const ProximitySearch& search, const Sample* a, const Sample* b,
                  std::vector<Near>& near) {
  const double distance = (b->r - a->r).norm();
  if (distance > sample_reach(field, search, a->fiber, b->fiber)) return;
  const auto rank = [](const Sample& s) { return std::make_tuple(s.fiber, s.image != Image{}, s.s); };
  if (rank(*a) > rank(*b)) std::swap(a, b);
  if (field.is_periodic() && !is_canonical(field, *a, *b)) return;
  const bool is_image = b->image != Image{};
  if (a->fiber == b->fiber && !is_image &&
      (!search.self_contact || b->s - a->s < least_arc_between(field, search, a->fiber)))
    return;
  const auto yarn = [&](const Sample* s) { return field.mesh().yarn_of_fiber[s->fiber]; };
  if (search.wanted && !(is_image && yarn(a) == yarn(b)) && !search.wanted(a->fiber, b->fiber)) return;
  near.push_back({a, b, distance});
}

/// All pairs of near samples, sorted by fibers and numbers.
std::vector<Near> find_near(const FiberField& field, const ProximitySearch& search, const std::vector<Sample>& samples,
                            double cell_size) {
  // Half of the 27 neighbours, so that each pair of cells is visited once.
  static constexpr int half[13][3] = {{1, 0, 0},  {-1, 1, 0}, {0, 1, 0},  {1, 1, 0}, {-1, -1, 1},
                                      {0, -1, 1}, {1, -1, 1}, {-1, 0, 1}, {0, 0, 1}, {1, 0, 1},
                                      {-1, 1, 1}, {0, 1, 1},  {1, 1, 1}};
  std::vector<Near> near;
  const auto in_cell = [&](std::uint64_t key) {
    return std::lower_bound(samples.begin(), samples.end(), key,
                            [](const Sample& s, std::uint64_t k) { return s.cell < k; });
  };
  for (auto begin = samples.begin(); begin != samples.end();) {
    auto end = begin;
    while (end != samples.end() && end->cell == begin->cell) ++end;
    for (auto i = begin; i != end; ++i)
      for (auto j = i + 1; j != end; ++j) keep_if_near(field, search, &*i, &*j, near);
    const Eigen::Array<std::int64_t, 3, 1> c = (begin->r / cell_size).array().floor().cast<std::int64_t>();
    for (const auto& d : half) {
      const std::uint64_t key = cell_key(c[0] + d[0], c[1] + d[1], c[2] + d[2]);
      for (auto j = in_cell(key); j != samples.end() && j->cell == key; ++j)
        for (auto i = begin; i != end; ++i) keep_if_near(field, search, &*i, &*j, near);
    }
    begin = end;
  }
  const auto key = [](const Near& n) {
    return std::make_tuple(n.a->fiber, n.b->fiber, n.b->image, n.a->number, n.b->number);
  };
  std::sort(near.begin(), near.end(), [&](const Near& m, const Near& n) { return key(m) < key(n); });
  return near;
}

double cosine(const Near& n) {
  return n.a->tangent.dot(n.b->tangent) / std::sqrt(n.a->tangent.squaredNorm() * n.b->tangent.squaredNorm());
}

/// Sense of two stretches. About a right angle either will do; one that round-off cannot change is taken.
int sense_of(double cosine) { return cosine >= -0.1 ? 1 : -1; }

/// Bounds of the second derivative of the distance along the valley, from what is known at two samples: straight fibers
/// give 2(1 − |cos θ|)/d, and each curvature takes or gives as much as itself.
struct ValleyBounds {
  double low, high;
};
ValleyBounds valley_bounds(const FiberField& field, const Near& n) {
  const double straight = 2 * (1 - std::abs(cosine(n))) / sum_of_radii(field, n.a->fiber, n.b->fiber);
  const double bent = n.a->curvature + n.b->curvature;
  return {0.5 * straight - bent, 4 * (straight + bent)};
}

// Of a radius: what a contact's penetration may be. Up to the first samples do alone, from the second on points.
constexpr double rise_of_samples = 0.005, rise_of_points = 0.03;

double rise_over_half_spacing(double curvature, double spacing) { return 0.125 * curvature * spacing * spacing; }

/// Second derivative by τ of the distance, u following.
double valley_curvature(const Chord& chord, double sense, double least_distance) {
  const double d = std::max(chord.c.norm(), least_distance), slope = Vec2(1, sense).dot(chord.slope());
  return along_valley(chord.hessian(), sense) / d - slope * slope / (d * d * d);
}

double smooth_step(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

/// The numbers of the samples that may lie in the stretches of two near ones, half a spacing to either side, with the
/// guess of u that they give.
void suggest_samples(const FiberField& field, const ProximitySearch& search, const Near& n,
                     std::vector<Candidate>& candidates) {
  const Sample &a = *n.a, &b = *n.b;
  const auto [spacing, n_in_period] = pair_sampling(field, search, a.fiber, b.fiber);
  // A fiber that meets itself may come nearest where it is its own course, which is no contact: there samples do alone.
  // Between others, a valley so steep that it leaves half a spacing from its lowest point no chance to touch has none.
  constexpr double deepest = 0.2;  // of the radii: penetration
  if ((a.fiber != b.fiber || b.image != Image{}) &&
      rise_over_half_spacing(valley_bounds(field, n).low, spacing) >
          reach(field, search, a.fiber, b.fiber) - (1 - deepest) * sum_of_radii(field, a.fiber, b.fiber))
    return;
  const int sense = sense_of(cosine(n));
  const double tau = 0.5 * (a.s + sense * b.s), u = 0.5 * (a.s - sense * b.s);
  const double extent = 0.2501 * (fiber_spacing(field, search, a.fiber) + fiber_spacing(field, search, b.fiber));
  const auto last = static_cast<std::int64_t>(std::floor((tau + extent) / spacing - 0.5));
  const std::size_t first = candidates.size();
  for (auto k = static_cast<std::int64_t>(std::ceil((tau - extent) / spacing - 0.5)); k <= last; ++k)
    candidates.push_back({{a.fiber, a.s, a.image}, {b.fiber, b.s, b.image}, sense, k, u, n.distance});
  if (n_in_period == 0 || sense < 0) return;
  for (std::size_t i = first; i < candidates.size(); ++i) {
    const std::int64_t number = candidates[i].k, rest = number % n_in_period;
    candidates[i].k = rest + (rest < 0 ? n_in_period : 0);
    const std::int64_t n_periods = (number - candidates[i].k) / n_in_period;  // leaves no rest
    const Vec2 back = whole_periods(field, a.fiber, b.fiber, static_cast<double>(n_periods));
    candidates[i].u -= 0.5 * (back[0] - back[1]);
  }
}

/// The part of the cell ½ spacing to either side of τ within which both feet are on their fibers, as seen from `chord`
/// at τ; empty where low ≥ high.
struct Covered {
  double low, high;
};
Covered covered_part(const FiberField& field, const Chord& chord, double sense, double tau, double spacing) {
  const Eigen::Matrix2d h = chord.hessian();
  const Vec2 along(1, sense), across(1, -sense);
  const double cc = across.dot(h * across);
  const double du = cc > 0 ? std::clamp(-along.dot(h * across) / cc, -0.9, 0.9) : 0;  // du/dτ
  Covered part{tau - 0.5 * spacing, tau + 0.5 * spacing};
  const auto cut = [&](const Foot& foot, double rate) {  // rate: ds/dτ
    const FiberField::Ends ends = field.ends(foot.fiber);
    const double to_start = tau - (foot.s - ends.start) / rate, to_end = tau + (ends.end - foot.s) / rate;
    part.low = std::max(part.low, std::min(to_start, to_end));
    part.high = std::min(part.high, std::max(to_start, to_end));
  };
  cut(chord.a, 1 + du);
  cut(chord.b, sense * (1 - du));
  return part;
}

/// Whether two places are near each other because they are of one fiber. Another image of it is like another fiber.
bool is_own_course(const FiberField& field, const ProximitySearch& search, const Foot& a, const Foot& b) {
  return a.fiber == b.fiber && a.image == b.image && b.s - a.s < least_arc_between(field, search, a.fiber);
}

/// A sample of the intermediate geometry; nothing where its fibers are apart.
std::optional<Proximity> make_sample(const FiberField& field, const State& state, const ProximitySearch& search,
                                     const Candidate& c) {
  const double spacing = pair_sampling(field, search, c.a.fiber, c.b.fiber).spacing;
  const double contact = reach(field, search, c.a.fiber, c.b.fiber);
  const double within = within_samples(field, search, c.a.fiber, c.b.fiber);
  double tau = (static_cast<double>(c.k) + 0.5) * spacing;
  auto chord = chord_at_mean_arc_length(field, state, c.a, c.b, c.sense, tau, c.u, within);
  if (!chord || chord->c.norm() > 2 * contact + spacing) return std::nullopt;
  // A sample near an end stands for what its fibers cover of its cell, from the middle of that.
  const Covered part = covered_part(field, *chord, c.sense, tau, spacing);
  if (part.high - part.low < 1e-6 * spacing) return std::nullopt;
  if (part.high - part.low < (1 - 1e-9) * spacing) {
    const double u = 0.5 * (chord->a.s - c.sense * chord->b.s);
    tau = 0.5 * (part.low + part.high);
    chord = chord_at_mean_arc_length(field, state, c.a, c.b, c.sense, tau, u, within);
    if (!chord) return std::nullopt;
  }
  if (chord->c.norm() > contact) return std::nullopt;
  if (is_own_course(field, search, chord->a, chord->b)) return std::nullopt;
  return Proximity{*chord, part.high - part.low, 1, false, {0, static_cast<double>(c.sense), tau}};
}

bool is_at_end(const FiberField& field, const Foot& foot, double near = 0) {
  const FiberField::Ends ends = field.ends(foot.fiber);
  return foot.s <= ends.start + near || foot.s >= ends.end - near;
}

/// How far the distance of two fibers rises within half a spacing of a lowest point, to the side where it rises less;
/// without bound where a fiber ends there.
double rise_beside(const FiberField& field, const State& state, const Chord& chord, double sense, double spacing,
                   double within) {
  constexpr std::array parts{1.0, 0.5, 0.25};  // of half a spacing, within which strongly curved fibers come back
  constexpr double boundless = std::numeric_limits<double>::infinity();
  const double tau = 0.5 * (chord.a.s + sense * chord.b.s), u = 0.5 * (chord.a.s - sense * chord.b.s);
  double least = boundless;
  for (const double side : {-0.5 * spacing, 0.5 * spacing}) {
    double rise = 0;
    for (const double part : parts) {
      const auto beside =
          chord_at_mean_arc_length(field, state, chord.a, chord.b, sense, tau + part * side, u, within);
      if (!beside || is_at_end(field, beside->a) || is_at_end(field, beside->b)) return boundless;
      rise = std::max(rise, beside->c.norm() - chord.c.norm());
    }
    least = std::min(least, rise);
  }
  return least;
}

/// Which share of its surroundings a foot's fiber covers: half at an end.
double covered_share(const FiberField& field, const Foot& foot) {
  const double reach = 2 * field.mesh().radius[foot.fiber];
  const FiberField::Ends ends = field.ends(foot.fiber);
  return std::min({1.0, 0.5 + (foot.s - ends.start) / reach, 0.5 + (ends.end - foot.s) / reach});
}

/// Which share of a contact with another fiber's tip a foot has: none where it is an end itself.
double share_beside_end(const FiberField& field, const Foot& foot) {
  const FiberField::Ends ends = field.ends(foot.fiber);
  const double to_end = std::min(foot.s - ends.start, ends.end - foot.s);
  return smooth_step(to_end / (0.5 * field.mesh().radius[foot.fiber]));
}

constexpr double least_share = 1e-6;

/// The same chord with its foot a within the first period.
void bring_into_period(const FiberField& field, const State& state, Chord& chord) {
  const double whole = std::floor(chord.a.s / field.mesh().length(chord.a.fiber));
  if (whole == 0) return;
  const Vec2 back = whole_periods(field, chord.a.fiber, chord.b.fiber, whole);
  chord.a.s -= back[0];
  chord.b.s -= back[1];
  const Chord there = chord_between(field, state, chord.a, chord.b);
  chord.at_a = there.at_a;
  chord.at_b = there.at_b;
  chord.c = there.c;
}

/// What holds a point contact where it is: as much as its valley lacks to the curvature that makes a point of it.
Hold hold_at(const FiberField& field, const ProximitySearch& search, const Chord& chord) {
  const Index a = chord.a.fiber, b = chord.b.fiber;
  const double sum = sum_of_radii(field, a, b), spacing = pair_sampling(field, search, a, b).spacing,
               steep = rise_of_points * smaller_radius(field, a, b) / rise_over_half_spacing(1, spacing);
  // Sections that tilt against the chord as the feet slide can make a valley of the gap shallower than the distance's.
  const bool has_sections = field.model(a) == FiberModel::enriched || field.model(b) == FiberModel::enriched;
  const double least = has_sections ? std::max(steep, Hold::least_valley / sum) : steep;
  const int sense = sense_of(chord.cosine());
  return {std::max(0.0, least - valley_curvature(chord, sense, 0.5 * sum)) * chord.c.norm(),
          static_cast<double>(sense), 0.5 * (chord.a.s + sense * chord.b.s)};
}

/// Which share of a lowest point's surroundings it stands for, by how far the distance rises.
double share_of_point(const FiberField& field, const State& state, const ProximitySearch& search, const Chord& chord,
                      double sense) {
  const Index a = chord.a.fiber, b = chord.b.fiber;
  const double sum = sum_of_radii(field, a, b), d = std::max(chord.c.norm(), 0.5 * sum),
               spacing = pair_sampling(field, search, a, b).spacing, radius = smaller_radius(field, a, b);
  // From an end the distance rises at once.
  double rise = rise_over_half_spacing(valley_curvature(chord, sense, 0.5 * sum), spacing);
  if (is_at_end(field, chord.a)) rise += std::abs(chord.slope()[0]) / d * 0.5 * spacing;
  if (is_at_end(field, chord.b)) rise += std::abs(chord.slope()[1]) / d * 0.5 * spacing;
  // Where elements join, curvature jumps: a valley that is steep at its lowest point need not be so all around.
  if (share_of_samples(rise, radius) < 1)
    rise = std::min(rise, rise_beside(field, state, chord, sense, spacing, within_samples(field, search, a, b)));
  return 1 - share_of_samples(rise, radius);
}

/// Whether a chord may be a point contact's: its fibers are not apart, and it is none of one fiber's own course.
bool may_touch(const FiberField& field, const ProximitySearch& search, const Chord& chord) {
  return chord.c.norm() <= reach(field, search, chord.a.fiber, chord.b.fiber) &&
         !is_own_course(field, search, chord.a, chord.b);
}

/// A point contact on a chord, the lowest point of a valley or held near one, with at least a part of a length; nothing
/// where its fibers stay at this distance along a line.
std::optional<Proximity> point_on(const FiberField& field, const State& state, const ProximitySearch& search,
                                  Chord chord, double share, double least_length) {
  const Index a = chord.a.fiber, b = chord.b.fiber;
  if (field.come_back_together(a, b)) bring_into_period(field, state, chord);
  const double whole =
      std::min(covered_share(field, chord.a), covered_share(field, chord.b)) * sum_of_radii(field, a, b);
  share = std::clamp(least_length / whole, share, 1.0);
  // Tips have no contact with tips; what is one must not depend on round-off.
  const double sliver = 1e-9 * smaller_radius(field, a, b);
  if (is_at_end(field, chord.a, sliver)) share *= share_beside_end(field, chord.b);
  if (is_at_end(field, chord.b, sliver)) share *= share_beside_end(field, chord.a);
  if (share < least_share) return std::nullopt;
  return Proximity{chord, share * whole, share, true, hold_at(field, search, chord)};
}

std::optional<Proximity> make_point(const FiberField& field, const State& state, const ProximitySearch& search,
                                    const Foot& a, const Foot& b) {
  const auto chord = shortest_chord(field, state, a, b, within_samples(field, search, a.fiber, b.fiber));
  if (!chord || !may_touch(field, search, *chord)) return std::nullopt;
  return point_on(field, state, search, *chord,
                  share_of_point(field, state, search, *chord, sense_of(chord->cosine())), 0);
}

/// A known point stays where it is, should there be no lowest point near it any more, and loses what it stands for but
/// slowly. Near an end it may go at once: which tips touch there tells more than what was before.
std::optional<Proximity> keep_point(const FiberField& field, const State& state, const ProximitySearch& search,
                                    const KnownPoint& known) {
  constexpr double kept = 0.9;
  const Foot a{known.fiber_a, known.s_a, {}}, b{known.fiber_b, known.s_b, known.image};
  if (std::min(covered_share(field, a), covered_share(field, b)) < 1) return std::nullopt;
  const double within = within_samples(field, search, a.fiber, b.fiber), near = smaller_radius(field, a.fiber, b.fiber);
  const auto held =
      shortest_chord(field, state, a, b, within, hold_at(field, search, chord_between(field, state, a, b)));
  if (!held || !may_touch(field, search, *held)) return std::nullopt;
  const auto lowest = shortest_chord(field, state, a, b, within);
  const bool is_near = lowest && std::abs(lowest->a.s - a.s) < near && std::abs(lowest->b.s - b.s) < near;
  const double share = is_near ? share_of_point(field, state, search, *lowest, sense_of(lowest->cosine())) : 0;
  return point_on(field, state, search, *held, share, kept * known.length);
}

/// Pairs of samples of two fibers that are nearer than their neighbours along either fiber or both.
bool is_nearest_around(const Near* begin, const Near* end, const Near& n) {
  const auto key = [](const Near& m) { return std::make_pair(m.a->number, m.b->number); };
  for (Index i = n.a->number - 1; i <= n.a->number + 1; ++i) {
    const auto first = std::make_pair(i, n.b->number - 1), last = std::make_pair(i, n.b->number + 1);
    for (auto m = std::lower_bound(begin, end, first, [&](const Near& x, const auto& k) { return key(x) < k; });
         m != end && key(*m) <= last; ++m)
      if (m->distance < n.distance) return false;
  }
  return true;
}

/// The range of `near` of each pair of fibers.
std::vector<std::pair<const Near*, const Near*>> by_fibers(const std::vector<Near>& near) {
  std::vector<std::pair<const Near*, const Near*>> ranges;
  for (const Near *n = near.data(), *end = n + near.size(); n != end;) {
    const Near* first = n;
    while (n != end && n->a->fiber == first->a->fiber && n->b->fiber == first->b->fiber &&
           n->b->image == first->b->image)
      ++n;
    ranges.emplace_back(first, n);
  }
  return ranges;
}

/// What two fibers have in common: their samples and points.
class PairSearch {
 public:
  PairSearch(const FiberField& field, const State& state, const ProximitySearch& search, const Near* begin,
             const Near* end, std::span<const KnownPoint> known)
      : field_(field), state_(state), search_(search), begin_(begin), end_(end), known_(known) {}

  [[nodiscard]] std::vector<Proximity> find() {
    add_samples();
    add_known_points();
    add_points();
    cover();
    share_with_points();
    std::sort(found_.begin(), found_.end(), [](const Proximity& p, const Proximity& q) {
      return std::make_tuple(p.s_a(), p.s_b(), p.point) < std::make_tuple(q.s_a(), q.s_b(), q.point);
    });
    return std::move(found_);
  }

 private:
  void add_samples() {
    std::vector<Candidate> candidates;
    for (const Near* n = begin_; n != end_; ++n) suggest_samples(field_, search_, *n, candidates);
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& p, const Candidate& q) {
      return std::tie(p.sense, p.k, p.distance, p.u) < std::tie(q.sense, q.k, q.distance, q.u);
    });
    // The nearest guess stands for a sample; one that is far from it is another place at the same mean arc length.
    std::vector<double> solved;
    const Candidate* last = nullptr;
    for (const Candidate& c : candidates) {
      const double apart = fiber_spacing(field_, search_, c.a.fiber) + fiber_spacing(field_, search_, c.b.fiber);
      if (!last || last->sense != c.sense || last->k != c.k) solved.clear();
      last = &c;
      if (std::any_of(solved.begin(), solved.end(), [&](double u) { return std::abs(u - c.u) < apart; })) continue;
      solved.push_back(c.u);
      if (const auto p = make_sample(field_, state_, search_, c); p && !is_known(*p)) found_.push_back(*p);
    }
  }

  void add_points() {
    const double spacing = pair_sampling(field_, search_, begin_->a->fiber, begin_->b->fiber).spacing;
    const double radius = smaller_radius(field_, begin_->a->fiber, begin_->b->fiber);
    for (const Near* n = begin_; n != end_; ++n) {
      const bool at_end = is_last(*n->a) || is_last(*n->b);
      if (!at_end && share_of_samples(rise_over_half_spacing(valley_bounds(field_, *n).high, spacing), radius) == 1)
        continue;
      if (is_nearest_around(begin_, end_, *n)) add_point(*n);
    }
  }

  /// Two samples whose tangents come closer than touching between them and their neighbours, without a contact nearby:
  /// a place that both searches missed.
  void cover() {
    for (const Near* n = begin_; n != end_; ++n) {
      const Sample &a = *n->a, &b = *n->b;
      const double h_a = fiber_spacing(field_, search_, a.fiber), h_b = fiber_spacing(field_, search_, b.fiber);
      const Vec3 c = b.r - a.r;
      const double ta = a.tangent.squaredNorm(), tb = b.tangent.squaredNorm(), ab = a.tangent.dot(b.tangent);
      const double determinant = std::max(ta * tb - ab * ab, 1e-3 * ta * tb);
      const double along_a = c.dot(a.tangent), along_b = c.dot(b.tangent);
      const double x = std::clamp((tb * along_a - ab * along_b) / determinant, -0.5 * h_a, 0.5 * h_a);
      const double y = std::clamp((ab * x - along_b) / tb, -0.5 * h_b, 0.5 * h_b);
      const double bulge = 0.125 * (a.curvature * h_a * h_a + b.curvature * h_b * h_b);
      if ((c + y * b.tangent - x * a.tangent).norm() > sum_of_radii(field_, a.fiber, b.fiber) + bulge) continue;
      const auto beside = [&](const Proximity& p) {
        const Vec2 ds = apart(p, a.s, b.s);
        return std::abs(ds[0]) < 1.5 * h_a && std::abs(ds[1]) < 1.5 * h_b;
      };
      if (std::none_of(found_.begin(), found_.end(), beside)) add_point(*n);
    }
  }

  /// Samples leave to a point what it stands for of their surroundings: all within half a spacing, nothing from a
  /// spacing on. There the valley has risen by four times what makes a point of it.
  void share_with_points() {
    if (begin_->a->fiber == begin_->b->fiber && begin_->b->image == Image{}) return;
    const double spacing = pair_sampling(field_, search_, begin_->a->fiber, begin_->b->fiber).spacing;
    for (Proximity& sample : found_) {
      if (sample.point) continue;
      for (const Proximity& p : found_) {
        if (!p.point) continue;
        const Vec2 ds = apart(p, sample.s_a(), sample.s_b());
        const double da = ds[0], db = sample.hold.sense * ds[1];
        const double spacings = std::max(0.5 * std::abs(da + db), 0.25 * std::abs(da - db)) / spacing;
        sample.share = std::min(sample.share, 1 - p.share * (1 - smooth_step(2 * spacings - 1)));
      }
      sample.length *= sample.share;
    }
    std::erase_if(found_, [](const Proximity& p) { return p.share < least_share; });
  }

  void add_point(const Near& n) {
    const Sample &a = *n.a, &b = *n.b;
    const auto p = make_point(field_, state_, search_, {a.fiber, a.s, a.image}, {b.fiber, b.s, b.image});
    if (p && !is_known(*p)) found_.push_back(*p);
  }

  void add_known_points() {
    first_known_ = end_known_ = found_.size();
    for (const KnownPoint& k : known_)
      if (const auto p = keep_point(field_, state_, search_, k); p && !is_known(*p)) found_.push_back(*p);
    end_known_ = found_.size();
  }

  [[nodiscard]] bool is_last(const Sample& s) const {
    if (field_.mesh().period(s.fiber) >= 0) return false;
    return s.number == 0 || s.s + fiber_spacing(field_, search_, s.fiber) > field_.mesh().length(s.fiber);
  }

  /// Whether the same place was found from another guess, or a known point is held near it.
  [[nodiscard]] bool is_known(const Proximity& p) const {
    const double near = smaller_radius(field_, p.fiber_a(), p.fiber_b()), same = 1e-3 * near;
    const auto is_within = [&](const Proximity& q, double distance) {
      const Vec2 ds = apart(p, q.s_a(), q.s_b());
      return q.point == p.point && std::abs(ds[0]) < distance && std::abs(ds[1]) < distance;
    };
    const auto known = std::span(found_).subspan(first_known_, end_known_ - first_known_);
    return std::any_of(found_.begin(), found_.end(), [&](const Proximity& q) { return is_within(q, same); }) ||
           std::any_of(known.begin(), known.end(), [&](const Proximity& q) { return is_within(q, near); });
  }

  /// How far a place of the pair is from given arc lengths.
  [[nodiscard]] Vec2 apart(const Proximity& p, double s_a, double s_b) const {
    return without_periods(field_, p.fiber_a(), p.fiber_b(), {p.s_a() - s_a, p.s_b() - s_b});
  }

  const FiberField& field_;
  const State& state_;
  const ProximitySearch& search_;
  const Near *begin_, *end_;
  std::span<const KnownPoint> known_;
  std::vector<Proximity> found_;
  std::size_t first_known_ = 0, end_known_ = 0;  // of what has been found
};

}  // namespace

PlacesInCell in_first_periods(const FiberMesh& mesh, Index fiber_a, Index fiber_b, PlacesInCell pair) {
  const auto wrap = [&](Index fiber, double& s, int sign) {
    const int period = mesh.period(fiber);
    if (period < 0) return;
    const double whole = std::floor(s / mesh.length(fiber));
    s -= whole * mesh.length(fiber);
    pair.image[period] += sign * static_cast<int>(whole);
  };
  wrap(fiber_a, pair.s_a, -1);
  wrap(fiber_b, pair.s_b, 1);
  return pair;
}

PlacesInCell counted_on(const FiberMesh& mesh, Index fiber_a, Index fiber_b, PlacesInCell pair) {
  const auto unwrap = [&](Index fiber, double& s, int sign) {
    if (const int period = mesh.period(fiber); period >= 0)
      s += sign * std::exchange(pair.image[period], 0) * mesh.length(fiber);
  };
  unwrap(fiber_b, pair.s_b, 1);
  unwrap(fiber_a, pair.s_a, -1);
  return pair;
}

double share_of_samples(double rise, double radius) {
  return 1 - smooth_step((rise / radius - rise_of_samples) / (rise_of_points - rise_of_samples));
}

std::vector<Proximity> find_proximities(const FiberField& field, const State& state, const ProximitySearch& search,
                                        std::span<const KnownPoint> known) {
  const FiberMesh& mesh = field.mesh();
  if (mesh.n_fibers() == 0) return {};
  double cell_size = 0;
  for (Index f = 0; f < mesh.n_fibers(); ++f) cell_size = std::max(cell_size, sample_reach(field, search, f, f));
  const std::vector<Sample> samples = sample_fibers(field, state, search, cell_size);
  const std::vector<Near> near = find_near(field, search, samples, cell_size);
  const auto pairs = by_fibers(near);
  std::vector<std::vector<Proximity>> of_pair(pairs.size());
#pragma omp parallel for schedule(dynamic, 64)
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto [begin, end] = pairs[i];
    const auto pair = std::make_tuple(begin->a->fiber, begin->b->fiber, begin->b->image);
    const auto first = std::lower_bound(known.begin(), known.end(), pair,
                                        [](const KnownPoint& k, const auto& p) { return k.pair() < p; });
    const auto last = std::upper_bound(first, known.end(), pair,
                                       [](const auto& p, const KnownPoint& k) { return p < k.pair(); });
    of_pair[i] = PairSearch(field, state, search, begin, end, {first, last}).find();
  }
  std::vector<Proximity> found;
  for (const auto& part : of_pair) found.insert(found.end(), part.begin(), part.end());
  return found;
}

void follow(const FiberField& field, const State& state, Proximity& pair) {
  const Foot &a = pair.chord.a, &b = pair.chord.b;
  const double within = std::max(field.element_length(a.fiber), field.element_length(b.fiber));
  const auto chord = pair.point
                         ? shortest_chord(field, state, a, b, within, pair.hold, pair.lean)
                         : chord_at_mean_arc_length(field, state, a, b, pair.hold.sense, pair.hold.mean_arc_length,
                                                    0.5 * (a.s - pair.hold.sense * b.s), within, pair.lean);
  pair.chord = chord ? *chord : chord_between(field, state, a, b);
}

}  // namespace trame::micro
