#include "workflows/strains/strain_tables.h"

#include <fmt/format.h>

#include <cstdio>
#include <system_error>

namespace trame::workflows {
namespace {

using meso::Comparison;
using meso::YarnComparison;
using meso::YarnOnMesh;
using meso::YarnStrain;

void print_oddities(const std::string& yarn, const YarnOnMesh& on) {
  const meso::MeshQuality& quality = on.mesh.quality;
  if (!on.has_mesh()) fmt::print("{}: no {} mesh: {}\n", yarn, text(on.kind), text(on.mesh.status));
  if (quality.n_slivers + quality.n_unused_fibers > 0)
    fmt::print("{}: {} slivers left in the {} mesh, {} fibers unused\n", yarn, quality.n_slivers, text(on.kind),
               quality.n_unused_fibers);
}

void print_row(const std::string& yarn, std::string_view mesh, const YarnStrain& row) {
  fmt::print("{:<12} {:<10} {:>8} {:>8}  {:>10.3e} ({:>9.2e} … {:>9.2e})  {:>10.3e} {:>10.3e} {:>10.3e}\n", yarn, mesh,
             row.n_tets, row.n_flagged, row.axial.mean, row.axial.quantile_05, row.axial.quantile_95,
             row.horizontal.mean, row.vertical.mean, row.gamma_max.mean);
}

void print_difference(const YarnStrain& a, const YarnStrain& b) {
  fmt::print("{:<12} {:<10} {:>8} {:>8}  {:>10.3e} {:25}  {:>10.3e} {:>10.3e} {:>10.3e}\n", "", "difference", "", "",
             b.axial.mean - a.axial.mean, "", b.horizontal.mean - a.horizontal.mean, b.vertical.mean - a.vertical.mean,
             b.gamma_max.mean - a.gamma_max.mean);
}

std::string strains_header() {
  std::string header = "increment,yarn,n_tets,n_flagged,n_inverted";
  for (const char* name : {"E_axial", "E_horizontal", "E_vertical", "gamma_max", "det_F"})
    header += fmt::format(",{0}_mean,{0}_deviation,{0}_min,{0}_quantile_05,{0}_median,{0}_quantile_95,{0}_max", name);
  return header;
}

}  // namespace

StrainsCsv::StrainsCsv(const std::filesystem::path& file, const std::vector<micro::Yarn>& yarns)
    : yarns_(yarns), out_(file, strains_header()) {
  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);  // what fails shows when the file is opened
  out_.write();
}

void StrainsCsv::append(const std::vector<YarnStrain>& rows) {
  for (const YarnStrain& row : rows) {
    if (row.n_tets == 0) continue;
    out_ << fmt::format("{},{},{},{},{}", row.increment, csv_field(yarns_[row.yarn].name), row.n_tets, row.n_flagged,
                        row.n_inverted);
    for (const auto& s : {row.axial, row.horizontal, row.vertical, row.gamma_max, row.det_F})
      out_ << fmt::format(",{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}", s.mean, s.deviation, s.min,
                          s.quantile_05, s.median, s.quantile_95, s.max);
    out_ << '\n';
  }
  out_.write();
}

void print_strains(const std::vector<micro::Yarn>& yarns, const Comparison& comparison) {
  for (const YarnComparison& yarn : comparison.yarns)
    for (const YarnOnMesh& on : yarn.meshes) print_oddities(yarns[yarn.yarn].name, on);
  fmt::print("{:<12} {:<10} {:>8} {:>8}  {:>36}  {:>10} {:>10} {:>10}\n", "yarn", "mesh", "tets", "flagged",
             "E_axial mean (5 % … 95 %)", "E_horiz.", "E_vert.", "gamma_max");
  for (const YarnComparison& yarn : comparison.yarns) {
    std::vector<const YarnStrain*> rows;
    for (const YarnOnMesh& on : yarn.meshes) {
      if (!on.has_mesh()) continue;
      print_row(rows.empty() ? yarns[yarn.yarn].name : "", text(on.kind), on.summary);
      rows.push_back(&on.summary);
    }
    if (rows.size() == 2) print_difference(*rows[0], *rows[1]);
  }
}

}  // namespace trame::workflows
