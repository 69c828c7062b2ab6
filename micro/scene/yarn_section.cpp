#include "micro/scene/yarn_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

#include "micro/core/error.h"

namespace trame::micro {

namespace {

std::vector<Vec2> centred(std::vector<Vec2> points) {
  Vec2 mean = Vec2::Zero();
  for (const Vec2& p : points) mean += p / static_cast<double>(points.size());
  for (Vec2& p : points) p -= mean;
  return points;
}

}  // namespace

std::vector<Vec2> hexagonal_section(Index n, Index n_layers, double a) {
  const double row_height = a * std::numbers::sqrt3 / 2;
  std::vector<Vec2> centres;
  if (n_layers > 0) {
    // Rows are centred, then shifted by a quarter so that each stands in the gaps of the one below: centred rows of
    // equal parity stand above each other, rows of unequal parity in the gaps already.
    double shift = n_layers == 1 ? 0 : -0.25;
    for (Index row = 0, left = n, before = 0; row < n_layers; ++row) {
      const Index in_row = (left + n_layers - row - 1) / (n_layers - row);
      left -= in_row;
      if (row > 0 && (in_row - before) % 2 == 0) shift = -shift;
      before = in_row;
      for (Index i = 0; i < in_row; ++i)
        centres.emplace_back(a * (i - 0.5 * (in_row - 1) + shift), row_height * (row - 0.5 * (n_layers - 1)));
    }
    return centred(std::move(centres));
  }
  const auto reach = static_cast<Index>(std::ceil(std::sqrt(n))) + 1;
  for (Index row = -reach; row <= reach; ++row)
    for (Index i = -reach; i <= reach; ++i) centres.emplace_back(a * (i + 0.5 * (row & 1)), row_height * row);
  // Distances are compared with a slack, so that points of one ring keep a fixed order.
  std::stable_sort(centres.begin(), centres.end(),
                   [&](const Vec2& p, const Vec2& q) { return p.norm() < q.norm() - 1e-9 * a; });
  centres.resize(n);
  return centred(std::move(centres));
}

namespace {

/// Outline of a yarn of random lay, for fibers of radius 1: half width and half height of a rectangle, or a radius.
struct Outline {
  bool round = true;
  double half_width = 0, half_height = 0;

  /// The nearest place to `p` where a fiber lies inside.
  [[nodiscard]] Vec2 inside(const Vec2& p) const {
    if (round) return p.norm() > half_width - 1 ? Vec2(p * ((half_width - 1) / p.norm())) : p;
    return {std::clamp(p[0], 1 - half_width, half_width - 1), std::clamp(p[1], 1 - half_height, half_height - 1)};
  }
};

Outline random_outline(Index n, Index n_layers, double volume_fraction) {
  const double area = std::numbers::pi * n / volume_fraction;
  if (n_layers == 0) return {true, std::sqrt(area / std::numbers::pi), 0};
  const double rows_per_width = n_layers * (std::numbers::sqrt3 / 2) / std::ceil(static_cast<double>(n) / n_layers);
  const double width = std::sqrt(area / rows_per_width);
  return {false, width / 2, area / width / 2};
}

/// Moves what is nearer than `distance` apart, each pair by half of what it lacks. Returns the least distance there
/// was.
double push_apart(std::vector<Vec2>& points, double distance) {
  std::sort(points.begin(), points.end(), [](const Vec2& p, const Vec2& q) { return p[1] < q[1]; });
  double least = std::numeric_limits<double>::infinity();
  std::vector<Vec2> pushes(points.size(), Vec2::Zero());
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size() && points[j][1] - points[i][1] < distance; ++j) {
      const Vec2 apart = points[j] - points[i];
      const double d = apart.norm();
      least = std::min(least, d);
      if (d >= distance) continue;
      const Vec2 push = 0.5 * (distance - d) * (d > 0 ? Vec2(apart / d) : Vec2::UnitX());
      pushes[i] -= push;
      pushes[j] += push;
    }
  for (std::size_t i = 0; i < points.size(); ++i) points[i] += pushes[i];
  return least;
}

}  // namespace

std::optional<std::vector<Vec2>> random_section(Index n, Index n_layers, double volume_fraction, std::uint64_t seed) {
  const Outline outline = random_outline(n, n_layers, volume_fraction);
  if (outline.half_width < 1 || (!outline.round && outline.half_height < 1)) return std::nullopt;
  std::mt19937_64 random(seed);
  // The library's distributions differ from machine to machine.
  const auto coordinate = [&](double half) { return half * (2 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1); };
  std::vector<Vec2> points;
  while (static_cast<Index>(points.size()) < n) {
    const double x = coordinate(outline.half_width),
                 y = coordinate(outline.round ? outline.half_width : outline.half_height);
    if (!outline.round || std::hypot(x, y) <= outline.half_width) points.push_back(outline.inside({x, y}));
  }
  constexpr int most_rounds = 3000;
  constexpr double aim = 2.02, enough = 2.002;
  for (int round = 0; round < most_rounds; ++round) {
    std::vector<Vec2> pushed = points;
    if (push_apart(pushed, aim) >= enough) return points;
    for (Vec2& p : pushed) p = outline.inside(p);
    points = std::move(pushed);
  }
  return std::nullopt;
}

