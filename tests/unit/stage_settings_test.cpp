/// \file
/// How exact increments on the way are: tolerances of a stage, and the stiffness of contact that they ask for.

#include "micro/run/stage_settings.h"

#include <gtest/gtest.h>

#include <utility>

#include "tests/support/finite_differences.h"

namespace trame::micro {
namespace {

Stage damped_stage(double start, double end) {
  Stage stage;
  stage.proximal_start = start;
  stage.proximal_end = end;
  return stage;
}

TEST(Tolerances, FallToThoseOfEquilibriaWhereAStageEndsAtRest) {
  const Stage vanishing = damped_stage(0.1, 0), kept = damped_stage(0.1, 0.1);
  for (const auto& [stage, is_last] : {std::pair{&vanishing, false}, {&vanishing, true}, {&kept, true}}) {
    EXPECT_DOUBLE_EQ(tolerance_factor(*stage, is_last, 0.1), tolerance_factor(*stage, is_last, 0.5));
    double before = tolerance_factor(*stage, is_last, 0.5);
    for (double to = 0.55; to < 1; to += 0.05) {
      const double factor = tolerance_factor(*stage, is_last, to);
      EXPECT_LT(factor, before);
      EXPECT_GT(factor, 1);
      before = factor;
    }
    EXPECT_EQ(tolerance_factor(*stage, is_last, 1), 1);
  }
}

TEST(Tolerances, AreThoseOfEquilibriaWithoutDamping) {
  for (const double to : {0.01, 0.5, 1.0}) EXPECT_EQ(tolerance_factor(damped_stage(0, 0), false, to), 1);
}

TEST(Tolerances, StayLooseWhereDampingDoes) {
  Stage separation = damped_stage(0.1, 0.1);
  EXPECT_GT(tolerance_factor(separation, false, 1), 1) << "fibers are on their way into the next stage";
  separation.separate_yarns = true;
  EXPECT_GT(tolerance_factor(separation, true, 1), 1);
}

/// Two crossed fibers that press on each other.
struct PressedFibers {
  PressedFibers() {
    contact.begin_step(scene.state, 1);
    contact.update(scene.state);
  }
  test::TwoFibers scene{FiberModel::rod, test::TwoFibers::Arrangement::crossed};
  ContactLaw law;
  Contact contact{scene.field, law, {1, 1}};
};

/// Whether their contact makes itself stiffer.
bool is_stiffened(double elastic_energy, double slack) {
  PressedFibers pressed;
  return pressed.contact.stiffen(pressed.scene.state, elastic_energy, slack);
}

TEST(ContactStiffness, IsJudgedBySlackTolerancesOnTheWay) {
  const PressedFibers pressed;
  const Contact& contact = pressed.contact;
  ASSERT_EQ(contact.elements().size(), 1u);
  const ContactElement& element = contact.elements()[0];
  // By its penetration, whatever the fibers store ...
  const double plenty = 1e9, by_depth = contact.max_penetration_over_radius() / pressed.law.target_penetration;
  ASSERT_GT(by_depth, 1);
  EXPECT_FALSE(is_stiffened(plenty, 1.01 * by_depth));
  EXPECT_TRUE(is_stiffened(plenty, 0.99 * by_depth));
  // ... and by the work that its force has lost on it, however little that is of a radius.
  const double lost = 0.5 * element.force(contact.regularisation(element)) * -element.gap(), loose = 1e3;
  ASSERT_GT(loose, by_depth);
  const double least = lost / (0.005 * loose);
  EXPECT_FALSE(is_stiffened(1.01 * least, loose));
  EXPECT_TRUE(is_stiffened(0.99 * least, loose));
}

TEST(ContactStiffness, EachIncrementBeginsWithTheForceOfTheLastAtNoPenetration) {
  PressedFibers pressed;
  Contact& contact = pressed.contact;
  const State& state = pressed.scene.state;
  const auto next_increment = [&] {
    contact.commit(state);
    contact.begin_step(state, 1);
    contact.update(state);
    return contact.elements().at(0);
  };
  const ContactElement before = contact.elements().at(0);
  const double p_reg = contact.regularisation(before), f = before.force(p_reg);
  const ContactElement raised = next_increment();
  EXPECT_NEAR(raised.law(p_reg).force(0), f, 1e-12 * f);
  // Fibers that do not give way, as tied ends, are not pressed on ever more.
  const ContactElement again = next_increment();
  EXPECT_NEAR(again.law(p_reg).force(0), f, 1e-12 * f);
}

}  // namespace
}  // namespace trame::micro
