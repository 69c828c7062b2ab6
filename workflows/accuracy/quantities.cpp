/// Quantities of interest of a finished run: forces of a weave's sides or what the driven bodies did, facts of the
/// fabric, strains of the yarns' fibers, energies.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "meso/comparison.h"
#include "micro/core/wildcard.h"
#include "micro/states/snapshot.h"
#include "workflows/accuracy/quantity.h"
#include "workflows/curves/curves_table.h"

namespace trame::workflows {

using namespace micro;

namespace {

constexpr std::array family_names = {"warp", "weft", "free"};

/// A row of curves.csv: index 0 warp, 1 weft.
struct SideRow {
  std::string stage;
  std::array<double, 2> strain{}, force{};  ///< 1, N
};

/// Increments only.
std::vector<SideRow> side_rows(const CurvesTable& table) {
  std::array<std::size_t, 4> at{};
  for (std::size_t c = 0; c < at.size(); ++c) {
    const auto found = table.find(side_columns[c]);
    if (!found) return {};
    at[c] = *found;
  }
  std::vector<SideRow> rows;
  for (const CurvesTable::Row& row : table.rows)
    if (row.stage_time > 0)
      rows.push_back({row.stage, {row.values[at[0]], row.values[at[1]]}, {row.values[at[2]], row.values[at[3]]}});
  return rows;
}

/// Force of a side at a strain, from a straight line between two increments.
double force_at(const std::vector<SideRow>& rows, std::size_t first, int driven, int side, double strain) {
  for (std::size_t i = first; i < rows.size(); ++i) {
    if (strain == 0) return rows.back().force[side];
    const double a = i == first ? 0 : rows[i - 1].strain[driven], b = rows[i].strain[driven];
    if (std::abs(b) + 1e-12 < std::abs(strain)) continue;
    const double force_a = i == 0 ? 0 : rows[i - 1].force[side];
    return b == a ? rows[i].force[side] : force_a + (rows[i].force[side] - force_a) * (strain - a) / (b - a);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// Forces of both sides at quarters of the last stage's strain.
void add_side_forces(const std::vector<SideRow>& rows, std::vector<Quantity>& quantities) {
  if (rows.empty()) return;
  std::size_t first = rows.size() - 1;
  while (first > 0 && rows[first - 1].stage == rows.back().stage) --first;
  const int driven = rows.back().strain[0] != 0 ? 0 : 1;
  const double end = rows.back().strain[driven];
  for (int side = 0; side < 2; ++side)
    for (const double part : {0.25, 0.5, 0.75, 1.0}) {
      if (end == 0 && part < 1) continue;
      quantities.push_back({fmt::format("{}_force_at_{:.4g}%_N", family_names[side], 100 * part * end),
                            force_at(rows, first, driven, side, part * end), "forces", true});
    }
}

/// Of bodies that the last stage loads: how far they went. Of those that it moves: the force that this took.
void add_bodies(const Scene& scene, const SnapshotHeader& header, const Increment& start, const Increment& last,
                std::vector<Quantity>& quantities) {
  for (const Drive& drive : scene.stages.back().drives)
    for (std::size_t b = 0; b < header.body_names.size(); ++b) {
      const int d = static_cast<int>(drive.dof);
      if (!matches(drive.bodies, header.body_names[b]) || drive.mode == DriveMode::follow) continue;
      const std::string name = fmt::format("{}_{}", header.body_names[b], dof_name(drive.dof));
      if (drive.mode != DriveMode::force && drive.value != 0)
        quantities.push_back({name + (d < 3 ? "_force_N" : "_moment_Nm"),
                              d < 3 ? last.bodies.force[b][d] : last.bodies.moment[b][d - 3],
                              d < 3 ? "forces" : "moments", true});
      if (drive.mode == DriveMode::force && d < 3)
        quantities.push_back(
            {name + "_m", last.bodies.position[b][d] - start.bodies.position[b][d], "displacements", true});
    }
}

/// Facts of the fabric at the end, the same numbers as in summary.json.
void add_fabric(const meso::FabricFacts& fabric, std::vector<Quantity>& quantities) {
  quantities.push_back({"thickness_m", fabric.thickness, "thickness", false});
  quantities.push_back({"warp_crimp", fabric.warp.crimp.mean, "crimp", false});
  quantities.push_back({"weft_crimp", fabric.weft.crimp.mean, "crimp", false});
}

/// Axial strains of single fibers, not of the yarns' meshes: sums over the yarns of a family, at their stations.
struct FamilyStrains {
  double sum = 0, largest = -std::numeric_limits<double>::infinity(), side = 0, centre = 0;
  Index n = 0;
};

void add_yarn(const meso::YarnComparison& yarn, FamilyStrains& strains) {
  for (const meso::SectionPair& pair : yarn.sections) {
    if (!pair.is_station()) continue;
    for (const double e : pair.fiber_strain) {
      if (!std::isfinite(e)) continue;
      strains.sum += e;
      strains.largest = std::max(strains.largest, e);
      ++strains.n;
    }
  }
  if (!std::isfinite(yarn.means.axial_side) || !std::isfinite(yarn.means.axial_centre)) return;
  strains.side += yarn.means.axial_side;
  strains.centre += yarn.means.axial_centre;
}

void add_yarns(const FiberMesh& mesh, const meso::Comparison& comparison, std::vector<Quantity>& quantities) {
  for (const YarnFamily family : {YarnFamily::warp, YarnFamily::weft, YarnFamily::free}) {
    FamilyStrains strains;
    for (const meso::YarnComparison& yarn : comparison.yarns)
      if (mesh.yarns[yarn.yarn].family == family) add_yarn(yarn, strains);
    if (strains.n == 0) continue;
    const std::string name = family_names[static_cast<std::size_t>(family)];
    quantities.push_back({name + "_mean_fiber_strain", strains.sum / strains.n, "mean fiber strain", false});
    quantities.push_back({name + "_largest_fiber_strain", strains.largest, "largest fiber strain", false});
    if (family != YarnFamily::free && strains.centre != 0)
      quantities.push_back({name + "_side_to_centre", strains.side / strains.centre, "side to centre", false});
  }
}

}  // namespace

std::vector<Quantity> read_quantities(const Scene& scene, const std::filesystem::path& folder) {
  std::vector<Quantity> quantities;
  const meso::RunStates states(folder / "states.h5");
  const Increment last = states.read(states.n_increments() - 1), start = states.read(0);
  if (scene.weave)
    add_side_forces(side_rows(read_curves(folder / "curves.csv")), quantities);
  else
    add_bodies(scene, states.header(), start, last, quantities);
  const meso::YarnComparer comparer(states, {.bands_of = std::vector<Index>(), .n_threads = 1});
  const meso::Comparison comparison = comparer.compare(meso::pairs_of_run(states).back());
  if (comparison.fabric) add_fabric(*comparison.fabric, quantities);
  add_yarns(states.header().mesh, comparison, quantities);
  const EnergyRecord& energy = last.solver.energy;
  quantities.push_back({"stored_energy_J", energy.stored, "stored energy", false});
  quantities.push_back({"friction_energy_J", energy.friction, "friction energy", false});
  std::erase_if(quantities, [](const Quantity& q) { return !std::isfinite(q.value); });
  return quantities;
}

}  // namespace trame::workflows
