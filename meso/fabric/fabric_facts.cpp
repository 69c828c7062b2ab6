#include "meso/fabric/fabric_facts.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "meso/fabric/plan_cover.h"
#include "meso/sections/crossings.h"
#include "meso/sections/sections.h"
#include "micro/fiber/lagrange.h"

namespace trame::meso {
namespace {

using micro::FiberConfiguration;
using micro::FiberMesh;
using micro::Yarn;
using micro::YarnFamily;

constexpr double infinity = std::numeric_limits<double>::infinity();

MeanDeviation mean_deviation(const std::vector<double>& values) {
  MeanDeviation result;
  const auto n = static_cast<double>(values.size());
  for (const double value : values) result.mean += value / n;
  for (const double value : values) result.deviation += (value - result.mean) * (value - result.mean) / n;
  result.deviation = std::sqrt(result.deviation);
  return values.empty() ? MeanDeviation{std::nan(""), std::nan("")} : result;
}

/// The part of a yarn from its first crossing to its last, as fractions of its fibers' lengths.
struct Span {
  double from = infinity, to = -infinity;

  void take(double fraction) {
    from = std::min(from, fraction);
    to = std::max(to, fraction);
  }
};

/// All crossings of a weave, its yarns in the order in which they lie.
struct Crossings {
  std::vector<Index> warp, weft;          ///< yarns
  std::vector<std::vector<Crossing>> at;  ///< of each weft yarn with each warp yarn; the warp's curve is the first
  Index n_layers = 1;                     ///< weft yarns in a row that lie above each other: a column

  [[nodiscard]] Index n_warp() const { return static_cast<Index>(warp.size()); }
  [[nodiscard]] Index n_weft() const { return static_cast<Index>(weft.size()); }
  [[nodiscard]] Index n_columns() const { return n_weft() / n_layers; }
  /// Of the layers of a column, below how many a warp yarn is above.
  [[nodiscard]] Index level(Index column, Index warp_yarn) const {
    Index level = 0;
    for (Index i = column * n_layers; i < (column + 1) * n_layers; ++i) level += at[i][warp_yarn].above ? 1 : 0;
    return level;
  }
};

/// Puts yarns in the order of the fractions at which one of the other family meets them.
template <class Fraction>
void order_yarns(std::vector<Index>& order, const Fraction& fraction) {
  std::sort(order.begin(), order.end(), [&](Index k, Index l) { return fraction(k) < fraction(l); });
}

std::optional<Crossings> crossings_of(const FiberMesh& mesh, const FiberConfiguration& fibers, Index n_layers) {
  Crossings found;
  std::vector<std::vector<Vec3>> warp_curves, weft_curves;
  for (Index y = 0; y < static_cast<Index>(mesh.yarns.size()); ++y) {
    if (mesh.yarns[y].family == YarnFamily::free) continue;
    const bool is_warp = mesh.yarns[y].family == YarnFamily::warp;
    (is_warp ? found.warp : found.weft).push_back(y);
    (is_warp ? warp_curves : weft_curves).push_back(mean_curve(mesh, fibers, y));
  }
  if (found.n_warp() < 2 || found.n_weft() < 2 * n_layers) return std::nullopt;
  std::vector<std::vector<Crossing>> at(weft_curves.size());
  for (std::size_t i = 0; i < weft_curves.size(); ++i)
    for (const auto& warp_curve : warp_curves) {
      const auto place = crossing(warp_curve, weft_curves[i]);
      if (!place) return std::nullopt;
      at[i].push_back(*place);
    }
  std::vector<Index> columns, rows;
  for (Index j = 0; j < found.n_warp(); ++j) columns.push_back(j);
  for (Index i = 0; i < found.n_weft(); ++i) rows.push_back(i);
  order_yarns(columns, [&](Index j) { return at[0][j].second_fraction; });
  order_yarns(rows, [&](Index i) { return at[i][0].first_fraction; });
  Crossings ordered;
  ordered.n_layers = n_layers;
  for (const Index j : columns) ordered.warp.push_back(found.warp[j]);
  for (const Index i : rows) {
    ordered.weft.push_back(found.weft[i]);
    auto& row = ordered.at.emplace_back();
    for (const Index j : columns) row.push_back(at[i][j]);
  }
  return ordered;
}

/// The lattice that fits the crossings best: yarn j of the warp meets column i of the weft near origin + j a + i b.
struct Lattice {
  Vec2 origin = Vec2::Zero(), a = Vec2::Zero(), b = Vec2::Zero();

