#include "meso/findings.h"

#include <cassert>

#include "meso/parallel_for.h"
#include "meso/strain_cut.h"

namespace trame::meso {

std::vector<YarnFindings> yarn_findings(const FiberStates& states, const std::vector<Index>& yarns,
                                        const micro::FiberConfiguration& a, const micro::FiberConfiguration& b,
                                        Index n_stations, int n_threads) {
  const micro::FiberMesh& fibers = states.header().mesh;
  const ContinuumValidity validity(fibers, yarns, states.read(0).fibers.r, {.n_threads = n_threads});
  const std::vector<YarnContinuum> continuum = validity.between(a, b);
  std::vector<YarnFindings> findings(yarns.size());
  parallel_for(yarns.size(), n_threads, [&](std::size_t y) {
    findings[y] = {yarns[y], section_pairs(fibers, fibers.yarns[yarns[y]], a, b, n_stations), continuum[y]};
  });
  return findings;
}

std::vector<std::vector<SectionBands>> yarn_bands(const Analysis& analysis, const std::vector<YarnFindings>& findings,
                                                  const std::vector<Vec3>& r_a, int n_threads) {
  assert(analysis.meshes.size() == findings.size());
  std::vector<std::vector<SectionBands>> bands(findings.size());
  parallel_for(findings.size(), n_threads, [&](std::size_t y) {
    bands[y] = survey_bands(analysis.meshes[y], analysis.fields[y].strain, r_a, findings[y].sections);
  });
  return bands;
}

std::vector<Orientation> yarn_orientations(const Analysis& analysis, const std::vector<YarnFindings>& findings,
                                           const std::vector<Vec3>& r_a, int n_threads) {
  constexpr double pixels_per_distance = 4;
  assert(analysis.meshes.size() == findings.size());
  std::vector<Orientation> result(findings.size());
  parallel_for(findings.size(), n_threads, [&](std::size_t y) {
    const YarnMesh& mesh = analysis.meshes[y];
    std::array<DirectionalCorrelation, band_components.size()> correlations;
    for (const SectionPair& pair : findings[y].sections) {
      if (mesh.tets.empty() || pair.a.status != SectionStatus::ok) continue;
      const YarnCut cut = cut_yarn(mesh, r_a, section_plane(pair.a), pixels_per_distance);
      for (std::size_t k = 0; k < band_components.size(); ++k)
        correlations[k].add(sample(cut, magnitudes(analysis.fields[y].strain, band_components[k])),
                            pixels_per_distance);
    }
    for (std::size_t k = 0; k < band_components.size(); ++k) result[y][k] = correlations[k].values();
  });
  return result;
}

}  // namespace trame::meso
