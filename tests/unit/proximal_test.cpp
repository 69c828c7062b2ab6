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

TEST(ProximalTerm, HoldsAnewWhatHasMovedAndBooksBothMotions) {
  const test::TwoFibers scene(FiberModel::rod);
  const auto moved = [&](double by) {
    State state = scene.state;
    for (Index n = 2; n < scene.layout.n_nodes(); ++n) state.q[scene.layout.first_vector(n)].z() += by;
    return state;
  };
  const double n_nodes = scene.layout.n_nodes() - 2;
  Proximal proximal(scene.layout, {.first_node = 2, .start = 0.3, .end = 0.3});
  proximal.begin_step(scene.state, 1);
  EXPECT_NEAR(proximal.energy(moved(2)), 0.5 * 0.3 * 4 * n_nodes, 1e-12);
  EXPECT_TRUE(proximal.hold_at(moved(2)));
  EXPECT_EQ(proximal.energy(moved(2)), 0);
  EXPECT_NEAR(proximal.energy(moved(3)), 0.5 * 0.3 * n_nodes, 1e-12);
  proximal.begin_step(scene.state, 1);  // the attempt was cut: nothing of it is booked
  EXPECT_TRUE(proximal.hold_at(moved(2)));
  proximal.commit(moved(3));
  // Forces 0 to 0.6 over the first motion, 0.6 to 0.3 over the second.
  EXPECT_NEAR(proximal.ledger(moved(3))[Sink::damping], (0.3 * 2 + 0.45 * 1) * n_nodes, 1e-12);
  Proximal none(scene.layout, {.first_node = 2, .start = 0.3, .end = 0});
  none.begin_step(scene.state, 1);
  EXPECT_FALSE(none.hold_at(moved(1)));
}

}  // namespace
}  // namespace trame::micro
