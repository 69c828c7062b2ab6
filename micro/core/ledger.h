#pragma once
/// \file
/// The energy books: what is stored, what is gone, and what came in from where. In the unit of the caller.

#include <array>
#include <cstddef>
#include <numeric>
#include <string_view>

#include "micro/core/archive.h"

namespace trame::micro {

/// Where energy comes from that the potential of a step does not hold. Negative where it goes there.
enum class Source : std::size_t {
  bodies,           ///< external forces on the motion of bodies
  separation,       ///< guides that lift yarns over each other
  contacts,         ///< contacts that came and went, or were moved to other particles, at searches
  preloads,         ///< preloads and penalties that were raised, adapted, or dropped
  gap_offsets,      ///< initial overlaps, from which gaps are counted, and which are then pushed out
  friction_limits,  ///< reversible slips whose stiffness µN/u_rev went with the normal force
  stages,           ///< effects and fiber models that a stage begins with or without, before anything moves
  fiber_loads,      ///< forces per length on the motion of fibers
};
inline constexpr std::array<std::string_view, 8> source_names = {
    "bodies", "separation", "contacts", "preloads", "gap_offsets", "friction_limits", "stages", "fiber_loads"};

/// Where energy goes for good.
enum class Sink : std::size_t {
  friction,  ///< slip
  damping,   ///< the proximal term
  release,   ///< fibers that a new stage finds out of balance, and lets go
};
inline constexpr std::array<std::string_view, 3> sink_names = {"friction", "damping", "release"};

/// What is stored at a state, and what came in and was dissipated on the way there.
struct Ledger {
  double stored = 0;
  std::array<double, source_names.size()> supplied{};
  std::array<double, sink_names.size()> dissipated{};

  [[nodiscard]] double& operator[](Source s) { return supplied[static_cast<std::size_t>(s)]; }
  [[nodiscard]] double operator[](Source s) const { return supplied[static_cast<std::size_t>(s)]; }
  [[nodiscard]] double& operator[](Sink s) { return dissipated[static_cast<std::size_t>(s)]; }
  [[nodiscard]] double operator[](Sink s) const { return dissipated[static_cast<std::size_t>(s)]; }

  /// All that came in, what was lost of it, and what of the rest is not stored.
  [[nodiscard]] double total_supplied() const { return std::accumulate(supplied.begin(), supplied.end(), 0.0); }
  [[nodiscard]] double total_dissipated() const { return std::accumulate(dissipated.begin(), dissipated.end(), 0.0); }
  [[nodiscard]] double imbalance() const { return total_supplied() - stored - total_dissipated(); }

  void keep(Archive& archive) {
    archive(stored);
    for (double& energy : supplied) archive(energy);
    for (double& energy : dissipated) archive(energy);
  }

  Ledger& operator+=(const Ledger& other) {
    stored += other.stored;
    for (std::size_t i = 0; i < supplied.size(); ++i) supplied[i] += other.supplied[i];
    for (std::size_t i = 0; i < dissipated.size(); ++i) dissipated[i] += other.dissipated[i];
    return *this;
  }
};

}  // namespace trame::micro
