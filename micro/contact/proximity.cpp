#include "micro/contact/proximity.h"

#include <Eigen/LU>
#include <algorithm>
#include <tuple>

namespace trame::micro {

namespace {

constexpr double crossing_cosine = 0.8660254037844387;  // 30°: beyond, samples would miss the closest point

struct Sample {
  Index fiber;
  double s;
  Vec3 r, tangent;
  std::uint64_t cell;
};

/// A sample of an intermediate geometry (k = its number) or, with `crossing`, a guess of a closest approach.
struct Candidate {
  Index fiber_a, fiber_b;
  int sense;
  std::int64_t k;
  double s_a, s_b, distance;
};

std::uint64_t cell_key(std::int64_t x, std::int64_t y, std::int64_t z) {
  constexpr std::int64_t offset = 1 << 20, mask = (1 << 21) - 1;
  const auto part = [](std::int64_t i) { return static_cast<std::uint64_t>((i + offset) & mask); };
  return part(x) << 42 | part(y) << 21 | part(z);
}

double pair_spacing(const FiberField& field, const ProximitySearch& search, Index a, Index b) {
  return search.spacing * 0.5 * (field.element_length(a) + field.element_length(b));
}

double reach(const FiberField& field, const ProximitySearch& search, Index a, Index b) {
  const double sum = field.mesh().radius[a] + field.mesh().radius[b];
  return sum * (1 + 0.5 * search.search_margin);
}

/// Samples of all fibers, sorted by grid cell.
std::vector<Sample> sample_fibers(const FiberField& field, const State& state, const ProximitySearch& search,
                                  double cell_size) {
  const FiberMesh& mesh = field.mesh();
  std::vector<std::size_t> first(mesh.n_fibers() + 1, 0);
  for (Index f = 0; f < mesh.n_fibers(); ++f) {
    const double spacing = search.spacing * field.element_length(f);
    first[f + 1] = first[f] + static_cast<std::size_t>(std::ceil(mesh.length(f) / spacing - 1e-9));
  }
  std::vector<Sample> samples(first.back());
#pragma omp parallel for schedule(static)
  for (Index f = 0; f < mesh.n_fibers(); ++f) {
    const double step = mesh.length(f) / static_cast<double>(first[f + 1] - first[f]);
    for (std::size_t i = first[f]; i < first[f + 1]; ++i) {
      const double s = (static_cast<double>(i - first[f]) + 0.5) * step;
      const auto [r, tangent] = field.curve(state, f, s);
      const Eigen::Array<std::int64_t, 3, 1> c = (r / cell_size).array().floor().cast<std::int64_t>();
      samples[i] = {f, s, r, tangent, cell_key(c[0], c[1], c[2])};
    }
  }
  std::sort(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) {
    return std::tie(a.cell, a.fiber, a.s) < std::tie(b.cell, b.fiber, b.s);
  });
  return samples;
}

/// Adds what two close samples suggest: the two samples of the intermediate geometry around them, or a crossing.
void suggest(const FiberField& field, const ProximitySearch& search, const Sample* a, const Sample* b,
             std::vector<Candidate>& sampled, std::vector<Candidate>& crossings) {
  if (std::tie(a->fiber, a->s) > std::tie(b->fiber, b->s)) std::swap(a, b);
  if (a->fiber == b->fiber) {
    // A fiber is always near itself along its own course.
    const double r = field.mesh().radius[a->fiber];
    if (!search.self_contact || b->s - a->s < 6 * r + 2 * search.spacing * field.element_length(a->fiber)) return;
  }
  if (search.wanted && !search.wanted(a->fiber, b->fiber)) return;
  const double spacing = pair_spacing(field, search, a->fiber, b->fiber);
  const double distance = (b->r - a->r).norm();
  const double contact = reach(field, search, a->fiber, b->fiber);
  if (distance > std::hypot(contact, spacing)) return;
  const double cosine = a->tangent.dot(b->tangent) / std::sqrt(a->tangent.squaredNorm() * b->tangent.squaredNorm());
  const int sense = cosine >= 0 ? 1 : -1;
  if (std::abs(cosine) < crossing_cosine) {
    crossings.push_back({a->fiber, b->fiber, sense, 0, a->s, b->s, distance});
    return;
  }
  const double tau = 0.5 * (a->s + sense * b->s);
  const auto k = static_cast<std::int64_t>(std::floor(tau / spacing));
  sampled.push_back({a->fiber, b->fiber, sense, k, a->s, b->s, distance});
  sampled.push_back({a->fiber, b->fiber, sense, k + 1, a->s, b->s, distance});
}

auto order(const Candidate& c) { return std::make_tuple(c.fiber_a, c.fiber_b, c.sense, c.k, c.distance, c.s_a); }

void gather_candidates(const FiberField& field, const ProximitySearch& search, const std::vector<Sample>& samples,
                       double cell_size, std::vector<Candidate>& sampled, std::vector<Candidate>& crossings) {
  // Half of the 27 neighbours, so that each pair of cells is visited once.
  static constexpr int half[13][3] = {{1, 0, 0},  {-1, 1, 0}, {0, 1, 0},  {1, 1, 0}, {-1, -1, 1},
                                      {0, -1, 1}, {1, -1, 1}, {-1, 0, 1}, {0, 0, 1}, {1, 0, 1},
                                      {-1, 1, 1}, {0, 1, 1},  {1, 1, 1}};
  const auto in_cell = [&](std::uint64_t key) {
    return std::lower_bound(samples.begin(), samples.end(), key,
                            [](const Sample& s, std::uint64_t k) { return s.cell < k; });
  };
  for (auto begin = samples.begin(); begin != samples.end();) {
    auto end = begin;
    while (end != samples.end() && end->cell == begin->cell) ++end;
    for (auto i = begin; i != end; ++i)
      for (auto j = i + 1; j != end; ++j) suggest(field, search, &*i, &*j, sampled, crossings);
    const Eigen::Array<std::int64_t, 3, 1> c = (begin->r / cell_size).array().floor().cast<std::int64_t>();
    for (const auto& d : half) {
      const std::uint64_t key = cell_key(c[0] + d[0], c[1] + d[1], c[2] + d[2]);
      for (auto j = in_cell(key); j != samples.end() && j->cell == key; ++j)
        for (auto i = begin; i != end; ++i) suggest(field, search, &*i, &*j, sampled, crossings);
    }
    begin = end;
  }
}

/// Solves the sampled candidates in parallel; keeps those in reach.
std::vector<Proximity> solve_sampled(const FiberField& field, const State& state, const ProximitySearch& search,
                                     const std::vector<Candidate>& candidates) {
  std::vector<Proximity> found(candidates.size());
  std::vector<char> keep(candidates.size(), 0);
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Candidate& c = candidates[i];
    Proximity& p = found[i];
    p.fiber_a = c.fiber_a;
    p.fiber_b = c.fiber_b;
    p.length = pair_spacing(field, search, c.fiber_a, c.fiber_b);
    double u = 0.5 * (c.s_a - c.sense * c.s_b);
    keep[i] = intermediate_chord(field, state, p, c.sense, static_cast<double>(c.k) * p.length, u) &&
              p.chord.norm() <= reach(field, search, c.fiber_a, c.fiber_b);
  }
  std::size_t n = 0;
  for (std::size_t i = 0; i < found.size(); ++i)
    if (keep[i]) found[n++] = found[i];
  found.resize(n);
  return found;
}

