#include "workflows/report/section_pages.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "meso/bands/strain_cut.h"
#include "workflows/report/html.h"
#include "workflows/report/report_plots.h"
#include "workflows/report/section_drawings.h"

namespace trame::workflows {

namespace {

constexpr double page_width = 1000;  ///< pixels that drawings may fill

using meso::SectionPair;
using meso::YarnComparison;

const char* colour_of(const ReportData& data, const YarnComparison& yarn) {
  return family_colour(data.yarn(yarn).family);
}

/// The states that differ, with their names.
std::vector<std::pair<std::string, const meso::Section SectionPair::*>> shown_states(const ReportData& data) {
  const meso::StatePair& pair = data.comparison.pair;
  std::vector<std::pair<std::string, const meso::Section SectionPair::*>> states;
  states.emplace_back("reference", &SectionPair::reference);
  if (pair.from != 0) states.emplace_back(data.name_a(), &SectionPair::a);
  if (pair.to != pair.from) states.emplace_back(data.name_b(), &SectionPair::b);
  return states;
}

std::string places_figure(const ReportData& data, const YarnComparison& yarn) {
  const auto states = shown_states(data);
  const std::vector<std::size_t> shown = shown_sections(yarn);
  std::vector<const meso::Section*> all;
  for (const std::size_t k : shown)
    for (const auto& state : states) all.push_back(&(yarn.sections[k].*state.second));
  const Window window = window_around(all, std::min(210.0, (page_width - 100) / double(shown.size()) - 10));
  HtmlTable grid{.header = {""}, .rows = {}, .kind = "pictures"};
  for (const std::size_t k : shown) grid.header.push_back(section_name(yarn, k));
  for (const auto& [name, section] : states) {
    grid.rows.push_back({name});
    for (const std::size_t k : shown)
      grid.rows.back().push_back(section_svg(yarn.sections[k].*section, window, colour_of(data, yarn)));
  }
  return figure(table(grid),
                filled("places_caption", {{"yarn", data.yarn(yarn).name},
                                          {"width", fmt::format("{:.0f}", 1e6 * (window.high.x() - window.low.x()))}}));
}

std::string shape_text(const meso::Section& section) {
  return fmt::format("{:.0f} × {:.0f} µm<br>fill {:.0f} %<br>{}", 1e6 * section.shape.width, 1e6 * section.shape.height,
                     100 * section.fill, section.shape.name());
}

std::string strip_figure(const ReportData& data, const YarnComparison& yarn) {
  std::vector<const meso::Section*> all;
  for (const SectionPair& pair : yarn.sections)
    if (pair.is_station()) all.push_back(&pair.b);
  const Window window = window_around(all, page_width / 6 - 12);
  std::string strip = "<div class=\"strip\">";
  for (std::size_t k = 0; k < yarn.sections.size(); ++k) {
    const SectionPair& pair = yarn.sections[k];
    if (!pair.is_station()) continue;
    strip += fmt::format("<div>{}{}<br>{}</div>", section_svg(pair.b, window, colour_of(data, yarn)),
                         pair.b.status == meso::SectionStatus::ok ? shape_text(pair.b) : "", section_name(yarn, k));
  }
  return figure(strip + "</div>", filled("strip_caption", {{"yarn", data.yarn(yarn).name}, {"b", data.name_b()}}));
}

/// Strains of a yarn on one of its sections, finer than the cuts that bands are looked for on.
struct StrainMap {
  std::size_t section = 0;
  meso::YarnCut cut;
  std::array<meso::Picture, strain_quantities.size()> strain;
};

std::vector<StrainMap> strain_maps(const ReportData& data, const YarnComparison& yarn) {
  constexpr double pixels_per_distance = 12;
  std::vector<StrainMap> maps;
  const meso::YarnOnMesh& on = yarn.on_mesh();
  for (const std::size_t k : shown_sections(yarn)) {
    if (!on.has_mesh() || yarn.sections[k].a.status != meso::SectionStatus::ok) continue;
    StrainMap map{k,
                  meso::cut_yarn(on.mesh, data.comparison.a.fibers.r, meso::section_plane(yarn.sections[k].a),
                                 pixels_per_distance),
                  {}};
    for (std::size_t q = 0; q < strain_quantities.size(); ++q)
      map.strain[q] = meso::sample(map.cut, values_of(on.fields.strain, strain_quantities[q].component));
    maps.push_back(std::move(map));
  }
  return maps;
}

/// Of all detailed yarns.
using StrainMaps = std::vector<std::vector<StrainMap>>;

/// Scale of a component over all of them.
ColourScale scale_of(const StrainMaps& maps, std::size_t quantity) {
  std::vector<double> values;
  for (const auto& yarn : maps)
    for (const StrainMap& map : yarn) {
      const meso::Picture& picture = map.strain[quantity];
      values.insert(values.end(), picture.data(), picture.data() + picture.size());
    }
  return scale_for(std::move(values),
                   strain_quantities[quantity].signed_values ? ColourMap::diverging : ColourMap::sequential);
}

/// Bands of a component on a section; there are some wherever the yarn has a mesh.
const meso::SectionBands* bands_on(const YarnComparison& yarn, std::size_t section, meso::BandComponent component) {
  const std::vector<meso::SectionBands>& all = yarn.on_mesh().bands;
  const auto found = std::find_if(all.begin(), all.end(), [&](const meso::SectionBands& bands) {
    return bands.station == static_cast<Index>(section) && bands.component == component;
  });
  return found == all.end() ? nullptr : &*found;
}

std::string yarn_maps(const YarnComparison& yarn, const std::vector<StrainMap>& maps,
                      const std::array<ColourScale, strain_quantities.size()>& scales) {
  std::vector<const meso::Section*> all;
  for (const StrainMap& map : maps) all.push_back(&yarn.sections[map.section].a);
  const Window window = window_around(all, (page_width - 120) / strain_quantities.size() - 16);
  HtmlTable grid{.header = {""}, .rows = {}, .kind = "pictures"};
  for (std::size_t q = 0; q < scales.size(); ++q)
    grid.header.push_back(strain_quantities[q].name + colour_bar_svg(scales[q]));
  for (const StrainMap& map : maps) {
    grid.rows.push_back({section_name(yarn, map.section)});
    for (std::size_t q = 0; q < scales.size(); ++q)
      if (const auto* bands = bands_on(yarn, map.section, strain_quantities[q].component))
        grid.rows.back().push_back(
            strain_map_svg(map.cut, map.strain[q], scales[q], yarn.sections[map.section].a, window, *bands));
  }
  return table(grid);
}

/// Bands that are not as long as this, over their thickness, have no direction.
constexpr double least_aspect = 1.5;

/// A significant band and where it is.
struct FoundBand {
  const YarnComparison* yarn = nullptr;
  std::size_t section = 0;
  std::size_t quantity = 0;
  meso::ShearBand band;
};

/// Significant bands of a quantity on the sections that are shown, and the number of all regions that stand out.
std::pair<std::vector<FoundBand>, std::size_t> bands_of(const ReportData& data, std::size_t quantity) {
  std::vector<FoundBand> found;
  std::size_t n_regions = 0;
  for (const YarnComparison* yarn : data.details)
    for (const std::size_t section : shown_sections(*yarn)) {
      const auto* on = bands_on(*yarn, section, strain_quantities[quantity].component);
      if (on == nullptr) continue;
      n_regions += on->bands.size();
      for (const meso::ShearBand& band : on->bands)
        if (band.significant) found.push_back({yarn, section, quantity, band});
    }
  return {found, n_regions};
}

/// The strongest ones.
std::string band_table(const ReportData& data, std::vector<FoundBand> bands) {
  constexpr std::size_t most = 12;
  std::stable_sort(bands.begin(), bands.end(),
                   [](const FoundBand& p, const FoundBand& q) { return p.band.mass > q.band.mass; });
  if (bands.size() > most) bands.resize(most);
  HtmlTable rows{.header = {"yarn", "section", "of", "direction, °", "thickness, d", "length, d", "length / thickness",
                            "share of the section’s, %", "p, %"},
                 .rows = {}};
  for (const auto& [yarn, section, quantity, band] : bands)
    rows.rows.push_back({escaped(data.yarn(*yarn).name), section_name(*yarn, section), strain_quantities[quantity].name,
                         fmt::format("{:.0f}", band.angle), fmt::format("{:.1f}", band.thickness),
                         fmt::format("{:.1f}", band.length), fmt::format("{:.1f}", band.aspect),
                         fmt::format("{:.0f}", 100 * band.share_of_total), fmt::format("{:.1f}", 100 * band.p_value)});
  return table(rows);
}

/// In which directions strains hang together, where single bands cross and cannot be told apart.
void add_directions(const ReportData& data, Fields& fields) {
  constexpr double noise = 0.05;  // the most that disorder gives
  const auto values_of = [](const YarnComparison& yarn, const StrainQuantity& quantity) -> const auto& {
    return yarn.on_mesh().orientation[static_cast<std::size_t>(quantity.component)];
  };
  double full = 4 * noise;
  for (const YarnComparison* yarn : data.details)
    for (const StrainQuantity& quantity : strain_quantities)
      for (const double value : values_of(*yarn, quantity)) full = std::max(full, value);  // also where it is NaN
  std::string dials;
  for (const StrainQuantity& quantity : strain_quantities) {
    std::vector<DirectionCurve> curves;
    for (const YarnComparison* yarn : data.details)
      curves.push_back({colour_of(data, *yarn), values_of(*yarn, quantity)});
    const std::string dial = direction_curves_svg(curves, full, noise);
    if (!dial.empty()) dials += figure(dial, quantity.name);
  }
  if (dials.empty()) return;
  fields.emplace_back("dials", dials);
  fields.emplace_back("circle", fmt::format("{:.2f}", full));
  fields.emplace_back("noise", fmt::format("{:g}", noise));
}

}  // namespace

std::string sections_html(const ReportData& data) {
  std::vector<Fields> yarns;
  for (const YarnComparison* yarn : data.details)
    yarns.push_back({{"name", data.yarn(*yarn).name},
                     {"places", places_figure(data, *yarn)},
                     {"strip", strip_figure(data, *yarn)}});
  return filled("sections", {{"weave", has_weave(data.header.mesh)}, {"yarns", yarns}});
}

std::string strain_maps_html(const ReportData& data) {
  StrainMaps maps;
  for (const YarnComparison* yarn : data.details) maps.push_back(strain_maps(data, *yarn));
  std::array<ColourScale, strain_quantities.size()> scales;
  for (std::size_t q = 0; q < scales.size(); ++q) scales[q] = scale_of(maps, q);
  std::vector<Fields> yarns;
  for (std::size_t y = 0; y < maps.size(); ++y)
    yarns.push_back(
        {{"name", data.yarn(*data.details[y]).name}, {"maps", yarn_maps(*data.details[y], maps[y], scales)}});
  return figure(filled("yarn_maps", {{"yarns", yarns}}), filled("maps_caption"));
}

std::string bands_html(const ReportData& data) {
  std::vector<FoundBand> all;
  std::string roses;
  std::vector<Fields> counts;
  for (std::size_t q = 0; q < strain_quantities.size(); ++q) {
    const auto [bands, n_regions] = bands_of(data, q);
    std::vector<meso::ShearBand> directed;
    for (const FoundBand& found : bands)
      if (found.band.aspect >= least_aspect) directed.push_back(found.band);
    if (!directed.empty()) roses += figure(rose_svg(directed), strain_quantities[q].name);
    counts.push_back({{"of", strain_quantities[q].name},
                      {"bands", std::to_string(bands.size())},
                      {"directed", std::to_string(directed.size())},
                      {"others", std::to_string(n_regions - bands.size())}});
    all.insert(all.end(), bands.begin(), bands.end());
  }
  Fields fields = {{"none", all.empty()}, {"counts", counts}, {"least_aspect", fmt::format("{:g}", least_aspect)}};
  if (!roses.empty()) fields.emplace_back("roses", roses);
  fields.emplace_back("strongest", band_table(data, std::move(all)));
  add_directions(data, fields);
  return filled("bands", fields);
}

}  // namespace trame::workflows
