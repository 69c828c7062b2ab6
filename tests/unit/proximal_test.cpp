/// \file
/// The proximal term over a stage, and when fibers travel.

#include "micro/solve/proximal.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/finite_differences.h"

namespace trame::micro {
namespace {

TEST(ProximalTerm, FallsGeometricallyAndVanishesAtTheEndWhereItsEndIsZero) {
  const test::TwoFibers scene(FiberModel::rod);
  Proximal constant(scene.layout, {.first_node = 2, .start = 0.3, .end = 0.3});
  Proximal falling(scene.layout, {.first_node = 2, .start = 1, .end = 1e-2});
  Proximal vanishing(scene.layout, {.first_node = 2, .start = 1, .end = 0});
  for (Proximal* term : {&constant, &falling, &vanishing}) term->begin_step(scene.state, 0.5);
  EXPECT_DOUBLE_EQ(constant.eta(), 0.3);
  EXPECT_NEAR(falling.eta(), 0.1, 1e-12);
  EXPECT_NEAR(vanishing.eta(), std::pow(10, -1.5), 1e-12);
  for (Proximal* term : {&constant, &falling, &vanishing}) term->begin_step(scene.state, 1);
  EXPECT_NEAR(falling.eta(), 1e-2, 1e-12);
  EXPECT_EQ(vanishing.eta(), 0);
}

TEST(ProximalTerm, HoldsFibersBackThatTravelAgainAndAgain) {
  const test::TwoFibers scene(FiberModel::rod);
  Proximal proximal(scene.layout, {.first_node = 2, .start = 0.3, .end = 0.3});
  proximal.begin_step(scene.state, 0.5);
  for (int n = 0; n < 4; ++n) proximal.hold_back();
  EXPECT_DOUBLE_EQ(proximal.eta(), 0.3);
  for (int n = 0; n < 2; ++n) proximal.hold_back();
  EXPECT_DOUBLE_EQ(proximal.eta(), 1.2);
  for (int n = 0; n < 100; ++n) proximal.hold_back();
  EXPECT_DOUBLE_EQ(proximal.eta(), 1024 * 0.3);
  proximal.begin_step(scene.state, 0.6);
  EXPECT_DOUBLE_EQ(proximal.eta(), 0.3);
}

}  // namespace
}  // namespace trame::micro
