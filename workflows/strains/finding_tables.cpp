#include "workflows/strains/finding_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "workflows/program/csv.h"

namespace trame::workflows {
namespace {

using meso::Comparison;
using meso::Section;
using meso::SectionStatus;
using meso::ShearBand;
using meso::ShearZone;
using meso::YarnComparison;
using meso::YarnOnMesh;

/// ",1,2.5": fields that follow others.
std::string fields(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) text += fmt::format(",{:.6g}", value);
  return text;
}

std::string section_fields(const Section& section) {
  const meso::OutlineShape& shape = section.shape;
  const bool there = section.status == SectionStatus::ok;
  return fmt::format(",{}", section.fibers.size()) +
         fields({shape.area, shape.height, shape.width, shape.thickness, section.fill, shape.lens_residual,
                 shape.ellipse_residual}) +
         "," + (there ? shape.name() : "");
}

std::string band_fields(const ShearBand& band) {
  return fields({band.centre.x(), band.centre.y(), band.angle, band.straightness, band.thickness, band.length,
                 band.aspect, band.area, band.mean_excess, band.share_of_total, band.share_of_excess, band.p_value}) +
         fmt::format(",{}", band.significant ? 1 : 0);
}

std::string zone_fields(const ShearZone& zone, double d) {
  return fmt::format(",{}", zone.n_tets) +
         fields({zone.volume, zone.volume_fraction, zone.share_of_total, zone.centre.x(), zone.centre.y(),
                 zone.centre.z(), zone.normal.x(), zone.normal.y(), zone.normal.z(), zone.extent[0] / d,
                 zone.extent[1] / d, zone.extent[2] / d});
}

/// "5 of 12": bands at the stations that are more than chance, of all.
std::string count_bands(const YarnComparison& yarn, const std::vector<meso::SectionBands>& cuts) {
  std::ptrdiff_t n = 0, n_significant = 0;
  for (const meso::SectionBands& cut : cuts) {
    if (!yarn.sections[cut.station].is_station()) continue;
    n += static_cast<std::ptrdiff_t>(cut.bands.size());
    n_significant +=
        std::count_if(cut.bands.begin(), cut.bands.end(), [](const ShearBand& b) { return b.significant; });
  }
  return fmt::format("{} of {}", n_significant, n);
}

std::string change(double a, double b, const char* format) {
  return fmt::format(fmt::runtime(fmt::format("{0} → {0}", format)), a, b);
}

}  // namespace

void write_sections_csv(const std::filesystem::path& file, const std::vector<micro::Yarn>& yarns,
                        const Comparison& comparison) {
  std::string header = "yarn,station,place,fraction,arc_length_A_m";
  for (const char state : {'A', 'B'})
    header += fmt::format(
        ",n_fibers_{0},area_{0}_m2,height_{0}_m,width_{0}_m,thickness_{0}_m,fill_{0},lens_residual_{0},"
        "ellipse_residual_{0},shape_{0}",
        state);
  header += ",E_axial_side,E_axial_centre,side_to_centre";
  CsvFile out(file, header);
  for (const YarnComparison& yarn : comparison.yarns)
    for (std::size_t k = 0; k < yarn.sections.size(); ++k) {
      const meso::SectionPair& pair = yarn.sections[k];
      out << fmt::format("{},{},{}", csv_field(yarns[yarn.yarn].name), k, csv_field(pair.place))
          << fields({pair.a.fraction, pair.a.arc_length}) << section_fields(pair.a) << section_fields(pair.b)
          << fields({pair.axial_strain.side, pair.axial_strain.centre, pair.axial_strain.ratio}) << '\n';
    }
  out.write();
}

void write_bands_csv(const std::filesystem::path& file, const std::vector<micro::Yarn>& yarns,
                     const Comparison& comparison, std::size_t mesh) {
  CsvFile out(file,
              "yarn,station,place,component,band,centre_horizontal_m,centre_vertical_m,angle_deg,"
              "straightness,thickness_d,length_d,aspect,area_d2,mean_excess,share_of_section,"
              "share_of_section_excess,p_value,significant");
  for (const YarnComparison& yarn : comparison.yarns)
    for (const meso::SectionBands& cut : yarn.meshes[mesh].bands)
      for (std::size_t k = 0; k < cut.bands.size(); ++k)
        out << fmt::format("{},{},{},{},{}", csv_field(yarns[yarn.yarn].name), cut.station,
                           csv_field(yarn.sections[cut.station].place), text(cut.component), k + 1)
            << band_fields(cut.bands[k]) << '\n';
  out.write();
}

