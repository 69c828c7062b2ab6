/// Quantities of interest of a finished run: forces of a weave's sides or what the driven bodies did, shapes and
/// strains of the yarns, energies.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "meso/sections.h"
#include "micro/core/error.h"
#include "micro/core/wildcard.h"
#include "micro/io/snapshot.h"
#include "workflows/accuracy/quantity.h"
#include "workflows/report/report_plots.h"

namespace trame::workflows {

using namespace micro;

namespace {

constexpr std::array family_names = {"warp", "weft", "free"};

/// Force of a side at a strain, from a straight line between two increments.
double force_at(const std::vector<CurveRow>& rows, std::size_t first, int driven, int side, double strain) {
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
void add_side_forces(const std::vector<CurveRow>& rows, std::vector<Quantity>& quantities) {
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
  static constexpr std::array dofs = {"x", "y", "z", "rx", "ry", "rz"};
  for (const Drive& drive : scene.stages.back().drives)
    for (std::size_t b = 0; b < header.body_names.size(); ++b) {
      const int d = static_cast<int>(drive.dof);
      if (!matches(drive.bodies, header.body_names[b]) || drive.mode == DriveMode::follow) continue;
      const std::string name = fmt::format("{}_{}", header.body_names[b], dofs[d]);
      if (drive.mode != DriveMode::force && drive.value != 0)
        quantities.push_back({name + (d < 3 ? "_force_N" : "_moment_Nm"),
                              d < 3 ? last.bodies.force[b][d] : last.bodies.moment[b][d - 3],
                              d < 3 ? "forces" : "moments", true});
      if (drive.mode == DriveMode::force && d < 3)
        quantities.push_back(
            {name + "_m", last.bodies.position[b][d] - start.bodies.position[b][d], "displacements", true});
    }
}

double thickness(const FiberMesh& mesh, const FiberConfiguration& fibers) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (Index f = 0; f < mesh.n_fibers(); ++f)
    for (Index n = mesh.first_node[f]; n < mesh.first_node[f + 1]; ++n) {
      low = std::min(low, fibers.r[n].z() - mesh.radius[f]);
      high = std::max(high, fibers.r[n].z() + mesh.radius[f]);
    }
  return high - low;
}

/// Axial strains of the fibers of a family since `a`, at nine stations of each yarn.
struct FamilyStrains {
  double sum = 0, largest = -std::numeric_limits<double>::infinity(), side = 0, centre = 0, crimp = 0;
  Index n = 0, n_sections = 0, n_yarns = 0;
};

void add_yarn(const FiberMesh& mesh, const Yarn& yarn, const Increment& a, const Increment& b, FamilyStrains& strains) {
  const meso::YarnSections sections(mesh, yarn, b.fibers);
  for (int i = 1; i < 10; ++i) {
    const meso::Section section = sections.at_fraction(0.1 * i);
    if (section.status != meso::SectionStatus::ok) continue;
    const std::vector<double> values = meso::axial_strains(mesh, section, a.fibers.r, b.fibers.r);
    for (const double e : values) {
      if (!std::isfinite(e)) continue;
      strains.sum += e;
      strains.largest = std::max(strains.largest, e);
      ++strains.n;
    }
    const meso::SideToCentre parts = meso::side_to_centre(section, values);
    if (!std::isfinite(parts.side) || !std::isfinite(parts.centre)) continue;
    strains.side += parts.side;
    strains.centre += parts.centre;
    ++strains.n_sections;
  }
  Vec3 first = Vec3::Zero(), end = Vec3::Zero();
  for (Index f = yarn.first_fiber; f < yarn.first_fiber + yarn.n_fibers; ++f) {
    first += b.fibers.r[mesh.first_node[f]] / yarn.n_fibers;
    end += b.fibers.r[mesh.first_node[f + 1] - 1] / yarn.n_fibers;
  }
  strains.crimp += sections.length() / (end - first).norm() - 1;
  ++strains.n_yarns;
}

void add_yarns(const FiberMesh& mesh, const Increment& a, const Increment& b, std::vector<Quantity>& quantities) {
  for (const YarnFamily family : {YarnFamily::warp, YarnFamily::weft, YarnFamily::free}) {
    FamilyStrains strains;
    for (const Yarn& yarn : mesh.yarns)
      if (yarn.family == family) add_yarn(mesh, yarn, a, b, strains);
    if (strains.n == 0) continue;
    const std::string name = family_names[static_cast<std::size_t>(family)];
    if (family != YarnFamily::free)
      quantities.push_back({name + "_crimp", strains.crimp / strains.n_yarns, "crimp", false});
    quantities.push_back({name + "_mean_axial_strain", strains.sum / strains.n, "mean axial strain", false});
    quantities.push_back({name + "_largest_axial_strain", strains.largest, "largest axial strain", false});
    if (family != YarnFamily::free && strains.n_sections > 0 && strains.centre != 0)
      quantities.push_back({name + "_side_to_centre", strains.side / strains.centre, "side to centre", false});
  }
}

/// Where the last stage began: the last saved increment of the stage before.
Increment start_of_last_stage(const SnapshotReader& states, const Increment& last) {
  for (Index i = states.n_increments() - 1; i-- > 0;)
    if (Increment before = states.read(i); before.stage != last.stage) return before;
  return states.read(0);
}

}  // namespace

std::vector<Quantity> read_quantities(const Scene& scene, const std::filesystem::path& folder) {
  std::vector<Quantity> quantities;
  const SnapshotReader states(folder / "states.h5");
  const Increment last = states.read(states.n_increments() - 1), start = states.read(0);
  if (scene.weave)
    add_side_forces(read_curves(folder / "curves.csv"), quantities);
  else
    add_bodies(scene, states.header(), start, last, quantities);
  const FiberMesh& mesh = states.header().mesh;
  if (scene.weave) quantities.push_back({"thickness_m", thickness(mesh, last.fibers), "thickness", false});
  add_yarns(mesh, start_of_last_stage(states, last), last, quantities);
  const EnergyRecord& energy = last.solver.energy;
  quantities.push_back({"stored_energy_J", energy.stored, "stored energy", false});
  quantities.push_back({"friction_energy_J", energy.friction, "friction energy", false});
  std::erase_if(quantities, [](const Quantity& q) { return !std::isfinite(q.value); });
  return quantities;
}

}  // namespace trame::workflows
