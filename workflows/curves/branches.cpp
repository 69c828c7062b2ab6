#include "workflows/curves/branches.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "micro/scene/weave.h"
#include "workflows/curves/test_curve.h"
#include "workflows/program/csv.h"

namespace trame::workflows {

namespace {

using Point = Curve::Point;

/// Of the range of a curve: what is less is none.
constexpr double negligible = 1e-3;

void add_points(const CurvesTable& table, std::size_t motion, std::size_t reaction, double per, Curve& curve) {
  for (const CurvesTable::Row& row : table.rows)
    curve.points.push_back({row.stage, row.stage_time, row.values[motion], row.values[reaction] / per});
}

/// A side that keeps its distance still carries a force; its curve goes over the strain of the other.
std::vector<Curve> side_curves(const CurvesTable& table, const std::optional<micro::Scene>& scene) {
  constexpr double smallest_strain = 1e-12;
  std::vector<Curve> curves;
  const auto strains = [&](std::size_t column) {
    return std::any_of(table.rows.begin(), table.rows.end(),
                       [&](const auto& row) { return std::abs(row.values[column]) > smallest_strain; });
  };
  for (const std::size_t side : {0, 1}) {
    const auto own = table.find(side_columns[side]), other = table.find(side_columns[1 - side]),
               force = table.find(side_columns[side + 2]);
    if (!own || !other || !force) continue;
    const bool works = strains(*own) || !strains(*other);
    const auto strain = works ? own : other;
    Curve curve{std::string(side == 0 ? "warp sides" : "weft sides") + (works       ? ""
                                                                        : side == 0 ? ", over the weft strain"
                                                                                    : ", over the warp strain"),
                "1",
                "N",
                {},
                {},
                works};
    double per = 1;
    if (scene && scene->weave) {
      per = cell_width(*scene->weave, side == 0);
      curve.reaction_unit = "N/m";
    }
    add_points(table, *strain, *force, per, curve);
    for (const Point& point : curve.points)
      if (std::abs(point.motion) > smallest_strain) curve.stages.insert(point.stage);
    if (!curve.stages.empty()) curves.push_back(std::move(curve));
  }
  return curves;
}

/// The stages that drive a dof, but for those in which it follows.
std::set<std::string> driving_stages(const micro::Scene& scene, const std::string& body, micro::BodyDof dof) {
  std::set<std::string> stages;
  for (const micro::DrivenDof& driven : micro::driven_dofs(scene, {body}))
    for (std::size_t s = 0; s < scene.stages.size() && driven.dof == dof; ++s)
      if (driven.modes[s] && driven.modes[s] != micro::DriveMode::follow) stages.insert(scene.stages[s].name);
  return stages;
}

/// The body and dof that a column of motions is of.
std::optional<std::pair<std::string, micro::BodyDof>> dof_of(const std::string& column) {
  const std::size_t dot = column.rfind('.');
  if (dot == std::string::npos) return std::nullopt;
  for (int d = 0; d < micro::n_body_dofs; ++d) {
    const auto dof = static_cast<micro::BodyDof>(d);
    if (dof_columns(column.substr(0, dot), dof)[0] == column) return std::pair(column.substr(0, dot), dof);
  }
  return std::nullopt;
}

double slope(const Point& p, const Point& q) { return (q.reaction - p.reaction) / (q.motion - p.motion); }

double work_between(const Point& p, const Point& q) { return 0.5 * (p.reaction + q.reaction) * (q.motion - p.motion); }

/// ∫ reaction d motion along points of a branch, as far as its motion lies between low and high.
double work_within(const std::vector<Point>& points, std::size_t first, std::size_t last, double low, double high) {
  double work = 0;
  for (std::size_t i = first; i < last; ++i) {
    Point p = points[i], q = points[i + 1];
    const auto clip = [low, high, from = points[i], to = points[i + 1]](Point& end) {
      const double at = std::clamp(end.motion, low, high);
      if (at == end.motion) return;
      end.reaction = from.reaction + slope(from, to) * (at - from.motion);
      end.motion = at;
    };
    if (std::max(p.motion, q.motion) <= low || std::min(p.motion, q.motion) >= high) continue;
    clip(p);
    clip(q);
    work += work_between(p, q);
  }
  return work;
}

/// The work of the cycle of two branches that meet in a point.
double loop_of(const std::vector<Point>& points, const Branch& there, const Branch& back) {
  const double turn = points[back.first].motion, a = points[there.first].motion, c = points[back.last].motion;
  const double nearer = std::abs(a - turn) < std::abs(c - turn) ? a : c;
  const double low = std::min(turn, nearer), high = std::max(turn, nearer);
  return work_within(points, there.first, there.last, low, high) +
         work_within(points, back.first, back.last, low, high);
}

struct Ranges {
  double motion = 0, reaction = 0;
};

Ranges ranges_of(const Curve& curve) {
  double least = 0, most = 0, reaction = 0;
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const Point& point = curve.points[i];
    least = i == 0 ? point.motion : std::min(least, point.motion);
    most = i == 0 ? point.motion : std::max(most, point.motion);
    reaction = std::max(reaction, std::abs(point.reaction));
  }
  return {most - least, reaction};
}

Branch branch_of(const std::vector<Point>& points, std::size_t first, std::size_t last, const Ranges& ranges) {
  Branch branch{.first = first, .last = last};
  // An increment without motion has no slope.
  const auto moves = [&](std::size_t i) { return points[i].motion != points[i + 1].motion; };
  std::size_t from = first, to = last - 1;
  while (from < to && !moves(from)) ++from;
  while (to > from && !moves(to)) --to;
  branch.initial_stiffness = slope(points[from], points[from + 1]);
  branch.tangent_stiffness = slope(points[to], points[to + 1]);
  for (std::size_t i = first; i < last; ++i) branch.work += work_between(points[i], points[i + 1]);
  const double start = points[first].reaction, end = points[last].reaction, small = 0.05 * ranges.reaction;
  const bool changes_sign = start * end < 0 && std::abs(start) > small && std::abs(end) > small;
  branch.kind = changes_sign      ? Branch::Kind::reversal
                : branch.work < 0 ? Branch::Kind::unloading
                                  : Branch::Kind::loading;
  return branch;
}

/// The points where motion turns, in first … last, with both.
std::vector<std::size_t> turns_of(const std::vector<Point>& points, std::size_t first, std::size_t last, double small) {
  std::vector<std::size_t> turns = {first};
  std::size_t extreme = first;  // the farthest so far, in the direction it goes
  double way = 0;
  for (std::size_t i = first + 1; i <= last; ++i) {
    const double step = points[i].motion - points[extreme].motion;
    if (way == 0 ? std::abs(step) > small : step * way >= 0) {
      if (way == 0) way = step;
      extreme = i;
    } else if (std::abs(step) > small) {
      turns.push_back(extreme);
      way = step;
      extreme = i;
    }
  }
  if (way == 0) return {};
  turns.push_back(last);
  return turns;
}

}  // namespace

