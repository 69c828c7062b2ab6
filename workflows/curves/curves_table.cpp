#include "workflows/curves/curves_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "micro/core/error.h"
#include "workflows/program/csv.h"

namespace trame::workflows {

namespace {

/// Fields of a line; a quoted one may hold commas, and a quote twice.
std::vector<std::string> csv_fields(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') {
      if (quoted && i + 1 < line.size() && line[i + 1] == '"')
        fields.back() += line[i++];
      else
        quoted = !quoted;
    } else if (line[i] == ',' && !quoted) {
      fields.emplace_back();
    } else if (line[i] != '\r') {
      fields.back() += line[i];
    }
  }
  return fields;
}

CurvesTable::Row row_of(const std::vector<std::string>& fields, std::size_t n_columns) {
  if (fields.size() != n_columns + 2) throw std::invalid_argument("another number of fields");
  CurvesTable::Row row{fields[0], std::stod(fields[1]), {}};
  for (std::size_t i = 2; i < fields.size(); ++i) row.values.push_back(std::stod(fields[i]));
  return row;
}

}  // namespace

std::optional<std::size_t> CurvesTable::find(const std::string& column) const {
  const auto found = std::find(columns.begin(), columns.end(), column);
  return found == columns.end() ? std::nullopt : std::optional(static_cast<std::size_t>(found - columns.begin()));
}

std::array<std::string, 2> dof_columns(const std::string& body, micro::BodyDof dof) {
  const bool turns = dof >= micro::BodyDof::rx;
  const std::string name = fmt::format("{}.{}_", body, micro::dof_name(dof));
  return {name + (turns ? "rad" : "m"), name + (turns ? "Nm" : "N")};
}

std::vector<std::string> CurvesLayout::columns() const {
  std::vector<std::string> names;
  if (has_sides) names.assign(side_columns.begin(), side_columns.end());
  for (const micro::DrivenDof& driven : dofs)
    for (const std::string& name : dof_columns(body_names[driven.body], driven.dof)) names.push_back(name);
  return names;
}

std::vector<double> CurvesLayout::values(const std::array<double, 2>& strain, const std::array<double, 2>& force,
                                         const std::vector<double>& motion, const std::vector<double>& reaction) const {
  std::vector<double> numbers;
  if (has_sides) numbers = {strain[0], strain[1], force[0], force[1]};
  for (const micro::DrivenDof& driven : dofs) {
    const auto i = static_cast<std::size_t>(micro::n_body_dofs * driven.body + static_cast<int>(driven.dof));
    numbers.push_back(motion.at(i));
    numbers.push_back(reaction.at(i));
  }
  return numbers;
}

CurvesLayout curves_layout(const micro::Scene& scene, const std::vector<std::string>& body_names) {
  return {scene.weave.has_value(), body_names, micro::driven_dofs(scene, body_names)};
}

void write_curves_csv(const std::filesystem::path& file, const CurvesTable& table) {
  std::string header = "stage,stage_time";
  for (const std::string& column : table.columns) header.append(",").append(csv_field(column));
  CsvFile out(file, header);
  for (const CurvesTable::Row& row : table.rows) {
    out << fmt::format("{},{:.6g}", csv_field(row.stage), row.stage_time);
    for (const double value : row.values) out << fmt::format(",{:.9g}", value);
    out << '\n';
  }
  out.write();
}

CurvesTable read_curves(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw InputError(fmt::format("{}: cannot be read", file.string()));
  CurvesTable table;
  std::string line;
  std::getline(stream, line);
  table.columns = csv_fields(line);
  if (table.columns.size() < 2 || table.columns[0] != "stage" || table.columns[1] != "stage_time")
    throw InputError(
        fmt::format("{}: not curves of a run: its columns must begin with stage,stage_time", file.string()));
  table.columns.erase(table.columns.begin(), table.columns.begin() + 2);
  for (int number = 2; std::getline(stream, line); ++number) {
    try {
      table.rows.push_back(row_of(csv_fields(line), table.columns.size()));
    } catch (const std::logic_error&) {
      throw InputError(fmt::format("{}, line {}: must be a stage, the time in it, and {} numbers", file.string(),
                                   number, table.columns.size()));
    }
  }
  return table;
}

}  // namespace trame::workflows
