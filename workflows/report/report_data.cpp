#include "workflows/report/report_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "workflows/report/html.h"

namespace trame::workflows {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t most_stations = 7;
constexpr Index n_strip = 16, n_mean_sections = 20;
constexpr double pixels_per_distance = 12;

/// Means of the yarn's fibers at equal steps of their lengths.
std::vector<Vec3> mean_curve(const micro::FiberMesh& mesh, const micro::FiberConfiguration& fibers, Index yarn) {
  constexpr int n = 80;
  const meso::YarnSections sections(mesh, mesh.yarns[yarn], fibers);
  std::vector<Vec3> curve;
  for (int i = 0; i <= n; ++i) curve.push_back(sections.at_fraction(i / double(n)).origin);
  return curve;
}

struct Crossing {
  double fraction = 0;  ///< along the first curve
  bool above = false;   ///< the first is
};

/// Where two curves cross seen from above.
std::optional<Crossing> crossing(const std::vector<Vec3>& p, const std::vector<Vec3>& q) {
  for (std::size_t i = 0; i + 1 < p.size(); ++i)
    for (std::size_t j = 0; j + 1 < q.size(); ++j) {
      const Vec2 along = (p[i + 1] - p[i]).head<2>(), across = (q[j + 1] - q[j]).head<2>();
      const Vec2 apart = (q[j] - p[i]).head<2>();
      const double determinant = along.x() * across.y() - along.y() * across.x();
      if (determinant == 0) continue;
      const double t = (apart.x() * across.y() - apart.y() * across.x()) / determinant;
      const double u = (apart.x() * along.y() - apart.y() * along.x()) / determinant;
      // Round-off must not let a crossing at a common end of two pieces slip between them.
      constexpr double slack = 1e-9;
      if (std::min(t, u) < -slack || std::max(t, u) > 1 + slack) continue;
      const double z_p = p[i].z() + t * (p[i + 1] - p[i]).z(), z_q = q[j].z() + u * (q[j + 1] - q[j]).z();
      return Crossing{(double(i) + t) / double(p.size() - 1), z_p > z_q};
    }
  return std::nullopt;
}

std::vector<Station> equal_steps() {
  std::vector<Station> result;
  for (const double fraction : {0.1, 0.3, 0.5, 0.7, 0.9})
    result.push_back({fraction, fmt::format("at {:.0f} %", 100 * fraction)});
  return result;
}

/// The crossings, and half-way between neighbours.
std::vector<Station> with_middles(const std::vector<Station>& crossings) {
  std::vector<Station> result;
  for (const Station& station : crossings) {
    if (!result.empty()) result.push_back({0.5 * (result.back().fraction + station.fraction), "between"});
    result.push_back(station);
  }
  return result;
}

SectionMeans section_means(const std::vector<meso::Section>& sections) {
  SectionMeans means;
  double n = 0;
  for (const meso::Section& section : sections) {
    if (section.status != meso::SectionStatus::ok) continue;
    means.width += section.shape.width;
    means.height += section.shape.height;
    means.fill += section.fill;
    means.lenticular += section.shape.lenticular() ? 1 : 0;
    ++n;
  }
  for (double* mean : {&means.width, &means.height, &means.fill, &means.lenticular}) *mean = n > 0 ? *mean / n : nan;
  return means;
}

/// Means over sections of A.
void add_side_and_centre(YarnMeans& means, const micro::FiberMesh& mesh, const std::vector<meso::Section>& sections,
                         const ReportData& data) {
  double n = 0;
  for (const meso::Section& section : sections) {
    if (section.status != meso::SectionStatus::ok) continue;
    const meso::SideToCentre ratio =
        meso::side_to_centre(section, meso::axial_strains(mesh, section, data.a.fibers.r, data.b.fibers.r));
    if (std::isnan(ratio.side) || std::isnan(ratio.centre)) continue;
    means.axial_side += ratio.side;
    means.axial_centre += ratio.centre;
    ++n;
  }
  for (double* mean : {&means.axial_side, &means.axial_centre}) *mean = n > 0 ? *mean / n : nan;
}

double volume_mean(const std::vector<double>& values, const std::vector<double>& volumes) {
  double sum = 0, volume = 0;
  for (std::size_t t = 0; t < values.size(); ++t)
    if (std::isfinite(values[t])) {
      sum += volumes[t] * values[t];
      volume += volumes[t];
    }
  return volume > 0 ? sum / volume : nan;
}

/// What does not depend on the pair of states.
struct MeshedYarn {
  std::shared_ptr<const meso::YarnMesh> mesh;
  std::optional<meso::DeformationGradient> gradient;  ///< where there is a mesh
};

MeshedYarn meshed_yarn(const micro::FiberMesh& fibers, Index yarn, const std::vector<Vec3>& reference) {
  MeshedYarn result{std::make_shared<const meso::YarnMesh>(meso::mesh_yarn(fibers, yarn, reference)), std::nullopt};
  if (!result.mesh->tets.empty()) result.gradient.emplace(*result.mesh);
  return result;
}

YarnField yarn_field(const ReportData& data, const MeshedYarn& yarn) {
  YarnField result{yarn.mesh, std::nullopt};
  if (yarn.gradient)
    result.field = meso::strain_between(*yarn.mesh, (*yarn.gradient)(data.a.fibers.r),
                                        (*yarn.gradient)(data.b.fibers.r), data.a.fibers.tangent);
  return result;
}

YarnMeans yarn_means(const ReportData& data, Index yarn) {
  const micro::FiberMesh& mesh = data.header.mesh;
  const auto in = [&](const micro::FiberConfiguration& fibers) {
    return meso::YarnSections(mesh, mesh.yarns[yarn], fibers).series(n_mean_sections);
  };
  const std::vector<meso::Section> sections = in(data.a.fibers);
  YarnMeans means{.yarn = yarn, .a = section_means(sections), .b = section_means(in(data.b.fibers)), .strain = {}};
  add_side_and_centre(means, mesh, sections, data);
  const YarnField& strain = data.fields[yarn];
  for (std::size_t q = 0; q < means.strain.size(); ++q)
    means.strain[q] = strain.field ? volume_mean(strain_values(*strain.field, q), strain.mesh->volumes) : nan;
  return means;
}

/// Fills in what a mesh can tell of a station.
void add_strain(StationCut& cut, const ReportData& data, const YarnField& strain) {
  if (!strain.field || cut.a.status != meso::SectionStatus::ok) return;
  cut.cut = meso::cut_yarn(*strain.mesh, data.a.fibers.r, meso::section_plane(cut.a), pixels_per_distance);
  if (cut.cut.inside.size() == 0) return;
  for (std::size_t q = 0; q < cut.strain.size(); ++q) {
    std::vector<double> values = strain_values(*strain.field, q);
    cut.strain[q] = meso::sample(cut.cut, values);
    for (double& value : values) value = std::abs(value);
    cut.bands[q] = meso::find_shear_bands(cut.cut, values);
  }
}

YarnDetail yarn_detail(const ReportData& data, Index yarn) {
  const micro::FiberMesh& mesh = data.header.mesh;
  const auto in = [&](const micro::FiberConfiguration& fibers) {
    return meso::YarnSections(mesh, mesh.yarns[yarn], fibers);
  };
  const meso::YarnSections reference = in(data.reference), a = in(data.a.fibers), b = in(data.b.fibers);
  YarnDetail detail{.yarn = yarn, .cuts = {}, .strip = b.series(n_strip), .correlation = {}};
  for (const Station& station : stations(mesh, data.b.fibers, yarn, most_stations)) {
    StationCut cut{.station = station,
                   .reference = reference.at_fraction(station.fraction),
                   .a = a.at_fraction(station.fraction),
                   .b = b.at_fraction(station.fraction),
                   .cut = {},
                   .strain = {},
                   .bands = {}};
    add_strain(cut, data, data.fields[yarn]);
    detail.cuts.push_back(std::move(cut));
  }
  for (std::size_t q = 0; q < detail.correlation.size(); ++q) {
    meso::DirectionalCorrelation correlation;
    for (const StationCut& cut : detail.cuts)
      if (cut.strain[q].size() > 0) correlation.add(cut.strain[q].abs(), pixels_per_distance);
    detail.correlation[q] = correlation.values();
  }
  return detail;
}

ReportData pair_data(const meso::FiberStates& states, const StatePair& pair, const std::vector<MeshedYarn>& yarns,
                     const std::vector<Index>& detailed) {
  ReportData data{.header = states.header(),
                  .pair = pair,
                  .reference = states.read(0).fibers,
                  .a = states.read(pair.from),
                  .b = states.read(pair.to),
                  .fields = {},
                  .means = {},
                  .details = {},
                  .continuum = {}};
  for (const MeshedYarn& yarn : yarns) data.fields.push_back(yarn_field(data, yarn));
  for (Index yarn = 0; yarn < static_cast<Index>(yarns.size()); ++yarn) data.means.push_back(yarn_means(data, yarn));
  for (const Index yarn : detailed) data.details.push_back(yarn_detail(data, yarn));
  return data;
}

}  // namespace

