/// \file
/// Contact forces of a pair: action and reaction, and no preference for either fiber.

#include <gtest/gtest.h>

#include "micro/contact/contact.h"
#include "tests/support/finite_differences.h"
#include "tests/support/run_scene.h"

namespace trame::micro {
namespace {

using Points = std::vector<Vec3>;

/// Fibers of radius 1 with contact between them at the state in which the scene lays them.
struct Touching {
  Touching(FiberModel model, const std::vector<Points>& fibers, bool with_friction, Index moved = 1)
      : assembly(make_assembly(model, fibers)), field(assembly.mesh, std::vector(fibers.size(), model), layout),
        contact(field, law(with_friction), std::vector(fibers.size(), 1.0)) {
    state.q.assign(layout.n_vectors(), Vec3::Zero());
    field.read_configuration(assembly.configuration, state);
    // Friction needs a slip since the start of the step.
    State start = state;
    for (Index n = field.element_node(moved, 0); with_friction && n <= field.last_node(moved); ++n)
      start.q[layout.first_vector(n)] += Vec3(0.01, -0.02, 0.005);
    contact.begin_step(start, 1);
    contact.update(state);
    force = test::assemble(contact, layout, state).force;
  }
  static Assembly make_assembly(FiberModel model, const std::vector<Points>& fibers) {
    Scene scene;
    scene.materials = {test::isotropic(1, 0.3)};
    scene.fiber_types = {{"f", 0, 1.0, model}};
    for (std::size_t i = 0; i < fibers.size(); ++i)
      scene.fibers.push_back({std::to_string(i), 0, fibers[i], 5, Vec3(0.3, 0.4, 1)});
    return assemble_scene(scene);
  }
  static ContactLaw law(bool with_friction) {
    ContactLaw law;
    law.friction = with_friction;
    law.penalty = 0.5;
    law.friction_coefficient = 0.4;
    return law;
  }
  [[nodiscard]] Vec3 force_at(Index vector) const { return force.segment<3>(3 * vector); }
  /// Sum of the forces on the centre-line unknowns of one fiber. A rod's tangents carry no net force.
  [[nodiscard]] Vec3 resultant(Index fiber) const {
    Vec3 sum = Vec3::Zero();
    for (Index n = field.element_node(fiber, 0); n <= field.last_node(fiber); ++n)
      sum += force_at(layout.first_vector(n));
    return sum;
  }
  /// Virtual work of a rigid rotation about the origin: Σ q × f over all vectors, whatever they stand for.
  [[nodiscard]] Vec3 moment() const {
    Vec3 sum = Vec3::Zero();
    for (Index v = 0; v < layout.n_vectors(); ++v) sum += state.q[v].cross(force_at(v));
    return sum;
  }

  Assembly assembly;
  Layout layout;
  FiberField field;
  Contact contact;
  State state;
  Eigen::VectorXd force;
};

const Points along = {{0, 0, 0}, {10, 0.4, 0.2}, {20, 0.1, 0}};
const Points beside = {{1, 0.1, 1.93}, {10, 0.3, 2.1}, {21, 0.3, 1.95}};
const Points beside_backward = {{21, 0.3, 1.95}, {10, 0.3, 2.1}, {1, 0.1, 1.93}};
const Points across = {{9, -10, 1.95}, {10, 0, 1.97}, {12, 10, 2.1}};
const std::vector<std::vector<Points>> pairs = {{along, beside}, {along, beside_backward}, {along, across}};

TEST(ContactSymmetry, ForcesAreEqualAndOpposite) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod})
    for (const auto& pair : pairs)
      for (const bool with_friction : {false, true}) {
        const Touching t(model, pair, with_friction);
        ASSERT_GT(t.resultant(0).norm(), 1e-3) << "no contact";
        EXPECT_LT((t.resultant(0) + t.resultant(1)).norm(), 1e-12);
      }
}

TEST(ContactSymmetry, NormalForcesOfRodsHaveNoMoment) {
  // The normal is the direction of the chord, along which both forces act.
  for (const auto& pair : pairs) {
    const Touching t(FiberModel::rod, pair, false);
    EXPECT_LT(t.moment().norm(), 1e-11 * 20 * t.force.norm());
  }
}

TEST(ContactSymmetry, NormalForcesOfStraightEnrichedFibersHaveNoMoment) {
  const Points crossing = {{10, -10, 1.95}, {10, 10, 1.95}}, parallel = {{0, 0.3, 1.9}, {20, 0.3, 1.9}};
  for (const Points& other : {crossing, parallel}) {
    const Touching t(FiberModel::enriched, {{{0, 0, 0}, {20, 0, 0}}, other}, false);
    ASSERT_GT(t.resultant(0).norm(), 1e-3) << "no contact";
    EXPECT_LT(t.moment().norm(), 1e-11 * 20 * t.force.norm());
  }
}

TEST(ContactSymmetry, SwappingTheFibersChangesNothing) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod})
    for (const auto& pair : pairs)
      for (const bool with_friction : {false, true}) {
        const Touching one(model, pair, with_friction, 1), other(model, {pair[1], pair[0]}, with_friction, 0);
        const Eigen::Index half = one.force.size() / 2;
        EXPECT_EQ(one.contact.elements().size(), other.contact.elements().size());
        EXPECT_LT((one.force.head(half) - other.force.tail(half)).norm(), 1e-9 * one.force.norm());
        EXPECT_LT((one.force.tail(half) - other.force.head(half)).norm(), 1e-9 * one.force.norm());
      }
}

}  // namespace
}  // namespace trame::micro