/// Solves crossings, nearest guesses first; guesses of the same crossing give one element.
void solve_crossings(const FiberField& field, const State& state, const ProximitySearch& search,
                     const std::vector<Candidate>& candidates, std::vector<Proximity>& found) {
  const std::size_t n_sampled = found.size();
  for (auto begin = candidates.begin(); begin != candidates.end();) {
    auto end = begin;
    while (end != candidates.end() && end->fiber_a == begin->fiber_a && end->fiber_b == begin->fiber_b) ++end;
    const double contact = reach(field, search, begin->fiber_a, begin->fiber_b);
    const double same = 2 * contact + pair_spacing(field, search, begin->fiber_a, begin->fiber_b);
    const std::size_t first = found.size();
    // Where the fibers already meet in samples, beside a stretch at a smaller angle, there is no crossing to add.
    const auto of_pair = std::equal_range(
        found.begin(), found.begin() + static_cast<std::ptrdiff_t>(n_sampled), *begin,
        [](const auto& p, const auto& q) { return std::tie(p.fiber_a, p.fiber_b) < std::tie(q.fiber_a, q.fiber_b); });
    const std::vector<Proximity> sampled(of_pair.first, of_pair.second);
    const auto known = [&](double s_a, double s_b) {
      const auto near = [&](const Proximity& p) {
        return std::abs(p.s_a - s_a) < same && std::abs(p.s_b - s_b) < same;
      };
      return std::any_of(found.begin() + static_cast<std::ptrdiff_t>(first), found.end(), near) ||
             std::any_of(sampled.begin(), sampled.end(), near);
    };
    for (auto c = begin; c != end; ++c) {
      if (known(c->s_a, c->s_b)) continue;
      Proximity p;
      p.fiber_a = c->fiber_a;
      p.fiber_b = c->fiber_b;
      p.s_a = c->s_a;
      p.s_b = c->s_b;
      p.length = field.mesh().radius[p.fiber_a] + field.mesh().radius[p.fiber_b];
      p.crossing = true;
      if (closest_approach(field, state, p) && p.chord.norm() <= contact && !known(p.s_a, p.s_b)) found.push_back(p);
    }
    begin = end;
  }
}

/// Whether s lies on a fiber. Round-off at an end does not decide: what is off by less than 1e-6 of the length is put
/// on it.
bool settle_on_fiber(double& s, double length) {
  const double inside = std::clamp(s, 0.0, length);
  const bool on_fiber = std::abs(s - inside) <= 1e-6 * length;
  if (on_fiber) s = inside;
  return on_fiber;
}

}  // namespace