  [[nodiscard]] double cell_area() const { return std::abs(a.x() * b.y() - a.y() * b.x()); }
  /// (j, i), with fractions between yarns.
  [[nodiscard]] Vec2 coordinates(const Vec2& x) const {
    Eigen::Matrix2d axes;
    axes << a, b;
    return axes.inverse() * (x - origin);
  }
};

Lattice lattice_of(const Crossings& crossings) {
  const Index n_warp = crossings.n_warp(), n_weft = crossings.n_weft(), n_layers = crossings.n_layers,
              n_columns = crossings.n_columns();
  Lattice lattice;
  Vec2 centre = Vec2::Zero();
  for (const auto& row : crossings.at) {
    lattice.a += (row.back().position - row.front().position) / (n_weft * (n_warp - 1));
    for (const Crossing& crossing : row) centre += crossing.position / (n_warp * n_weft);
  }
  for (Index j = 0; j < n_warp; ++j)
    for (Index layer = 0; layer < n_layers; ++layer)
      lattice.b += (crossings.at[n_weft - n_layers + layer][j].position - crossings.at[layer][j].position) /
                   (n_warp * n_layers * (n_columns - 1));
  lattice.origin = centre - 0.5 * (n_warp - 1) * lattice.a - 0.5 * (n_columns - 1) * lattice.b;
  return lattice;
}

/// Means over some yarns, and sums.
struct YarnsOfSystem {
  std::vector<double> crimp, take_up, linear_density, width, height;
  double mass = 0, fiber_volume = 0;
};

void add_yarn(const FiberMesh& mesh, const Yarn& yarn, const FiberConfiguration& fibers,
              const std::vector<double>& density, const Span& span, YarnsOfSystem& sum) {
  const YarnSections sections(mesh, yarn, fibers);
  const double length = sections.at_fraction(span.to).arc_length - sections.at_fraction(span.from).arc_length;
  const double straight = (sections.mean_position(span.to) - sections.mean_position(span.from)).head<2>().norm();
  sum.crimp.push_back(length / straight - 1);
  sum.take_up.push_back(1 - straight / length);
  for (Index k = 0; k < default_stations; ++k) {
    const Section section = sections.at_fraction(span.from + (k + 0.5) / default_stations * (span.to - span.from));
    if (section.status != SectionStatus::ok) continue;
    sum.width.push_back(section.shape.width);
    sum.height.push_back(section.shape.height);
  }
  double mass = 0;
  for (Index f = yarn.first_fiber; f < yarn.first_fiber + yarn.n_fibers; ++f) {
    const double volume = std::numbers::pi * mesh.radius[f] * mesh.radius[f] * (span.to - span.from) * mesh.length(f);
    sum.fiber_volume += volume;
    mass += density[f] * volume;
  }
  sum.linear_density.push_back(mass / length);
  sum.mass += mass;
}

SystemFacts system_facts(const YarnsOfSystem& yarns, double spacing, double area) {
  SystemFacts facts{.n_yarns = static_cast<Index>(yarns.crimp.size()), .spacing = spacing};
  facts.linear_density = mean_deviation(yarns.linear_density).mean;
  facts.crimp = mean_deviation(yarns.crimp);
  facts.take_up = mean_deviation(yarns.take_up).mean;
  facts.width = mean_deviation(yarns.width);
  facts.height = mean_deviation(yarns.height);
  facts.cover = std::min(facts.width.mean / spacing, 1.0);
  facts.areal_density = yarns.mass / area;
  return facts;
}

/// A piece of fiber, straight, with its section.
struct FiberPoint {
  Vec3 r = Vec3::Zero(), g1 = Vec3::Zero(), g2 = Vec3::Zero();
  double radius = 0;

