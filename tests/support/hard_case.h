#pragma once
/// \file
/// What hard cases of micro have in common: a clear end, and small scenes of two fibers.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/measured.h"
#include "tests/support/run_scene.h"

namespace trame::micro::test {

/// Every saved number that is not finite, counted over all increments.
inline int count_not_finite(const RunResult& result) {
  int n = 0;
  const auto look = [&](const std::vector<Vec3>& values) {
    for (const Vec3& v : values) n += !v.allFinite();
  };
  const auto look_at_scalars = [&](const std::vector<double>& values) {
    for (const double v : values) n += !std::isfinite(v);
  };
  for (const Increment& i : result.increments) {
    for (const auto* v : {&i.fibers.r, &i.fibers.g1, &i.fibers.g2, &i.bodies.position, &i.bodies.force,
                          &i.bodies.moment, &i.contacts.normal, &i.contacts.friction_force})
      look(*v);
    look_at_scalars(i.contacts.gap);
    look_at_scalars(i.contacts.normal_force);
    const EnergyRecord& e = i.solver.energy;
    look_at_scalars({e.external_work, e.stored, e.friction, e.damping, e.release, e.imbalance, i.solver.residual});
  }
  return n;
}

/// Every hard case ends with a clear status and finite states, whatever else it does.
inline void expect_clear_status(const RunResult& result) {
  EXPECT_EQ(count_not_finite(result), 0);
  EXPECT_EQ(result.summary.message.empty(), result.done());
}

inline void expect_done(const RunResult& result) {
  expect_clear_status(result);
  EXPECT_TRUE(result.done()) << result.summary.message;
}

/// A point on a fiber in a saved state: mesh node nearest to a share of its length.
inline Vec3 node_at(const RunResult& result, Index fiber, double share) {
  const auto& first = result.header.mesh.first_node;
  return result.last().fibers.r[first[fiber] + std::lround(share * (first[fiber + 1] - first[fiber] - 1))];
}

/// Force of b on a and vice versa: sum of the normal forces with their directions, from a to b.
inline Vec3 normal_resultant(const Increment& increment) {
  Vec3 sum = Vec3::Zero();
  const ContactRecord& c = increment.contacts;
  for (std::size_t i = 0; i < c.gap.size(); ++i) sum += c.normal_force[i] * c.normal[i];
  return sum;
}

/// Deepest penetration of a saved state over a radius.
inline double penetration(const Increment& increment, double radius = 1) {
  double deepest = 0;
  for (const double g : increment.contacts.gap) deepest = std::max(deepest, -g / radius);
  return deepest;
}

/// What a pair of fibers is made of and how it lies: "under" along x on the origin, held at both ends by the body
/// "table"; "over" at `height` above it, turned by `angle` about z, held at both ends by the body "grip". Radius 1 and
/// modulus 1 unless changed.
struct Pair {
  FiberModel model = FiberModel::enriched;
  double angle = 0;  ///< rad
  double height = 2;
  double length = 40;
  Index n_elements = 10;
  bool friction = false;
};

inline Scene pair_scene(const Pair& p) {
  const Vec3 along = 0.5 * p.length * Vec3(std::cos(p.angle), std::sin(p.angle), 0), up(0, 0, p.height);
  Scene scene;
  scene.name = "pair";
  scene.materials = {isotropic(1, 0.3)};
  scene.fiber_types = {{"f", 0, 1.0, p.model}};
  scene.fibers = {{"under", 0, {{-0.5 * p.length, 0, 0}, {0.5 * p.length, 0, 0}}, p.n_elements, {}},
                  {"over", 0, {up - along, up + along}, p.n_elements, {}}};
  scene.bodies = {{"table", {0, 0, 0}, {{"under", FiberEnd::start, {}}, {"under", FiberEnd::end, {}}}},
                  {"grip", up, {{"over", FiberEnd::start, {}}, {"over", FiberEnd::end, {}}}}};
  scene.contact.friction = p.friction;
  return scene;
}

inline Stage stage_with(const std::string& name, Index n_increments, std::vector<Drive> drives) {
  Stage stage;
  stage.name = name;
  stage.n_increments = n_increments;
  stage.drives = std::move(drives);
  return stage;
}

inline Drive force(const std::string& body, BodyDof dof, double value) {
  return {body, dof, DriveMode::force, value, ""};
}
inline Drive displacement(const std::string& body, BodyDof dof, double value) {
  return {body, dof, DriveMode::displacement, value, ""};
}

/// External work over the size of what it turned into: the imbalance of energy at the end of a run, relative.
inline double relative_imbalance(const RunResult& result) {
  const EnergyRecord& e = result.summary.energy;
  return std::abs(e.imbalance) / std::max({std::abs(e.external_work), e.stored, e.friction + e.damping + e.release});
}

}  // namespace trame::micro::test
