/// \file
/// Penetration and force of fibers that are pressed together: the penalty law and its adaptation.

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "micro/contact/contact.h"
#include "micro/weave/crossing_order.h"
#include "tests/support/finite_differences.h"
#include "tests/support/run_scene.h"

namespace trame::micro {
namespace {

/// Two crossed fibers of radius 1, at right angles; the upper one's ends are pushed down by `force` each and then held
/// so.
Scene crossed_fibers(FiberModel model, double force) {
  constexpr double start = 1.99;  // touching, so that the pushed fiber is held from the first iteration on
  Scene scene;
  scene.name = "crossed";
  scene.materials = {test::isotropic(1, 0.3)};
  scene.fiber_types = {{"f", 0, 1.0, model}};
  scene.fibers = {{"under", 0, {{-10, 0, 0}, {10, 0, 0}}, 5, {}},
                  {"over", 0, {{0, -10, start}, {0, 10, start}}, 5, {}}};
  scene.bodies = {{"table", {0, 0, 0}, {{"under", FiberEnd::start, {}}, {"under", FiberEnd::end, {}}}},
                  {"grip", {0, 0, start}, {{"over", FiberEnd::start, {}}, {"over", FiberEnd::end, {}}}}};
  scene.contact.friction = false;
  Stage press;
  press.name = "press";
  press.n_increments = 4;
  press.drives = {{"grip", BodyDof::z, DriveMode::force, -force, ""}};
  Stage hold = press;
  hold.name = "hold";
  hold.n_increments = 12;
  scene.stages = {press, hold};
  scene.solver.force_tolerance = scene.solver.geometry_tolerance = 1e-7;
  return scene;
}

TEST(Penalty, CrossedFibersKeepTheTargetPenetration) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    // Light and heavy: the starting penalty would give very different penetrations.
    for (const double force : {2e-3, 2e-2}) {
      const Scene scene = crossed_fibers(model, force);
      const auto result = test::run_scene(scene);
      ASSERT_TRUE(result.done()) << result.summary.message;
      const ContactRecord& contacts = result.last().contacts;
      ASSERT_EQ(contacts.gap.size(), 1u);
      EXPECT_NEAR(contacts.normal_force[0], force, 1e-4 * force);  // statics
      // Preloads take over what the penalty bears.
      EXPECT_LT(std::abs(contacts.gap[0]), 1.02 * scene.contact.target_penetration) << "force " << force;
    }
  }
}

TEST(Penalty, WithoutAdaptationThePenetrationGrows) {
  Scene scene = crossed_fibers(FiberModel::enriched, 2e-2);
  scene.contact.adapt_penalty = false;
  const auto result = test::run_scene(scene);
  ASSERT_TRUE(result.done()) << result.summary.message;
  // f = k (p − p_reg/2) with k = penalty · E_T · (R_a + R_b), or k p²/(2 p_reg) below p_reg.
  const double k = scene.contact.penalty * 2, p_reg = scene.contact.regularisation, force = 2e-2;
  const double p = force < 0.5 * k * p_reg ? std::sqrt(2 * p_reg * force / k) : force / k + 0.5 * p_reg;
  EXPECT_NEAR(-result.last().contacts.gap.at(0), p, 1e-3 * p);
  EXPECT_GT(p, 2 * scene.contact.target_penetration);
}