  /// How far the section goes along a unit vector.
  [[nodiscard]] double reach(const Vec3& direction) const {
    return radius * std::hypot(g1.dot(direction), g2.dot(direction));
  }
};

std::vector<std::vector<FiberPoint>> points_of_fibers(const FiberMesh& mesh, const FiberConfiguration& fibers) {
  constexpr int n_per_element = 8;
  std::vector<std::vector<FiberPoint>> points(static_cast<std::size_t>(mesh.n_fibers()));
  for (Index f = 0; f < mesh.n_fibers(); ++f) {
    if (mesh.yarns[mesh.yarn_of_fiber[f]].family == YarnFamily::free) continue;
    const double radius = std::isfinite(mesh.radius[f]) ? mesh.radius[f] : 0;
    for (Index first = mesh.first_node[f]; first + 2 < mesh.first_node[f + 1]; first += 2)
      for (int k = 0; k <= n_per_element; ++k) {
        const double start = mesh.arc_length[first], end = mesh.arc_length[first + 2];
        const micro::LagrangeShape shape =
            micro::lagrange_shape(&mesh.arc_length[first], start + (end - start) * k / n_per_element);
        points[f].push_back({shape.interpolate(fibers.r, first), shape.interpolate(fibers.g1, first),
                             shape.interpolate(fibers.g2, first), radius});
      }
  }
  return points;
}

/// Highest and lowest point of the fibers near each crossing, and of all.
class Heights {
 public:
  Heights(const Crossings& crossings, const Lattice& lattice, const std::vector<std::vector<FiberPoint>>& points)
      : crossings_(crossings), cells_(static_cast<std::size_t>(crossings.n_columns()),
                                      std::vector<Range>(static_cast<std::size_t>(crossings.n_warp()))) {
    for (const auto& fiber : points)
      for (const FiberPoint& point : fiber) {
        all_.take(point);
        const Vec2 at = lattice.coordinates(point.r.head<2>());
        const auto j = static_cast<Index>(std::lround(at[0])), i = static_cast<Index>(std::lround(at[1]));
        if (i >= 0 && j >= 0 && i < crossings.n_columns() && j < crossings.n_warp()) cells_[i][j].take(point);
      }
  }

  [[nodiscard]] double of_all() const { return all_.high - all_.low; }
  /// Between the mean of the crowns of the highest kind, and the same below: where warp yarns are above all, or so many
  /// layers of weft.
  [[nodiscard]] double between_crowns() const {
    double top = -infinity, bottom = infinity;
    for (Index level = 0; level <= crossings_.n_layers; ++level) {
      std::vector<double> high, low;
      for (Index i = edge(crossings_.n_columns()); i < crossings_.n_columns() - edge(crossings_.n_columns()); ++i)
        for (Index j = edge(crossings_.n_warp()); j < crossings_.n_warp() - edge(crossings_.n_warp()); ++j) {
          if (crossings_.level(i, j) != level) continue;
          high.push_back(cells_[i][j].high);
          low.push_back(cells_[i][j].low);
        }
      if (high.empty()) continue;
      top = std::max(top, mean_deviation(high).mean);
      bottom = std::min(bottom, mean_deviation(low).mean);
    }
    return top - bottom;
  }

 private:
  struct Range {
    double low = infinity, high = -infinity;