void write_orientation_csv(const std::filesystem::path& file, const std::vector<micro::Yarn>& yarns,
                           const Comparison& comparison, std::size_t mesh) {
  std::string header = "yarn,component";
  for (std::size_t k = 0; k < meso::DirectionalCorrelation::n_directions; ++k)
    header += fmt::format(",{:.0f}_deg", meso::DirectionalCorrelation::angle(k));
  CsvFile out(file, header);
  for (const YarnComparison& yarn : comparison.yarns)
    for (std::size_t c = 0; c < meso::band_components.size(); ++c) {
      out << fmt::format("{},{}", csv_field(yarns[yarn.yarn].name), text(meso::band_components[c]));
      for (const double value : yarn.meshes[mesh].orientation[c]) out << fmt::format(",{:.3f}", value);
      out << '\n';
    }
  out.write();
}

void write_zones_csv(const std::filesystem::path& file, const std::vector<micro::Yarn>& yarns,
                     const Comparison& comparison, std::size_t mesh) {
  CsvFile out(file,
              "yarn,zone,n_tets,volume_m3,volume_fraction,share_of_yarn,centre_x_m,centre_y_m,centre_z_m,"
              "normal_x,normal_y,normal_z,extent_1_d,extent_2_d,extent_3_d");
  for (const YarnComparison& yarn : comparison.yarns) {
    const YarnOnMesh& on = yarn.meshes[mesh];
    const std::vector<ShearZone>& zones = on.fields.zones.zones;
    for (std::size_t k = 0; k < zones.size(); ++k)
      out << fmt::format("{},{}", csv_field(yarns[yarn.yarn].name), k + 1)
          << zone_fields(zones[k], on.mesh.fiber_distance) << '\n';
  }
  out.write();
}

void write_continuum_csv(const std::filesystem::path& file, const std::vector<micro::Yarn>& yarns,
                         const Comparison& comparison) {
  CsvFile out(file,
              "yarn,n_nodes,D2_min_mean,D2_min_median,D2_min_95,non_affine_median_d,non_affine_95_d,"
              "exchanged_neighbours,inverted,typical_strain,non_affine_share,mesh_difference,verdict");
  for (const YarnComparison& yarn : comparison.yarns) {
    const meso::YarnContinuum& row = yarn.continuum;
    out << fmt::format("{},{}", csv_field(yarns[yarn.yarn].name), row.n_nodes)
        << fields({row.D2_mean, row.D2_median, row.D2_95, row.non_affine_median, row.non_affine_95, row.exchanged,
                   row.flagged, row.typical_strain, row.non_affine_share, row.mesh_difference})
        << "," << csv_field(explanation(row)) << '\n';
  }
  out.write();
}

void print_findings(const std::vector<micro::Yarn>& yarns, const Comparison& comparison, std::size_t mesh) {
  fmt::print("{:<12} {:>15} {:>15} {:>13} {:>13} {:>11} {:>9} {:>11}\n", "yarn", "height (um)", "width (um)",
             "fill (%)", "lenses (%)", "side/centre", "bands", "zones (%)");
  for (const YarnComparison& yarn : comparison.yarns) {
    const meso::SectionMeans& means = yarn.means;
    const meso::ShearZones& zones = yarn.meshes[mesh].fields.zones;
    fmt::print("{:<12} {:>15} {:>15} {:>13} {:>13} {:>11.3f} {:>9} {:>11}\n", yarns[yarn.yarn].name,
               change(1e6 * means.height_a, 1e6 * means.height_b, "{:.1f}"),
               change(1e6 * means.width_a, 1e6 * means.width_b, "{:.1f}"),
               change(100 * means.fill_a, 100 * means.fill_b, "{:.1f}"),
               change(100 * means.lenticular_a, 100 * means.lenticular_b, "{:.0f}"), means.side_to_centre,
               count_bands(yarn, yarn.meshes[mesh].bands),
               fmt::format("{} ({:.1f})", zones.zones.size(), 100 * zones.volume_fraction));
  }
}

void print_validity(const std::vector<micro::Yarn>& yarns, const Comparison& comparison) {
  fmt::print("\nMay the yarns be taken as continua?\n");
  for (const YarnComparison& yarn : comparison.yarns)
    fmt::print("{:<12} {}\n", yarns[yarn.yarn].name, explanation(yarn.continuum));
}

}  // namespace trame::workflows
