#include "micro/run/stage_settings.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "micro/fiber/rod_space.h"
#include "micro/scene/tolerances.h"

namespace trame::micro {

namespace {

double smallest_radius(const StageModel& model) {
  const auto& radius = model.field.mesh().radius;
  return *std::min_element(radius.begin(), radius.end());
}

double longest_fiber(const StageModel& model) {
  const FiberMesh& mesh = model.field.mesh();
  double longest = 0;
  for (Index f = 0; f < mesh.n_fibers(); ++f) longest = std::max(longest, mesh.length(f));
  return longest;
}

double shortest_element(const StageModel& model) {
  double shortest = std::numeric_limits<double>::infinity();
  for (Index f = 0; f < model.field.mesh().n_fibers(); ++f)
    shortest = std::min(shortest, model.field.element_length(f));
  return shortest;
}

/// What counts as far for each unknown vector. Where there is contact: a radius for positions, and a turn of a rod's
/// tangent that moves the middle of an element by a radius. Otherwise the length of the longest fiber for positions. 1
/// for all others.
std::vector<double> units_of_motion(const StageModel& model) {
  const double radius = smallest_radius(model), far = model.has_contact() ? radius : longest_fiber(model);
  std::vector<double> units(model.layout.n_vectors(), 1.0);
  for (Index j = 0; j < model.layout.n_nodes(); ++j) units[model.layout.first_vector(j)] = far;
  if (!model.has_contact()) return units;
  // A turn of a surface that moves what it meets of the fibers by a radius.
  if (model.surface_contact)
    for (const BodySurface& on : model.surface_contact->surfaces()) {
      double arm = radius;
      for (Index n = model.bodies.n_bodies(); n < model.layout.n_nodes(); ++n)
        arm = std::max(
            arm,
            (model.start.q[model.layout.first_vector(n)] - model.bodies.pose(model.start, on.body).position).norm());
      units[model.layout.first_vector(model.bodies.node(on.body)) + 1] = radius / arm;
    }
  for (Index f = 0; f < model.field.mesh().n_fibers(); ++f) {
    if (model.field.model(f) != FiberModel::rod) continue;
    // Cubic Hermite functions of unit slopes at both ends reach a quarter of the element's length.
    const double turn = std::min(1.0, 4 * radius / model.field.element_length(f));
    for (Index n = model.field.element_node(f, 0); n <= model.field.last_node(f); ++n)
      units[model.layout.first_vector(n) + 1] = turn;
  }
  return units;
}

/// Fibers, each to be in equilibrium by itself: in strains, to 3·10⁻¹⁰.
std::vector<NewtonSettings::Part> fibers_apart(const StageModel& model) {
  constexpr double negligible_strain = 3e-10;
  const FiberMesh& mesh = model.field.mesh();
  std::vector<NewtonSettings::Part> parts;
  parts.reserve(mesh.n_fibers());
  for (Index f = 0; f < mesh.n_fibers(); ++f)
    parts.push_back({model.layout.first_vector(model.field.element_node(f, 0)),
                     model.layout.first_vector(model.field.last_node(f) + 1),
                     negligible_strain * mesh.axial_stiffness[f]});
  return parts;
}

}  // namespace

NewtonSettings newton_settings(const Scene& scene, const StageModel& model, std::function<bool()> stop) {
  NewtonSettings settings{.force_tolerance = force_tolerance(scene.solver),
                          .max_iterations = scene.solver.max_newton_iterations,
                          .step_cap = scene.solver.step_cap,
                          .linear = {.precision = scene.solver.factor_precision,
                                     .preconditioner = scene.solver.preconditioner,
                                     .coarse_space = [&model](const State& s) { return rod_space(model.field, s); }},
                          .damps_soft_modes = model.proximal == nullptr,
                          .units = units_of_motion(model),
                          .longest_arm = longest_fiber(model),
                          .shortest_arm = shortest_element(model),
                          .parts = fibers_apart(model),
                          .stop = std::move(stop)};
  if (model.has_contact()) settings.travel_cap = scene.contact.search_margin;
  // The second level knows fibers with two ends.
  if (model.field.is_periodic()) settings.linear.preconditioner = Preconditioner::factor;
  return settings;
}

LoadPathSettings load_path_settings(const Scene& scene, const Stage& stage, const StageModel& model) {
  return {.n_increments = stage.n_increments,
          .max_geometry_updates = scene.solver.max_geometry_updates,
          .friction_tolerance = friction_tolerance(scene.solver),
          .min_increment = scene.solver.min_increment,
          // Without contact the tangent makes the better guess.
          .prediction_cap = model.has_contact() ? scene.solver.step_cap * smallest_radius(model) : 0};
}

double tolerance_factor(const Stage& stage, bool is_last, double to) {
  constexpr double on_the_way = 1e3;
  if (!(stage.proximal_start > 0)) return 1;
  const bool ends_at_rest = stage.proximal_end == 0 || (is_last && !stage.separate_yarns);
  return ends_at_rest ? std::pow(on_the_way, std::min(1.0, 2 * (1 - to))) : on_the_way;
}

}  // namespace trame::micro
