#pragma once
/// \file
/// What the report shows of two states, computed from them: sections, strains, cuts, bands, validity.

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "meso/continuum.h"
#include "meso/fiber_states.h"
#include "meso/orientation.h"
#include "meso/sections.h"
#include "meso/shear_bands.h"
#include "meso/strain.h"
#include "meso/strain_cut.h"

namespace trame::workflows {

/// States A and B of a strain: increments.
struct StatePair {
  Index from = 0, to = 0;
};

/// Whether there are warp and weft yarns.
[[nodiscard]] bool has_weave(const micro::FiberMesh& mesh);

/// "reference", "end of “load”", or "40 % of “load”", as HTML.
[[nodiscard]] std::string state_name(Index index, const micro::Increment& state);

/// A component of strain that the report maps.
struct StrainQuantity {
  const char* name;   ///< HTML
  const char* plain;  ///< for plots
  bool signed_values;
};
inline constexpr std::array<StrainQuantity, 4> strain_quantities = {
    {{"E<sub>axial</sub>", "axial strain", true},
     {"E<sub>horizontal</sub>", "horizontal strain", true},
     {"E<sub>vertical</sub>", "vertical strain", true},
     {"γ<sub>max</sub>", "greatest shear strain", false}}};

/// Of every tetrahedron; NaN where flagged. `quantity`: index into `strain_quantities`.
[[nodiscard]] std::vector<double> strain_values(const meso::StrainField& field, std::size_t quantity);

/// Place along a yarn, a fraction of its fibers' lengths, and what is there in words.
struct Station {
  double fraction = 0;
  std::string label;
};

/// Where the yarn passes others of the crossing family in this state, seen from above, and half-way between; at most
/// `most`, the middle ones. Five equal steps for a yarn that crosses none.
[[nodiscard]] std::vector<Station> stations(const micro::FiberMesh& mesh, const micro::FiberConfiguration& fibers,
                                            Index yarn, std::size_t most);

/// A yarn's mesh, the same for all pairs of states, and strain from A to B; no field where the mesh is empty.
struct YarnField {
  std::shared_ptr<const meso::YarnMesh> mesh;
  std::optional<meso::StrainField> field;
};

/// By direction, see meso::DirectionalCorrelation.
using Correlations = std::array<double, meso::DirectionalCorrelation::n_directions>;

/// One station of a yarn.
struct StationCut {
  Station station;
  meso::Section reference, a, b;
  meso::YarnCut cut;                                             ///< of the mesh in A
  std::array<meso::Picture, strain_quantities.size()> strain;    ///< on that cut
  std::array<meso::ShearBands, strain_quantities.size()> bands;  ///< of the size of each on it
};

/// A yarn shown in detail.
struct YarnDetail {
  Index yarn = 0;
  std::vector<StationCut> cuts;
  std::vector<meso::Section> strip;  ///< in B, at equal distances along the yarn
  /// Of the size of each strain on all these cuts, see meso::DirectionalCorrelation.
  std::array<Correlations, strain_quantities.size()> correlation = {};
};

/// Means over sections along a yarn; strains weighted by reference volume.
struct SectionMeans {
  double width = 0, height = 0, fill = 0;  ///< m, m, 1
  double lenticular = 0;                   ///< share of the sections that are nearer to a lens than to an ellipse
};
struct YarnMeans {
  Index yarn = 0;
  SectionMeans a, b;
  std::array<double, strain_quantities.size()> strain{};  ///< of `strain_quantities`; NaN without a mesh
  double axial_side = 0, axial_centre = 0;  ///< means of the fibers' own axial strain, see meso::side_to_centre
};

/// Two states and all that is computed from them.
struct ReportData {
  const micro::SnapshotHeader& header;
  StatePair pair;
  micro::FiberConfiguration reference;
  micro::Increment a, b;
  std::vector<YarnField> fields;  ///< all yarns
  std::vector<YarnMeans> means;   ///< all yarns
  std::vector<YarnDetail> details;
  std::vector<meso::YarnContinuum> continuum;  ///< all yarns
};

/// One for each pair. `detailed`: the yarns to show station by station. `states` must outlive the result. Throws
/// InputError for states that cannot be read or meshed.
[[nodiscard]] std::vector<ReportData> report_data(const meso::FiberStates& states, const std::vector<StatePair>& pairs,
                                                  const std::vector<Index>& detailed);

}  // namespace trame::workflows