bool intermediate_chord(const FiberField& field, const State& state, Proximity& pair, double sense, double tau,
                        double& u) {
  const double length_a = field.mesh().length(pair.fiber_a), length_b = field.mesh().length(pair.fiber_b);
  const double tolerance = 1e-10 * (length_a + length_b);
  double du = 0;
  for (int iteration = 0; iteration < 30; ++iteration) {
    pair.s_a = tau + u;
    pair.s_b = sense * (tau - u);
    // Iterates may overshoot an end; a solution may not.
    const auto a = field.curve(state, pair.fiber_a, std::clamp(pair.s_a, 0.0, length_a));
    const auto b = field.curve(state, pair.fiber_b, std::clamp(pair.s_b, 0.0, length_b));
    const Vec3 tangent = a.tangent + sense * b.tangent;
    pair.chord = b.r - a.r;
    du = pair.chord.dot(tangent) / tangent.squaredNorm();
    if (std::abs(du) < tolerance) return settle_on_fiber(pair.s_a, length_a) && settle_on_fiber(pair.s_b, length_b);
    u += du;
  }
  return false;
}

bool closest_approach(const FiberField& field, const State& state, Proximity& pair) {
  const double length_a = field.mesh().length(pair.fiber_a), length_b = field.mesh().length(pair.fiber_b);
  const double tolerance = 1e-10 * (length_a + length_b);
  for (int iteration = 0; iteration < 30; ++iteration) {
    const auto a = field.curve(state, pair.fiber_a, std::clamp(pair.s_a, 0.0, length_a));
    const auto b = field.curve(state, pair.fiber_b, std::clamp(pair.s_b, 0.0, length_b));
    pair.chord = b.r - a.r;
    Eigen::Matrix2d m;
    m << a.tangent.squaredNorm(), -a.tangent.dot(b.tangent), -a.tangent.dot(b.tangent), b.tangent.squaredNorm();
    const Vec2 step = m.inverse() * Vec2(pair.chord.dot(a.tangent), -pair.chord.dot(b.tangent));
    if (!step.allFinite()) return false;
    if (step.norm() < tolerance) return settle_on_fiber(pair.s_a, length_a) && settle_on_fiber(pair.s_b, length_b);
    pair.s_a += step[0];
    pair.s_b += step[1];
  }
  return false;
}

Proximity facing(const FiberField& field, const State& state, Proximity pair) {
  const auto a = field.curve(state, pair.fiber_a, pair.s_a), b = field.curve(state, pair.fiber_b, pair.s_b);
  const Vec3 chord = b.r - a.r;
  if (pair.crossing) {
    const Vec3 normal = a.tangent.cross(b.tangent).normalized();
    pair.chord = normal.dot(chord) * normal;
  } else {
    const double sense = a.tangent.dot(b.tangent) >= 0 ? 1 : -1;
    const Vec3 tangent = (a.tangent + sense * b.tangent).normalized();
    pair.chord = chord - tangent.dot(chord) * tangent;
  }
  return pair;
}

std::vector<Proximity> find_proximities(const FiberField& field, const State& state, const ProximitySearch& search) {
  const FiberMesh& mesh = field.mesh();
  double largest_reach = 0;
  for (Index f = 0; f < mesh.n_fibers(); ++f)
    largest_reach = std::max(largest_reach, std::hypot(reach(field, search, f, f), pair_spacing(field, search, f, f)));
  if (mesh.n_fibers() == 0) return {};
  const std::vector<Sample> samples = sample_fibers(field, state, search, largest_reach);

  std::vector<Candidate> sampled, crossings;
  gather_candidates(field, search, samples, largest_reach, sampled, crossings);
  const auto by_order = [](const Candidate& a, const Candidate& b) { return order(a) < order(b); };
  const auto same_sample = [](const Candidate& a, const Candidate& b) {
    return a.fiber_a == b.fiber_a && a.fiber_b == b.fiber_b && a.sense == b.sense && a.k == b.k;
  };
  std::sort(sampled.begin(), sampled.end(), by_order);
  // The nearest candidate stands for a sample. Of two places where fibers meet at the same mean arc length only that
  // one is kept.
  sampled.erase(std::unique(sampled.begin(), sampled.end(), same_sample), sampled.end());
  for (Candidate& c : crossings) c.sense = 0;
  std::sort(crossings.begin(), crossings.end(), by_order);

  std::vector<Proximity> found = solve_sampled(field, state, search, sampled);
  solve_crossings(field, state, search, crossings, found);
  std::sort(found.begin(), found.end(), [](const Proximity& a, const Proximity& b) {
    return std::tie(a.fiber_a, a.fiber_b, a.s_a, a.s_b) < std::tie(b.fiber_a, b.fiber_b, b.s_a, b.s_b);
  });
  return found;
}

}  // namespace trame::micro
