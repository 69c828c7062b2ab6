#pragma once
/// \file
/// What the report shows of a comparison: which yarns and sections, and what its quantities are called.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "meso/comparison.h"
#include "micro/scene/scene.h"

namespace trame::workflows {

/// Whether there are warp and weft yarns.
[[nodiscard]] bool has_weave(const micro::FiberMesh& mesh);

/// "reference", "end of “load”", or "40 % of “load”", as HTML.
[[nodiscard]] std::string state_name(Index index, const micro::Increment& state);

/// A component of strain that the report maps.
struct StrainQuantity {
  meso::BandComponent component;
  const char* name;   ///< HTML
  const char* plain;  ///< for plots
  bool signed_values;
};
inline constexpr std::array<StrainQuantity, 4> strain_quantities = {
    {{meso::BandComponent::axial, "E<sub>axial</sub>", "axial strain", true},
     {meso::BandComponent::horizontal, "E<sub>horizontal</sub>", "horizontal strain", true},
     {meso::BandComponent::vertical, "E<sub>vertical</sub>", "vertical strain", true},
     {meso::BandComponent::gamma_max, "γ<sub>max</sub>", "greatest shear strain", false}}};

/// The yarns to show section by section: those that match `patterns` (see `meso::choose_yarns`), without any the middle
/// one of each family; of three fibers or more.
[[nodiscard]] std::vector<Index> detailed_yarns(const std::vector<micro::Yarn>& yarns,
                                                const std::vector<std::string>& patterns);

/// The sections of a yarn to show: where it passes others and half-way between, else some of its stations.
[[nodiscard]] std::vector<std::size_t> shown_sections(const meso::YarnComparison& yarn);

/// What such a section is called, as HTML: its number in the tables, and what is there.
[[nodiscard]] std::string section_name(const meso::YarnComparison& yarn, std::size_t section);

/// A pair of states as the report shows it.
struct ReportData {
  const micro::SnapshotHeader& header;
  const std::optional<micro::Scene>& scene;  ///< that the states were computed from, where its text can be read
  const meso::Comparison& comparison;
  std::vector<const meso::YarnComparison*> details;  ///< yarns to show section by section

  [[nodiscard]] const micro::Yarn& yarn(const meso::YarnComparison& of) const { return header.mesh.yarns[of.yarn]; }
  [[nodiscard]] std::string name_a() const { return state_name(comparison.pair.from, comparison.a); }
  [[nodiscard]] std::string name_b() const { return state_name(comparison.pair.to, comparison.b); }
};

[[nodiscard]] ReportData report_data(const micro::SnapshotHeader& header, const std::optional<micro::Scene>& scene,
                                     const meso::Comparison& comparison, const std::vector<Index>& detailed);

}  // namespace trame::workflows
