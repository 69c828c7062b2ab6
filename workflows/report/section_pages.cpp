#include "workflows/report/section_pages.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "workflows/report/html.h"
#include "workflows/report/report_plots.h"
#include "workflows/report/section_drawings.h"

namespace trame::workflows {

namespace {

constexpr double page_width = 1000;  ///< pixels that drawings may fill

const micro::Yarn& yarn_of(const ReportData& data, const YarnDetail& detail) {
  return data.header.mesh.yarns[detail.yarn];
}

/// The states that differ, with their names.
std::vector<std::pair<std::string, const meso::Section StationCut::*>> shown_states(const ReportData& data) {
  std::vector<std::pair<std::string, const meso::Section StationCut::*>> states;
  states.emplace_back("reference", &StationCut::reference);
  if (data.pair.from != 0) states.emplace_back(state_name(data.pair.from, data.a), &StationCut::a);
  if (data.pair.to != data.pair.from) states.emplace_back(state_name(data.pair.to, data.b), &StationCut::b);
  return states;
}

std::string stations_figure(const ReportData& data, const YarnDetail& detail) {
  const auto states = shown_states(data);
  std::vector<const meso::Section*> all;
  for (const StationCut& cut : detail.cuts)
    for (const auto& state : states) all.push_back(&(cut.*state.second));
  const Window window = window_around(all, std::min(210.0, (page_width - 100) / double(detail.cuts.size()) - 10));
  HtmlTable grid{.header = {""}, .rows = {}, .kind = "pictures"};
  for (const StationCut& cut : detail.cuts) grid.header.push_back(escaped(cut.station.label));
  for (const auto& [name, section] : states) {
    grid.rows.push_back({name});
    for (const StationCut& cut : detail.cuts)
      grid.rows.back().push_back(section_svg(cut.*section, window, family_colour(yarn_of(data, detail).family)));
  }
  return figure(table(grid),
                fmt::format("{} at the same places in each state; every drawing is {:.0f} µm wide.",
                            escaped(yarn_of(data, detail).name), 1e6 * (window.high.x() - window.low.x())));
}

std::string shape_text(const meso::Section& section) {
  return fmt::format("{:.0f} × {:.0f} µm<br>fill {:.0f} %<br>{}", 1e6 * section.shape.width, 1e6 * section.shape.height,
                     100 * section.fill, section.shape.name());
}

std::string strip_figure(const ReportData& data, const YarnDetail& detail) {
  std::vector<const meso::Section*> all;
  for (const meso::Section& section : detail.strip) all.push_back(&section);
  const Window window = window_around(all, page_width / 8 - 12);
  std::string strip = "<div class=\"strip\">";
  for (const meso::Section& section : detail.strip)
    strip += fmt::format(
        "<div>{}{}<br>at {:.0f} µm</div>", section_svg(section, window, family_colour(yarn_of(data, detail).family)),
        section.status == meso::SectionStatus::ok ? shape_text(section) : "", 1e6 * section.arc_length);
  return figure(strip + "</div>", fmt::format("{} at equal distances along it, {}.",
                                              escaped(yarn_of(data, detail).name), state_name(data.pair.to, data.b)));
}

/// Scale of a component over all detailed yarns.
ColourScale scale_of(const ReportData& data, std::size_t quantity) {
  std::vector<double> values;
  for (const YarnDetail& detail : data.details)
    for (const StationCut& cut : detail.cuts) {
      const meso::Picture& picture = cut.strain[quantity];
      values.insert(values.end(), picture.data(), picture.data() + picture.size());
    }
  return scale_for(std::move(values),
                   strain_quantities[quantity].signed_values ? ColourMap::diverging : ColourMap::sequential);
}

std::string yarn_maps(const ReportData& data, const YarnDetail& detail,
                      const std::array<ColourScale, strain_quantities.size()>& scales) {
  std::vector<const meso::Section*> all;
  for (const StationCut& cut : detail.cuts) all.push_back(&cut.a);
  const Window window = window_around(all, (page_width - 120) / strain_quantities.size() - 16);
  HtmlTable grid{.header = {""}, .rows = {}, .kind = "pictures"};
  for (std::size_t q = 0; q < scales.size(); ++q)
    grid.header.push_back(strain_quantities[q].name + colour_bar_svg(scales[q]));
  for (const StationCut& cut : detail.cuts) {
    grid.rows.push_back({escaped(cut.station.label)});
    for (std::size_t q = 0; q < scales.size(); ++q)
      grid.rows.back().push_back(strain_map_svg(cut.cut, cut.strain[q], scales[q], cut.a, window, cut.bands[q]));
  }
  return "<h3>" + escaped(yarn_of(data, detail).name) + " on sections</h3>\n" + table(grid);
}

/// Bands that are not as long as this, over their thickness, have no direction.
constexpr double least_aspect = 1.5;

/// A significant band and where it is.
struct FoundBand {
  Index yarn = 0;
  const Station* station = nullptr;
  std::size_t quantity = 0;
  meso::ShearBand band;
};

/// Significant bands of a quantity, and the number of all regions that stand out.
std::pair<std::vector<FoundBand>, std::size_t> bands_of(const ReportData& data, std::size_t quantity) {
  std::vector<FoundBand> found;
  std::size_t n_regions = 0;
  for (const YarnDetail& detail : data.details)
    for (const StationCut& cut : detail.cuts)
      for (const meso::ShearBand& band : cut.bands[quantity].bands) {
        ++n_regions;
        if (band.significant) found.push_back({detail.yarn, &cut.station, quantity, band});
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
  for (const auto& [yarn, station, quantity, band] : bands)
    rows.rows.push_back({escaped(data.header.mesh.yarns[yarn].name), escaped(station->label),
                         strain_quantities[quantity].name, fmt::format("{:.0f}", band.angle),
                         fmt::format("{:.1f}", band.thickness), fmt::format("{:.1f}", band.length),
                         fmt::format("{:.1f}", band.aspect), fmt::format("{:.0f}", 100 * band.share_of_total),
                         fmt::format("{:.1f}", 100 * band.p_value)});
  return table(rows) +
         paragraph(fmt::format("The strongest bands; d is the distance between fibers. Thicknesses below 1.5 d are "
                               "those of a mesh cell; a band that is less than {:g} times as long as thick has no "
                               "direction. The share is that of the size of the strain, summed over the section.",
                               least_aspect));
}

/// In which directions strains hang together, where single bands cross and cannot be told apart.
std::string correlations_html(const ReportData& data) {
  constexpr double noise = 0.05;  // the most that disorder gives
  double full = 4 * noise;
  for (const YarnDetail& detail : data.details)
    for (const Correlations& values : detail.correlation)
      for (const double value : values) full = std::max(full, value);  // also where it is NaN
  std::string dials;
  for (std::size_t q = 0; q < strain_quantities.size(); ++q) {
    std::vector<DirectionCurve> curves;
    for (const YarnDetail& detail : data.details)
      curves.push_back({family_colour(yarn_of(data, detail).family), detail.correlation[q]});
    const std::string dial = direction_curves_svg(curves, full, noise);
    if (!dial.empty()) dials += figure(dial, strain_quantities[q].name);
  }
  if (dials.empty()) return {};
  return "<h3>Directions in which the strain hangs together</h3>\n<div class=\"pictures-row\">" + dials + "</div>\n" +
         paragraph(fmt::format(
             "Where bands cross, as in yarns of few layers, they are one region without a direction; their pattern "
             "still "
             "shows in how much the size of the strain is like that two fiber distances away, direction by direction: "
             "its correlation over the sections above, as a distance from the middle, for each of the yarns shown. The "
             "circle is a correlation of {:.2f}, the dotted one {:g}, the most that disorder gives. Bands point along "
             "the "
             "lobes: lobes near ±45° are crossing diagonal bands.",
             full, noise));
}

}  // namespace

std::string sections_html(const ReportData& data) {
  const bool is_weave = has_weave(data.header.mesh);
  std::string content = paragraph(
      std::string(
          "Yarns cut at right angles to their own axis, vertical up; the grey outline is the convex hull of the "
          "fibers. The first figure of each yarn shows the same material in each state") +
      (is_weave ? ": look for how the bundle that went into the loom is pressed into shape where others cross it"
                : ", at equal steps of its length") +
      ". The second one walks along the yarn, with width × height, the share of the outline that fibers fill, and "
      "whether a lens (two arcs) or an ellipse describes the outline better, or neither because it is round" +
      (is_weave
           ? ": in a plain weave the shape repeats from crossing to crossing, in a twill it changes along the yarn."
           : "."));
  for (const YarnDetail& detail : data.details)
    content += "<h3>" + escaped(yarn_of(data, detail).name) + "</h3>\n" + stations_figure(data, detail) +
               strip_figure(data, detail);
  return content;
}

std::string strain_maps_html(const ReportData& data) {
  std::array<ColourScale, strain_quantities.size()> scales;
  for (std::size_t q = 0; q < scales.size(); ++q) scales[q] = scale_of(data, q);
  std::string maps;
  for (const YarnDetail& detail : data.details) maps += yarn_maps(data, detail, scales);
  return figure(
      maps,
      "Strain from A to B on the sections in A, tetrahedron by tetrahedron, with the outlines of the fibers; "
      "tetrahedra reach to the centre lines of the outer fibers. "
      "Normal strains: red is longer, blue is shorter, grey is unchanged. White inside a section: fibers "
      "have changed places there and no strain is defined. Lines enclose regions where the size of the strain "
      "stands out from its surroundings: solid for bands, where chance would rarely make one as strong (p ≤ "
      "1 % against shuffled sections), dotted for the others. Values beyond a scale, the outermost 5 %, have "
      "the colour of its end.");
}

std::string bands_html(const ReportData& data) {
  std::vector<FoundBand> all;
  std::string roses, counts;
  for (std::size_t q = 0; q < strain_quantities.size(); ++q) {
    const auto [bands, n_regions] = bands_of(data, q);
    std::vector<meso::ShearBand> directed;
    for (const FoundBand& found : bands)
      if (found.band.aspect >= least_aspect) directed.push_back(found.band);
    if (!directed.empty()) roses += figure(rose_svg(directed), strain_quantities[q].name);
    counts += fmt::format("<li>{}: {} bands, of these {} with a direction, and {} other regions</li>\n",
                          strain_quantities[q].name, bands.size(), directed.size(), n_regions - bands.size());
    all.insert(all.end(), bands.begin(), bands.end());
  }
  const std::string directions =
      roses.empty() ? ""
                    : "<div class=\"pictures-row\">" + roses + "</div>\n" +
                          paragraph(
                              "Directions of bands on the sections above: area of the bands whose length lies in each "
                              "direction, 0° horizontal, 90° vertical. Lobes near ±45° are diagonal bands.");
  const std::string found =
      all.empty() ? note("On these sections no region stands out more than chance explains: no single shear band.")
                  : "<ul>\n" + counts + "</ul>\n" + directions + band_table(data, std::move(all));
  return found + correlations_html(data);
}

}  // namespace trame::workflows
