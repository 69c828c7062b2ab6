#include "workflows/report/report_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "workflows/report/html.h"

namespace trame::workflows {

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

std::vector<Index> detailed_yarns(const std::vector<micro::Yarn>& yarns, const std::vector<std::string>& patterns) {
  // A fiber or two have no section that tells anything.
  const auto is_bundle = [&](Index y) { return yarns[y].n_fibers >= 3; };
  std::vector<Index> chosen;
  if (!patterns.empty()) {
    const std::vector<Index> named = meso::choose_yarns(yarns, patterns);
    std::copy_if(named.begin(), named.end(), std::back_inserter(chosen), is_bundle);
    return chosen;
  }
  for (const auto family : {micro::YarnFamily::warp, micro::YarnFamily::weft, micro::YarnFamily::free}) {
    std::vector<Index> own;
    for (Index y = 0; y < static_cast<Index>(yarns.size()); ++y)
      if (yarns[y].family == family && is_bundle(y)) own.push_back(y);
    if (!own.empty()) chosen.push_back(own[own.size() / 2]);
  }
  return chosen;
}

std::vector<std::size_t> shown_sections(const meso::YarnComparison& yarn) {
  std::vector<std::size_t> places, stations;
  for (std::size_t k = 0; k < yarn.sections.size(); ++k)
    if (!yarn.sections[k].is_station())
      places.push_back(k);
    else if (k % 3 == 1)
      stations.push_back(k);
  return places.empty() ? stations : places;
}

std::string section_name(const meso::YarnComparison& yarn, std::size_t section) {
  const meso::SectionPair& pair = yarn.sections[section];
  return fmt::format("{}: {}", section,
                     pair.is_station() ? fmt::format("at {:.0f} %", 100 * pair.a.fraction) : escaped(pair.place));
}

ReportData report_data(const micro::SnapshotHeader& header, const std::optional<micro::Scene>& scene,
                       const meso::Comparison& comparison, const std::vector<Index>& detailed) {
  ReportData data{header, scene, comparison, {}};
  for (const meso::YarnComparison& yarn : comparison.yarns)
    if (std::find(detailed.begin(), detailed.end(), yarn.yarn) != detailed.end() && yarn.has_bands)
      data.details.push_back(&yarn);
  return data;
}

}  // namespace trame::workflows