TEST(Penalty, ParallelFibersPressWithTheLawPerLength) {
  constexpr double length = 40;
  constexpr Index n_elements = 10;
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod})
    for (const double penetration : {0.02, 0.2}) {
      Scene scene = test::cantilever(model, 0.3, length, n_elements);
      scene.fibers = {{"a", 0, {{0, 0, 0}, {length, 0, 0}}, n_elements, {}},
                      {"b", 0, {{0, 0, 2 - penetration}, {length, 0, 2 - penetration}}, n_elements, {}}};
      scene.bodies.clear();
      const Assembly assembly = assemble_scene(scene);
      Layout layout;
      const FiberField field(assembly.mesh, {model, model}, layout);
      State state;
      state.q.assign(layout.n_vectors(), Vec3::Zero());
      field.read_configuration(assembly.configuration, state);
      ContactLaw law;
      Contact contact(field, law, {0.7, 0.9});
      contact.begin_step(state, 1);
      contact.update(state);

      // Law per unit length, k = penalty · the softer modulus.
      const double k = law.penalty * 0.7, p_reg = law.regularisation, p = penetration;
      const double pressure = p < p_reg ? k * p * p / (2 * p_reg) : k * (p - p_reg / 2);
      // Resultant on b of all nodes: every inner sample stands for its length, so it is off by at most the two end
      // samples.
      const auto force = test::assemble(contact, layout, state).force;
      double total = 0;
      for (Index n = field.element_node(1, 0); n <= field.last_node(1); ++n) total -= force[layout.first_dof(n) + 2];
      const double sample = law.search.spacing * length / n_elements;
      EXPECT_GE(total, pressure * (length - 1.001 * sample));
      EXPECT_LE(total, pressure * (length + 1.001 * sample));
      for (const ContactElement& e : contact.elements()) {
        EXPECT_NEAR(-e.gap(), penetration, 1e-12);
        EXPECT_NEAR(e.length, sample, 1e-12);
      }
    }
}

// Where sections stand inclined to the chord, what fibers press with is more than what the gap is held by.
TEST(Contact, FrictionBearsUpToMuTimesTheForceThatFibersGet) {
  constexpr FiberModel model = FiberModel::enriched;
  test::TwoFibers fibers(model, test::TwoFibers::Arrangement::crossed);
  double most_inclined = 0;
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    const State state = test::perturbed(fibers.layout, fibers.state, 0.1, seed);
    ContactLaw law;
    Contact rough(fibers.field, law, {1, 1});
    law.friction = false;
    Contact smooth(fibers.field, law, {1, 1});
    for (Contact* contact : {&rough, &smooth}) {
      contact->begin_step(state, 1);
      contact->update(state);
      ASSERT_EQ(contact->elements().size(), 1u);
    }
    const auto force = test::assemble(smooth, fibers.layout, state).force;
    Vec3 of_b = Vec3::Zero();
    for (Index n = fibers.field.element_node(1, 0); n <= fibers.field.last_node(1); ++n)
      of_b += force.segment<3>(fibers.layout.first_dof(n));
    EXPECT_NEAR(rough.stick_slip().at(0).slip_limit, law.friction_coefficient * of_b.norm(), 1e-12);
    most_inclined = std::max(most_inclined, smooth.elements()[0].measured.force_direction.norm() - 1);
  }
  EXPECT_GT(most_inclined, 1e-3);
}

/// Two parallel fibers of which the second lies on the first, and the effects' view of them.
struct FiberOnFiber {
  explicit FiberOnFiber(double distance) {
    Scene scene = test::cantilever(FiberModel::rod, 0.3, 40, 10);
    scene.fibers = {{"a", 0, {{0, 0, 0}, {40, 0, 0}}, 10, {}}, {"b", 0, {{0, 0, distance}, {40, 0, distance}}, 10, {}}};
    scene.bodies.clear();
    assembly = assemble_scene(scene);
    field.emplace(assembly.mesh, std::vector{FiberModel::rod, FiberModel::rod}, layout);
    state.q.assign(layout.n_vectors(), Vec3::Zero());
    field->read_configuration(assembly.configuration, state);
  }
  Assembly assembly;
  Layout layout;
  std::optional<FiberField> field;
  State state;
};