std::string curve_name(const std::string& body, micro::BodyDof dof) {
  return fmt::format("{}, {}", body, micro::dof_name(dof));
}

std::vector<Curve> curves_of(const CurvesTable& table, const std::optional<micro::Scene>& scene) {
  std::vector<Curve> curves = side_curves(table, scene);
  if (auto test = scene && scene->test_curve ? measured(*scene->test_curve, table) : std::nullopt)
    curves.insert(curves.begin(), std::move(*test));
  for (std::size_t i = 0; i + 1 < table.columns.size(); ++i) {
    const auto driven = dof_of(table.columns[i]);
    if (!driven) continue;
    const auto& [body, dof] = *driven;
    if (dof_columns(body, dof)[1] != table.columns[i + 1]) continue;
    const bool turns = dof >= micro::BodyDof::rx;
    Curve curve{curve_name(body, dof), turns ? "rad" : "m", turns ? "N m" : "N", {}, {}, true};
    add_points(table, i, i + 1, 1, curve);
    if (scene)
      curve.stages = driving_stages(*scene, body, dof);
    else
      for (const Point& point : curve.points) curve.stages.insert(point.stage);
    if (!curve.stages.empty()) curves.push_back(std::move(curve));
  }
  return curves;
}

std::vector<Branch> branches_of(const Curve& curve) {
  const Ranges ranges = ranges_of(curve);
  const std::vector<Point>& points = curve.points;
  std::vector<Branch> branches;
  for (std::size_t first = 0, end = 0; first < points.size(); first = end) {
    while (end < points.size() && points[end].stage == points[first].stage) ++end;
    if (!curve.stages.contains(points[first].stage)) continue;
    const std::vector<std::size_t> turns = turns_of(points, first, end - 1, negligible * ranges.motion);
    for (std::size_t t = 1; t < turns.size(); ++t)
      branches.push_back(branch_of(points, turns[t - 1], turns[t], ranges));
  }
  for (std::size_t i = 1; i < branches.size(); ++i) {
    const Branch& there = branches[i - 1];
    Branch& back = branches[i];
    const double up = points[there.last].motion - points[there.first].motion,
                 down = points[back.last].motion - points[back.first].motion,
                 gap = points[back.first].motion - points[there.last].motion;
    if (up * down < 0 && std::abs(gap) <= negligible * ranges.motion) back.loop = loop_of(points, there, back);
  }
  return branches;
}

double largest_work(const Curve& curve) {
  double largest = 0;
  for (const Branch& branch : branches_of(curve)) largest = std::max(largest, std::abs(branch.work));
  return largest;
}

std::string text(Branch::Kind kind) {
  switch (kind) {
    case Branch::Kind::loading: return "loading";
    case Branch::Kind::unloading: return "unloading";
    case Branch::Kind::reversal: return "reversal";
  }
  return "";
}

void write_branches_csv(const std::filesystem::path& file, const std::vector<Curve>& curves) {
  CsvFile out(file,
              "curve,stage,branch,motion_unit,reaction_unit,start_motion,end_motion,start_reaction,end_reaction,"
              "initial_stiffness,tangent_stiffness,work,loop_work");
  for (const Curve& curve : curves)
    for (const Branch& b : branches_of(curve)) {
      const Point &start = curve.points[b.first], &end = curve.points[b.last];
      out << fmt::format("{},{},{},{},{},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{},{}\n", csv_field(curve.name),
                         csv_field(start.stage), text(b.kind), curve.motion_unit, curve.reaction_unit, start.motion,
                         end.motion, start.reaction, end.reaction, b.initial_stiffness, b.tangent_stiffness,
                         curve.works ? fmt::format("{:.9g}", b.work) : "",
                         curve.works && b.loop ? fmt::format("{:.9g}", *b.loop) : "");
    }
  out.write();
}

}  // namespace trame::workflows
