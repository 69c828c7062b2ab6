/// \file
/// Steps of Newton's method get shorter where they do not help, longer where they do, and those that come to nothing
/// are seen.

#include "micro/solve/step_control.h"

#include <gtest/gtest.h>

namespace trame::micro {
namespace {

TEST(StepControl, DampedStepsHaveOneCapAndATrustRadiusThatFollowsWhatWasTaken) {
  DampedSoftModes control(0.5);
  EXPECT_EQ(control.part_of(0.5), 1);
  EXPECT_EQ(control.part_of(2), 0.25);
  EXPECT_FALSE(control.wants_damping(0.6));
  control.note_taken(0.4, 0.5);
  EXPECT_DOUBLE_EQ(control.radius(), 0.2);
  EXPECT_EQ(control.cap(), 0.5);
  EXPECT_TRUE(control.wants_damping(0.25));
  EXPECT_EQ(control.damping_kept(), 1) << "the step was longer than the ball";
  control.note_taken(0.2, 1);
  EXPECT_DOUBLE_EQ(control.radius(), 0.4);
  EXPECT_EQ(control.damping_kept(), 0.25);
  control.note_taken(0.01, 1);
  EXPECT_EQ(control.radius(), 0.5);
  EXPECT_EQ(control.damping_kept(), 0) << "hardly anything moves";
  control.note_taken(1, 1e-6);
  EXPECT_DOUBLE_EQ(control.radius(), 0.5 / 64);
}

TEST(StepControl, WholeStepsAreCappedShorterAsLongAsTheResidualDoesNotFall) {
  CappedSteps control(0.8);
  EXPECT_FALSE(control.wants_damping(100));
  control.note_residual(1);
  const auto take = [&] {
    const double part = control.part_of(1.6);
    control.note_taken(1.6, part);
    return part;
  };
  for (int n = 0; n < 4; ++n) EXPECT_EQ(take(), 0.5);
  control.note_residual(0.96);
  EXPECT_EQ(control.cap(), 0.4);
  EXPECT_EQ(control.reduction(), 0.96);
  for (int n = 0; n < 3; ++n) EXPECT_EQ(take(), 0.25);
  EXPECT_EQ(control.part_of(0.4), 1) << "is not capped";
  EXPECT_FALSE(control.may_use_old_factor());
  control.note_taken(0.4, 1);
  EXPECT_TRUE(control.may_use_old_factor());
  control.note_residual(0.96);
  EXPECT_EQ(control.cap(), 0.4);
  control.note_residual(0.9);
  EXPECT_EQ(control.cap(), 0.8);
}

TEST(StepControl, ThreeStepsToNowhereInSuccessionAreHeldUp) {
  DampedSoftModes control(0.5);
  const auto take = [&](double alpha) { control.note_taken(0.4, alpha); };
  take(0.01);
  take(0.01);
  take(0.5);
  take(0.01);
  take(0.01);
  EXPECT_FALSE(control.is_held_up());
  take(0.01);
  EXPECT_TRUE(control.is_held_up());
}

}  // namespace
}  // namespace trame::micro
