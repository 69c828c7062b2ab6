#include "workflows/report/fabric_table.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "workflows/report/html.h"

namespace trame::workflows {

namespace {

/// What is shown is the value times `scale` with that many decimals.
struct Fact {
  const char* key;  ///< in summary.json, with the SI unit
  const char* name;
  const char* unit;
  double scale;
  int decimals;
};

struct FabricRow {
  Fact fact;
  double value;
};

struct SystemRow {
  Fact fact;
  meso::MeanDeviation warp, weft;
  bool has_deviation;
};

std::vector<FabricRow> fabric_rows(const meso::FabricFacts& facts) {
  return {{{"areal_density_kg_m2", "areal density", "g/m²", 1e3, 1}, facts.areal_density},
          {{"thickness_m", "thickness, crown to crown", "µm", 1e6, 1}, facts.thickness},
          {{"outline_thickness_m", "thickness, with free edges", "µm", 1e6, 1}, facts.outline_thickness},
          {{"cover_factor", "cover factor, of widths", "%", 100, 1}, facts.cover_factor},
          {{"projected_cover", "cover, projected", "%", 100, 1}, facts.projected_cover},
          {{"volume_fraction", "fiber volume fraction", "%", 100, 1}, facts.volume_fraction}};
}

std::vector<SystemRow> system_rows(const meso::FabricFacts& facts) {
  const meso::SystemFacts &p = facts.warp, &q = facts.weft;
  const auto plain = [](double value) { return meso::MeanDeviation{value, 0}; };
  return {{{"sett_per_m", "sett", "per cm", 1e-2, 2}, plain(1 / p.spacing), plain(1 / q.spacing), false},
          {{"linear_density_kg_m", "linear density of a yarn", "tex", 1e6, 3},
           plain(p.linear_density),
           plain(q.linear_density),
           false},
          {{"crimp", "crimp", "%", 100, 2}, p.crimp, q.crimp, true},
          {{"take_up", "take-up", "%", 100, 2}, plain(p.take_up), plain(q.take_up), false},
          {{"width_m", "width of a yarn", "µm", 1e6, 1}, p.width, q.width, true},
          {{"height_m", "height of a yarn", "µm", 1e6, 1}, p.height, q.height, true},
          {{"cover", "cover", "%", 100, 1}, plain(p.cover), plain(q.cover), false},
          {{"areal_density_kg_m2", "areal density", "g/m²", 1e3, 1},
           plain(p.areal_density),
           plain(q.areal_density),
           false}};
}

std::string number(const Fact& fact, double value) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", fact.scale * value, fact.decimals) : "–";
}

std::string number(const SystemRow& row, const meso::MeanDeviation& value) {
  const std::string mean = number(row.fact, value.mean);
  return row.has_deviation ? mean + " ± " + number(row.fact, value.deviation) : mean;
}

nlohmann::json system_json(const std::vector<SystemRow>& rows, Index n_yarns, meso::MeanDeviation SystemRow::*system) {
  nlohmann::json json = {{"n_yarns", n_yarns}};
  for (const SystemRow& row : rows) {
    const meso::MeanDeviation& value = row.*system;
    json[row.fact.key] = value.mean;
    if (row.has_deviation) json[std::string(row.fact.key) + "_deviation"] = value.deviation;
  }
  return json;
}

}  // namespace

std::string fabric_text(const meso::FabricFacts& facts) {
  std::string text = fmt::format("{:<30}{:<8}{:>16}{:>18}{:>18}\n", "Fabric", "", "", "warp", "weft");
  for (const FabricRow& row : fabric_rows(facts))
    text += fmt::format("  {:<28}{:<8}{:>16}\n", row.fact.name, row.fact.unit, number(row.fact, row.value));
  for (const SystemRow& row : system_rows(facts))
    text += fmt::format("  {:<28}{:<8}{:>16}{:>18}{:>18}\n", row.fact.name, row.fact.unit, "", number(row, row.warp),
                        number(row, row.weft));
  text.pop_back();
  return text;
}

std::string fabric_html(const meso::FabricFacts& facts) {
  HtmlTable rows{.header = {"fabric", "", "", "warp", "weft"}, .rows = {}};
  for (const FabricRow& row : fabric_rows(facts))
    rows.rows.push_back({row.fact.name, row.fact.unit, number(row.fact, row.value)});
  for (const SystemRow& row : system_rows(facts))
    rows.rows.push_back({row.fact.name, row.fact.unit, "", number(row, row.warp), number(row, row.weft)});
  return table(rows);
}

nlohmann::json fabric_json(const meso::FabricFacts& facts) {
  nlohmann::json json = nlohmann::json::object();
  for (const FabricRow& row : fabric_rows(facts)) json[row.fact.key] = row.value;
  const std::vector<SystemRow> rows = system_rows(facts);
  json["warp"] = system_json(rows, facts.warp.n_yarns, &SystemRow::warp);
  json["weft"] = system_json(rows, facts.weft.n_yarns, &SystemRow::weft);
  return json;
}

}  // namespace trame::workflows