bool has_weave(const micro::FiberMesh& mesh) {
  const auto has = [&](micro::YarnFamily family) {
    return std::any_of(mesh.yarns.begin(), mesh.yarns.end(), [&](const auto& yarn) { return yarn.family == family; });
  };
  return has(micro::YarnFamily::warp) && has(micro::YarnFamily::weft);
}

std::string state_name(Index index, const micro::Increment& state) {
  if (index == 0) return "reference";
  if (state.stage_time == 1) return fmt::format("end of “{}”", escaped(state.stage));
  return fmt::format("{:.0f} % of “{}”", 100 * state.stage_time, escaped(state.stage));
}

std::vector<double> strain_values(const meso::StrainField& field, std::size_t quantity) {
  const int i = static_cast<int>(quantity);
  return quantity < 3 ? meso::component(field, i, i) : field.gamma_max;
}

std::vector<Station> stations(const micro::FiberMesh& mesh, const micro::FiberConfiguration& fibers, Index yarn,
                              std::size_t most) {
  const micro::YarnFamily family = mesh.yarns[yarn].family;
  if (family == micro::YarnFamily::free) return equal_steps();
  const std::vector<Vec3> curve = mean_curve(mesh, fibers, yarn);
  std::vector<Station> crossings;
  for (Index other = 0; other < static_cast<Index>(mesh.yarns.size()); ++other) {
    if (mesh.yarns[other].family == family || mesh.yarns[other].family == micro::YarnFamily::free) continue;
    if (const auto found = crossing(curve, mean_curve(mesh, fibers, other)))
      crossings.push_back({found->fraction, (found->above ? "over " : "under ") + mesh.yarns[other].name});
  }
  if (crossings.empty()) return equal_steps();
  std::sort(crossings.begin(), crossings.end(),
            [](const Station& p, const Station& q) { return p.fraction < q.fraction; });
  std::vector<Station> all = with_middles(crossings);
  if (all.size() <= most) return all;
  const auto first = all.begin() + static_cast<std::ptrdiff_t>((all.size() - most) / 2);
  return {first, first + static_cast<std::ptrdiff_t>(most)};
}

std::vector<ReportData> report_data(const meso::FiberStates& states, const std::vector<StatePair>& pairs,
                                    const std::vector<Index>& detailed) {
  const micro::FiberMesh& mesh = states.header().mesh;
  const std::vector<Vec3> reference = states.read(0).fibers.r;
  std::vector<Index> all(mesh.yarns.size());
  std::iota(all.begin(), all.end(), 0);
  std::vector<MeshedYarn> yarns;
  for (const Index yarn : all) yarns.push_back(meshed_yarn(mesh, yarn, reference));
  const meso::ContinuumValidity validity(mesh, all, reference);
  std::vector<ReportData> result;
  for (const StatePair& pair : pairs) {
    result.push_back(pair_data(states, pair, yarns, detailed));
    result.back().continuum = validity.between(result.back().a.fibers, result.back().b.fibers);
  }
  return result;
}

}  // namespace trame::workflows
