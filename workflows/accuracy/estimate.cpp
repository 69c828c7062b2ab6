#include "workflows/accuracy/estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace trame::workflows {

using namespace micro;
using nlohmann::json;

namespace {

/// Curvature vector of an element whose three nodes start at `first`: second difference of r.
Vec3 element_curvature(const FiberMesh& mesh, const std::vector<Vec3>& r, Index first) {
  const double half = 0.5 * (mesh.arc_length[first + 2] - mesh.arc_length[first]);
  return (r[first] - 2 * r[first + 1] + r[first + 2]) / (half * half);
}

/// Bending energy that the elements of a fiber miss; an end takes the second difference of its neighbour.
double missed_bending(const FiberMesh& mesh, const std::vector<Vec3>& r, Index fiber) {
  const Index n = mesh.n_elements(fiber), first = mesh.first_node[fiber];
  const double h = mesh.length(fiber) / n,
               bending = mesh.axial_stiffness[fiber] * mesh.radius[fiber] * mesh.radius[fiber] / 4;
  double sum = 0;
  for (Index e = 0; e < n; ++e) {
    const Index m = std::clamp<Index>(e, 1, n - 2);
    const Vec3 difference = element_curvature(mesh, r, first + 2 * m - 2) -
                            2 * element_curvature(mesh, r, first + 2 * m) +
                            element_curvature(mesh, r, first + 2 * m + 2);
    sum += 0.5 * bending * h * difference.squaredNorm() / 720;
  }
  return sum;
}

/// Energies gained within the last stage.
EnergyRecord gain_of_last_stage(const std::vector<EnergyPoint>& energies) {
  const EnergyRecord& b = energies.back().energy;
  const auto before = std::find_if(energies.rbegin(), energies.rend(),
                                   [&](const EnergyPoint& p) { return p.stage != energies.back().stage; });
  const EnergyRecord a = before == energies.rend() ? EnergyRecord{} : before->energy;
  return {b.external_work - a.external_work, b.stored - a.stored,  b.friction - a.friction, b.damping - a.damping,
          b.imbalance - a.imbalance,         b.release - a.release};
}

/// A run that goes on from the states of another holds their last one as increment 1: its last stage gains from there.
std::vector<EnergyPoint> with_start(const SnapshotReader& states, std::vector<EnergyPoint> energies) {
  const auto of_last_stage = [&](const EnergyPoint& p) { return p.stage == energies.back().stage; };
  if (states.n_increments() < 2 || !std::all_of(energies.begin(), energies.end(), of_last_stage)) return energies;
  const Increment first = states.read(1);
  if (first.stage != energies.front().stage) energies.insert(energies.begin(), {first.stage, first.solver.energy});
  return energies;
}

/// An error relative to a scale that is more than noise.
std::optional<double> relative(double error, double scale, double noise) {
  if (!(scale > noise) || std::isnan(error)) return std::nullopt;
  return std::min(std::abs(error) / scale, 1.0);
}

json number_or_null(const std::optional<double>& x) { return x && std::isfinite(*x) ? json(*x) : json(); }

}  // namespace

std::optional<double> PosterioriEstimate::total() const {
  if (!steps || !elements) return std::nullopt;
  return std::min(*steps + penetration.value_or(0) + *elements, 1.0);
}

double energy_noise(const FiberMesh& mesh) {
  double sum = 0;
  for (Index f = 0; f < mesh.n_fibers(); ++f) sum += 0.5 * mesh.axial_stiffness[f] * mesh.length(f);
  return 1e-18 * sum;
}

std::optional<double> step_error(const std::vector<EnergyPoint>& energies, double noise) {
  if (energies.empty()) return std::nullopt;
  const EnergyRecord gain = gain_of_last_stage(energies);
  return relative(gain.imbalance,
                  std::max({std::abs(gain.external_work), std::abs(gain.stored), std::abs(gain.friction)}), noise);
}

std::optional<double> penetration_error(const Increment& last, double noise) {
  if (last.contacts.gap.empty()) return std::nullopt;
  double complementary = 0;  // ∫ p df: 2/3 f p where the penalty is quadratic, which is its largest share
  for (std::size_t i = 0; i < last.contacts.gap.size(); ++i)
    complementary += 2.0 / 3 * last.contacts.normal_force[i] * std::max(0.0, -last.contacts.gap[i]);
  return relative(complementary, last.solver.energy.stored, noise);
}

std::optional<double> element_error(const FiberMesh& mesh, const Increment& last) {
  double missed = 0;
  bool any = false;
  for (Index f = 0; f < mesh.n_fibers(); ++f)
    if (mesh.n_elements(f) >= 3) {
      missed += missed_bending(mesh, last.fibers.r, f);
      any = true;
    }
  if (!any) return std::nullopt;
  return relative(missed, last.solver.energy.stored, energy_noise(mesh));
}

std::optional<double> interpolation_error(const std::vector<CurvePoint>& curve) {
  if (curve.empty()) return std::nullopt;
  double largest = 0, bend = 0;
  std::size_t n = 0;
  for (std::size_t i = curve.size(); i-- > 0 && curve[i].stage == curve.back().stage; ++n)
    for (int side = 0; side < 2; ++side) {
      largest = std::max(largest, std::abs(curve[i].side_force[side]));
      if (n >= 2)
        bend = std::max(bend, std::abs(curve[i].side_force[side] - 2 * curve[i + 1].side_force[side] +
                                       curve[i + 2].side_force[side]));
    }
  if (n < 3 || !(largest > 0)) return std::nullopt;
  return bend / 8 / largest;
}

PosterioriEstimate estimate_errors(const SnapshotReader& states, const std::vector<EnergyPoint>& energies,
                                   const std::vector<CurvePoint>& curve) {
  PosterioriEstimate estimate;
  if (energies.empty()) return estimate;
  const Increment last = states.read(states.n_increments() - 1);
  const FiberMesh& mesh = states.header().mesh;
  const double noise = energy_noise(mesh);
  estimate.steps = step_error(with_start(states, energies), noise);
  estimate.penetration = penetration_error(last, noise);
  estimate.elements = element_error(mesh, last);
  estimate.between_increments = interpolation_error(curve);
  return estimate;
}

json error_estimate_json(const PosterioriEstimate& estimate, const Profile* profile, const ProfileRun* run) {
  json parts = {{"steps", number_or_null(estimate.steps)},
                {"penetration", number_or_null(estimate.penetration)},
                {"elements", number_or_null(estimate.elements)},
                {"between_increments", number_or_null(estimate.between_increments)},
                {"total", number_or_null(estimate.total())}};
  if (profile != nullptr && run != nullptr)
    return {{"kind", "profile"},
            {"relative_error", profile->expected_error(*run)},
            {"covers", profile->measure + ", against " + profile->reference},
            {"study", profile->command},
            {"quantities", run->errors},
            {"a_posteriori", parts}};
  return {
      {"kind", "a posteriori"},
      {"relative_error", parts.at("total")},
      {"covers",
       "an order of magnitude for energies and, on average, forces of the last stage: energy lost in its steps, "
       "penetration of "
       "contacts, bending that elements cannot follow (not known with fewer than three elements a fiber); at most 1, "
       "and none where nothing is strained. Not covered: which of several equilibria weaving has led to, shear and "
       "stretch "
       "within elements, ties, what the material data are worth"},
      {"a_posteriori", parts}};
}

}  // namespace trame::workflows
