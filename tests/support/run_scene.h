#pragma once
/// \file
/// Scenes built in code, run through the whole program and read back from the state file.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "micro/simulate.h"
#include "tests/support/temporary_folder.h"

namespace trame::micro::test {

/// A finished run: its summary and every saved increment; increment 0 is the reference state.
struct RunResult {
  SimulationSummary summary;
  SnapshotHeader header;
  std::vector<Increment> increments;

  [[nodiscard]] const Increment& last() const { return increments.back(); }
  [[nodiscard]] bool done() const { return summary.status == SimulationSummary::Status::done; }
  /// Mesh node at the end of a fiber.
  [[nodiscard]] Index last_node(Index fiber) const { return header.mesh.first_node[fiber + 1] - 1; }
  /// Position of the last node of a fiber in the last increment.
  [[nodiscard]] Vec3 tip(Index fiber = 0) const { return last().fibers.r[last_node(fiber)]; }
};

/// Runs a scene on `n_threads` in a folder that is gone afterwards.
inline RunResult run_scene(const Scene& scene, int n_threads = 1) {
  const trame::test::TemporaryFolder folder;
  SimulateOptions options;
  options.states = folder / "states.h5";
  options.n_threads = n_threads;
  RunResult result;
  result.summary = simulate(scene, options);
  const SnapshotReader reader(options.states);
  result.header = reader.header();
  for (Index i = 0; i < reader.n_increments(); ++i) result.increments.push_back(reader.read(i));
  return result;
}

/// Number of a body.
inline std::size_t body_named(const RunResult& result, const std::string& name) {
  const auto& names = result.header.body_names;
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

inline Material isotropic(double young_modulus, double poisson_ratio) {
  return {"m", young_modulus, young_modulus, young_modulus / (2 * (1 + poisson_ratio)), poisson_ratio, poisson_ratio};
}

/// Drives of all six dofs of a body by a dead force and no moment: a free body.
inline std::vector<Drive> free_body(const std::string& body, const Vec3& force) {
  std::vector<Drive> drives;
  drives.reserve(6);
  for (int d = 0; d < 6; ++d)
    drives.push_back({body, static_cast<BodyDof>(d), DriveMode::force, d < 3 ? force[d] : 0.0, ""});
  return drives;
}

/// A fiber of radius 1 along x, clamped to a fixed body at its start and tied to the body "tip" at its end; modulus 1.
/// What drives the tip is for the test to add. No contact, tolerances for comparisons with closed forms.
inline Scene cantilever(FiberModel model, double poisson_ratio, double length, Index n_elements) {
  Scene scene;
  scene.name = "cantilever";
  scene.materials = {isotropic(1, poisson_ratio)};
  scene.fiber_types = {{"f", 0, 1.0, model}};
  scene.fibers = {{"beam", 0, {{0, 0, 0}, {length, 0, 0}}, n_elements, {}}};
  scene.bodies = {{"wall", {0, 0, 0}, {{"beam", FiberEnd::start, TieKind::clamped}}},
                  {"tip", {length, 0, 0}, {{"beam", FiberEnd::end, TieKind::clamped}}}};
  scene.contact.scope = ContactScope::none;
  // Round-off in the stiff ties is about 1e-8 of the forces of a slender fiber, so this is as tight as it gets.
  scene.solver.force_tolerance = scene.solver.geometry_tolerance = 1e-7;
  scene.solver.step_cap = 1e9;  // for contact only
  return scene;
}

}  // namespace trame::micro::test