    void take(const FiberPoint& point) {
      const double reach = point.reach(Vec3::UnitZ());
      low = std::min(low, point.r.z() - reach);
      high = std::max(high, point.r.z() + reach);
    }
  };
  /// Outermost yarns have nothing beside them that holds them down; they are left out where others remain.
  static Index edge(Index n_yarns) { return n_yarns >= 4 ? 1 : 0; }

  const Crossings& crossings_;
  std::vector<std::vector<Range>> cells_;
  Range all_;
};

double projected_cover(const Crossings& crossings, const Lattice& lattice,
                       const std::vector<std::vector<FiberPoint>>& points) {
  constexpr Index points_a_spacing = 128, most_points = 2048;
  const auto n_points = [&](Index n_yarns) { return std::min(most_points, points_a_spacing * (n_yarns - 1)); };
  std::vector<Strip> strips;
  for (const auto& fiber : points)
    for (std::size_t k = 0; k + 1 < fiber.size(); ++k) {
      Strip strip{fiber[k].r.head<2>(), fiber[k + 1].r.head<2>(), 0};
      const Vec2 along = strip.q - strip.p;
      if (along.norm() == 0) continue;  // the end of an element is the start of the next
      const Vec3 across(-along.y() / along.norm(), along.x() / along.norm(), 0);
      strip.half_width = 0.5 * (fiber[k].reach(across) + fiber[k + 1].reach(across));
      strips.push_back(strip);
    }
  const Index n_warp = crossings.n_warp(), n_columns = crossings.n_columns();
  return plan_cover(strips, lattice.origin, (n_warp - 1) * lattice.a, (n_columns - 1) * lattice.b, n_points(n_warp),
                    n_points(n_columns));
}

}  // namespace

std::optional<FabricFacts> fabric_facts(const FiberMesh& mesh, const FiberConfiguration& fibers,
                                        const std::vector<double>& density, Index weft_layers) {
  const std::optional<Crossings> crossings = crossings_of(mesh, fibers, weft_layers);
  if (!crossings) return std::nullopt;
  const Index n_warp = crossings->n_warp(), n_weft = crossings->n_weft(), n_columns = crossings->n_columns();
  std::vector<Span> warp_spans(crossings->warp.size()), weft_spans(crossings->weft.size());
  for (Index i = 0; i < n_weft; ++i)
    for (Index j = 0; j < n_warp; ++j) {
      warp_spans[j].take(crossings->at[i][j].first_fraction);
      weft_spans[i].take(crossings->at[i][j].second_fraction);
    }
  YarnsOfSystem warp, weft;
  for (Index j = 0; j < n_warp; ++j)
    add_yarn(mesh, mesh.yarns[crossings->warp[j]], fibers, density, warp_spans[j], warp);
  for (Index i = 0; i < n_weft; ++i)
    add_yarn(mesh, mesh.yarns[crossings->weft[i]], fibers, density, weft_spans[i], weft);

  const Lattice lattice = lattice_of(*crossings);
  const double cell = lattice.cell_area(), warp_area = n_warp * (n_columns - 1) * cell,
               weft_area = n_columns * (n_warp - 1) * cell;
  const auto points = points_of_fibers(mesh, fibers);
  const Heights heights(*crossings, lattice, points);
  FabricFacts facts;
  facts.warp = system_facts(warp, cell / lattice.b.norm(), warp_area);
  facts.weft = system_facts(weft, cell / lattice.a.norm(), weft_area);
  facts.thickness = heights.between_crowns();
  facts.outline_thickness = heights.of_all();
  facts.cover_factor = facts.warp.cover + facts.weft.cover - facts.warp.cover * facts.weft.cover;
  facts.projected_cover = projected_cover(*crossings, lattice, points);
  facts.areal_density = facts.warp.areal_density + facts.weft.areal_density;
  facts.volume_fraction = (warp.fiber_volume / warp_area + weft.fiber_volume / weft_area) / facts.thickness;
  return facts;
}

}  // namespace trame::meso
