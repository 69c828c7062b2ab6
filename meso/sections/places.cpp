#include "meso/sections/places.h"

#include <algorithm>
#include <cstddef>

#include "meso/sections/crossings.h"

namespace trame::meso {
namespace {

/// The crossings, and half-way between neighbours.
std::vector<Place> with_middles(const std::vector<Place>& crossings) {
  std::vector<Place> result;
  for (const Place& place : crossings) {
    if (!result.empty()) result.push_back({0.5 * (result.back().fraction + place.fraction), "between"});
    result.push_back(place);
  }
  return result;
}

}  // namespace

std::vector<Place> places(const micro::FiberMesh& mesh, const micro::FiberConfiguration& fibers, Index yarn,
                          std::size_t most) {
  const micro::YarnFamily family = mesh.yarns[yarn].family;
  if (family == micro::YarnFamily::free) return {};
  const std::vector<Vec3> curve = mean_curve(mesh, fibers, yarn);
  std::vector<Place> crossings;
  for (Index other = 0; other < static_cast<Index>(mesh.yarns.size()); ++other) {
    if (mesh.yarns[other].family == family || mesh.yarns[other].family == micro::YarnFamily::free) continue;
    if (const auto found = crossing(curve, mean_curve(mesh, fibers, other)))
      crossings.push_back({found->first_fraction, (found->above ? "over " : "under ") + mesh.yarns[other].name});
  }
  if (crossings.empty()) return {};
  std::sort(crossings.begin(), crossings.end(), [](const Place& p, const Place& q) { return p.fraction < q.fraction; });
  std::vector<Place> all = with_middles(crossings);
  if (all.size() <= most) return all;
  const auto first = all.begin() + static_cast<std::ptrdiff_t>((all.size() - most) / 2);
  return {first, first + static_cast<std::ptrdiff_t>(most)};
}

}  // namespace trame::meso
