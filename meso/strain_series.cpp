#include "meso/strain_series.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <utility>

#include "meso/yarns_vtk.h"

namespace trame::meso {

std::vector<Comparison> follow(const YarnComparer& comparer, const StrainSeries& series) {
  const auto a = comparer.state_a(series.from);
  std::vector<std::unique_ptr<YarnsVtkWriter>> writers;
  for (std::size_t m = 0; m < series.vtk_folders.size(); ++m)
    writers.push_back(std::make_unique<YarnsVtkWriter>(comparer.states().header(),
                                                       comparer.meshes(comparer.settings().meshes[m]), series.from,
                                                       a->increment, series.vtk_folders[m], series.copies));
  std::vector<Index> increments = series.to;
  if (increments.empty()) {
    increments.resize(comparer.states().n_increments());
    std::iota(increments.begin(), increments.end(), 0);
  }
  std::vector<Comparison> comparisons;
  for (const Index to : increments) {
    StateStrains strains = comparer.strains(a, to);
    if (series.on_state) series.on_state(strains);
    for (std::size_t m = 0; m < writers.size(); ++m) writers[m]->append(to, strains.b, strains.meshes[m].fields);
    if (std::find(series.compare.begin(), series.compare.end(), to) != series.compare.end())
      comparisons.push_back(comparer.complete(std::move(strains)));
  }
  return comparisons;
}

}  // namespace trame::meso