std::vector<Vec2> yarn_section(const YarnKind& kind, double radius, Index yarn) {
  if (kind.volume_fraction == 0)
    return hexagonal_section(kind.n_fibers, kind.n_layers, 2 * radius * kind.lattice_spacing);
  auto section = random_section(kind.n_fibers, kind.n_layers, kind.volume_fraction,
                                static_cast<std::uint64_t>(kind.seed) * 1'000'003 + static_cast<std::uint64_t>(yarn));
  if (!section)
    throw InputError(fmt::format("no random lay of {} fibers was found that fills {:g} of its outline; must be less",
                                 kind.n_fibers, kind.volume_fraction));
  for (Vec2& p : *section) p *= radius;
  return *section;
}

namespace {

/// Half width and half height of what a yarn takes, whichever its number; only hexagonal yarns without twist lie
/// nearer.
Vec2 half_extent(const YarnKind& kind, double radius) {
  if (kind.volume_fraction > 0) {
    const Outline outline = random_outline(kind.n_fibers, kind.n_layers, kind.volume_fraction);
    return radius * Vec2(outline.half_width, outline.round ? outline.half_width : outline.half_height);
  }
  Vec2 most = Vec2::Zero();
  double farthest = 0;
  for (const Vec2& c : yarn_section(kind, radius, 0)) {
    most = most.cwiseMax(c.cwiseAbs());
    farthest = std::max(farthest, c.norm());
  }
  if (kind.twist != 0) most = Vec2::Constant(farthest);
  return most + Vec2::Constant(radius);
}

bool is_plain(const YarnKind& kind) { return kind.volume_fraction == 0 && kind.twist == 0; }

}  // namespace

double yarn_height(const YarnKind& kind, double radius) {
  if (!is_plain(kind)) return 2 * half_extent(kind, radius)[1];
  double low = 0, high = 0;
  for (const Vec2& c : yarn_section(kind, radius, 0)) {
    low = std::min(low, c[1]);
    high = std::max(high, c[1]);
  }
  return high - low + 2 * radius;
}

double system_height(const Scene& scene, const YarnSystem& yarns) {
  double most = 0;
  for (const YarnKind& kind : yarns.kinds)
    most = std::max(most, yarn_height(kind, scene.fiber_types[kind.type].radius));
  return most;
}

StartHeights start_heights(const Scene& scene) {
  const Weave& weave = *scene.weave;
  const Index n_layers = weave.weft.n_layers;
  const double height = system_height(scene, weave.warp) + system_height(scene, weave.weft);
  StartHeights start{std::vector<double>(static_cast<std::size_t>(weave.warp.n_yarns)),
                     std::vector<double>(static_cast<std::size_t>(weave.weft.n_yarns)), 0.5 * height};
  if (n_layers == 1) return start;
  start.deepest = 0;
  for (std::size_t i = 0; i < start.weft.size(); ++i) {
    start.weft[i] = (static_cast<Index>(i) % n_layers - 0.5 * (n_layers - 1)) * height;
    for (std::size_t j = 0; j < start.warp.size(); ++j)
      start.warp[j] += (weave.warp_above[i][j] ? 0.5 : -0.5) * height / weave.weft.n_columns();
  }
  for (std::size_t i = 0; i < start.weft.size(); ++i)
    for (std::size_t j = 0; j < start.warp.size(); ++j) {
      const double rise = start.weft[i] - start.warp[j];
      start.deepest = std::max(start.deepest, 0.5 * height + (weave.warp_above[i][j] ? rise : -rise));
    }
  return start;
}

double least_yarn_spacing(const YarnKind& a, double radius_a, const YarnKind& b, double radius_b) {
  if (!is_plain(a) || !is_plain(b)) return half_extent(a, radius_a)[0] + half_extent(b, radius_b)[0];
  const auto by_height = [](const Vec2& p, const Vec2& q) { return p[1] < q[1]; };
  std::vector<Vec2> left = yarn_section(a, radius_a, 0), right = yarn_section(b, radius_b, 0);
  std::sort(left.begin(), left.end(), by_height);
  std::sort(right.begin(), right.end(), by_height);
  const double reach = radius_a + radius_b;
  double least = 0;
  std::size_t first = 0;
  for (const Vec2& p : left) {
    while (first < right.size() && right[first][1] < p[1] - reach) ++first;
    for (std::size_t i = first; i < right.size() && right[i][1] < p[1] + reach; ++i) {
      const double dy = right[i][1] - p[1];
      least = std::max(least, p[0] - right[i][0] + std::sqrt(reach * reach - dy * dy));
    }
  }
  return least;
}

}  // namespace trame::micro
