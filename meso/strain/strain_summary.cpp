#include "meso/strain/strain_summary.h"

#include <utility>
#include <vector>

namespace trame::meso {
namespace {

template <class Value>
Statistics statistics(const YarnMesh& mesh, const StrainField& field, Value&& value) {
  std::vector<WeightedValue> values;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    if (!field.flagged[t]) values.push_back({value(t), mesh.volumes[t]});
  return weighted_statistics(std::move(values));
}

}  // namespace

YarnStrain summarise(Index increment, const YarnMesh& mesh, const StrainField& field) {
  const auto component = [&](int i) {
    return statistics(mesh, field, [&, i](std::size_t t) { return field.E[t](i, i); });
  };
  return {.increment = increment,
          .yarn = mesh.yarn,
          .n_tets = static_cast<Index>(mesh.tets.size()),
          .n_flagged = field.n_flagged,
          .n_inverted = field.n_inverted,
          .axial = component(0),
          .horizontal = component(1),
          .vertical = component(2),
          .gamma_max = statistics(mesh, field, [&](std::size_t t) { return field.gamma_max[t]; }),
          .det_F = statistics(mesh, field, [&](std::size_t t) { return field.det_F[t]; })};
}

}  // namespace trame::meso
