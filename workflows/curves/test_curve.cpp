#include "workflows/curves/test_curve.h"

#include <fmt/format.h>

#include <algorithm>

namespace trame::workflows {

std::optional<Curve> measured(const micro::TestCurve& test, const CurvesTable& table) {
  struct Columns {
    std::size_t motion, reaction;
  };
  std::vector<Columns> columns;
  for (const micro::TestCurve::Term& term : test.terms) {
    const auto names = dof_columns(term.body, term.dof);
    const auto motion = table.find(names[0]), reaction = table.find(names[1]);
    if (!motion || !reaction) return std::nullopt;
    columns.push_back({*motion, *reaction});
  }
  const auto start = std::find_if(table.rows.begin(), table.rows.end(),
                                  [&](const CurvesTable::Row& row) { return row.stage == test.stage; });
  double per = 1;
  if (test.length > 0 && start != table.rows.end()) {
    per = test.length;
    for (std::size_t i = 0; i < columns.size(); ++i) per += test.terms[i].length * start->values[columns[i].motion];
  }
  Curve curve{test.name, test.motion_unit, test.reaction_unit, {}, {test.stage}, true};
  for (const micro::TestCurve::Term& term : test.terms) curve.parts.insert(curve_name(term.body, term.dof));
  for (const CurvesTable::Row& row : table.rows) {
    Curve::Point point{row.stage, row.stage_time, 0, 0};
    for (std::size_t i = 0; i < columns.size(); ++i) {
      point.motion += test.terms[i].motion * row.values[columns[i].motion] / per;
      point.reaction += test.terms[i].reaction * row.values[columns[i].reaction];
    }
    curve.points.push_back(std::move(point));
  }
  return curve;
}

void add_columns(const Curve& curve, CurvesTable& table) {
  for (const auto& [what, unit] : {std::pair{"motion", curve.motion_unit}, {"reaction", curve.reaction_unit}}) {
    std::string joined = unit;
    std::erase(joined, ' ');
    table.columns.push_back(fmt::format("{}.{}_{}", curve.name, what, joined));
  }
  for (std::size_t i = 0; i < table.rows.size(); ++i)
    for (const double value : {curve.points[i].motion, curve.points[i].reaction}) table.rows[i].values.push_back(value);
}

}  // namespace trame::workflows