// Fibers that an equilibrium throws out of reach of each other, and another throws back, would go to and fro for ever.
TEST(Contact, WhatHasPressedStaysUntilContactsAreLookedForAfresh) {
  FiberOnFiber fibers(1.9);
  Contact contact(*fibers.field, ContactLaw{}, {1, 1});
  contact.begin_step(fibers.state, 1);
  State apart = fibers.state;
  for (Index n = fibers.field->element_node(1, 0); n <= fibers.field->last_node(1); ++n)
    apart.q[fibers.layout.first_vector(n)].z() += 10;
  contact.update(apart, true);
  ASSERT_TRUE(contact.elements().empty());
  contact.update(fibers.state, true);
  const std::size_t n = contact.elements().size();
  ASSERT_GT(n, 0);
  for (int search = 0; search < 2; ++search) {
    (void)contact.follow(apart, Effect::Follow::iteration, everywhere);
    contact.update(apart, true);
    ASSERT_EQ(contact.elements().size(), n);
    EXPECT_GT(contact.elements().front().gap(), 9);
  }
  contact.update(apart);
  EXPECT_TRUE(contact.elements().empty());
}

TEST(Penalty, APairThatMeetsAmongLoadedOnesStartsWithTheirStiffness) {
  FiberOnFiber fibers(1.9);
  Contact contact(*fibers.field, ContactLaw{}, {1, 1});
  // Two touching samples, 3 and 5 of arc length from where nothing is known; one far off that does not touch.
  contact.set_history({{0, 1, {}, 10, 10, Vec3::UnitZ(), -1, 4, true},
                       {0, 1, {}, 14, 14, Vec3::UnitZ(), -1, 9, true},
                       {0, 1, {}, 30, 30, Vec3::UnitZ(), -1, 100, false}});
  contact.begin_step(fibers.state, 1);
  contact.update(fibers.state);
  for (const ContactElement& e : contact.elements()) {
    const double expected = std::abs(e.s_a - 10) < 2   ? 4
                            : std::abs(e.s_a - 14) < 2 ? 9
                            : std::abs(e.s_a - 30) < 2 ? 100
                            : e.s_a > 10 && e.s_a < 14 ? 6  // √(4·9): both are near
                            : e.s_a > 6 && e.s_a < 10  ? 4
                            : e.s_a > 14 && e.s_a < 18 ? 9
                                                       : 1;
    const bool at_the_edge = std::abs(e.s_a - 6) < 0.1 || std::abs(e.s_a - 18) < 0.1;
    if (!at_the_edge) {
      EXPECT_NEAR(e.penalty_scale, expected, 1e-12) << e.s_a;
    }
  }
}

TEST(Penalty, CrossingOrderStiffensToItsTargetAndHandsItsPenaltyOver) {
  Scene scene = crossed_fibers(FiberModel::rod, 0);
  scene.bodies.clear();
  const Assembly assembly = assemble_scene(scene);
  Layout layout;
  FiberMesh mesh = assembly.mesh;
  mesh.yarns = {{"under", YarnFamily::warp, 0, 1}, {"over", YarnFamily::weft, 1, 1}};
  const FiberField field(mesh, {FiberModel::rod, FiberModel::rod}, layout);
  State state;
  state.q.assign(layout.n_vectors(), Vec3::Zero());
  field.read_configuration(assembly.configuration, state);
  // The axes are 1.99 apart and shall be 2: a penetration of 0.01, whose target is 0.005.
  CrossingOrder order(field, {{1, 0}}, {.start_depth = -2, .penalty = 1, .p_reg = 0.1, .target_penetration = 0.005});
  order.begin_step(state, 1);
  order.update(state);
  ASSERT_EQ(order.history().size(), 1u);
  EXPECT_DOUBLE_EQ(order.history()[0].penalty_scale, 1);
  order.commit(state);
  order.begin_step(state, 1);
  order.update(state);
  const ContactHistory handed_over = order.history().at(0);
  EXPECT_NEAR(handed_over.penalty_scale, 4, 1e-10);  // (0.01 / 0.005)²
  EXPECT_TRUE(handed_over.touches);
  EXPECT_EQ(handed_over.fiber_a, 0);
  EXPECT_NEAR((handed_over.normal - Vec3::UnitZ()).norm(), 0, 1e-15);  // from the lower fiber to the upper
}

}  // namespace
}  // namespace trame::micro
