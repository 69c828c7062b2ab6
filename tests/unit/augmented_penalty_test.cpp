// How a contact presses, by itself: law, preload, and when preloads rise.
#include "micro/contact/augmented_penalty.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

using namespace trame::micro;

namespace {

constexpr double k = 40.0, p_reg = 0.02, radius = 1.0, target = 0.01;

TEST(AugmentedPenalty, ForceHasAPotentialAndAnInverse) {
  constexpr double h = 1e-7;
  for (const double gap : {-0.001, -0.019, -0.021, -0.3}) {
    EXPECT_NEAR(penalty_force(gap, k, p_reg),
                (penalty_energy(gap - h, k, p_reg) - penalty_energy(gap + h, k, p_reg)) / (2 * h), 1e-6);
    EXPECT_NEAR(penalty_stiffness(gap, k, p_reg),
                (penalty_force(gap - h, k, p_reg) - penalty_force(gap + h, k, p_reg)) / (2 * h), 1e-5);
    EXPECT_NEAR(penetration_of_force(penalty_force(gap, k, p_reg), k, p_reg), -gap, 1e-12);
  }
  EXPECT_EQ(penalty_force(0.1, k, p_reg), 0);
}

/// A contact that a spring presses: by `spring` · `push` at a gap of zero.
struct Pressed : AugmentedPenalty {
  double spring = 1, push = 0, at = 0;

  Pressed(double spring, double push) : spring(spring), push(push) {
    unit_penalty = k;
    set_scale(1);
    settle();
  }
  [[nodiscard]] double gap() const { return at; }
  [[nodiscard]] double force(double) const { return law(p_reg).force(at); }
  /// The gap at which the spring, spring · (push + gap), and the contact are in balance: bisection.
  void settle() {
    double low = -push, high = push;
    for (int i = 0; i < 200; ++i) {
      at = 0.5 * (low + high);
      (law(p_reg).force(at) > spring * (push + at) ? low : high) = at;
    }
  }
  Stiffening stiffen(double elastic_energy, double slack = 1) {
    std::vector<Pressed> one{*this};
    const Stiffening done = raise_where_too_soft(
        one, target, elastic_energy, slack, [](const Pressed&) { return radius; },
        [](const Pressed&) { return p_reg; });
    *this = one.front();
    return done;
  }
};

TEST(AugmentedPenalty, RaisingItLeavesNoPenetrationAndTheForceOfARigidContact) {
  for (const double spring : {0.1, 10.0, 1e3, 1e5}) {  // from much softer than the penalty to much stiffer
    Pressed contact(spring, 0.05);
    EXPECT_LT(contact.gap(), 0);
    int n = 0;
    for (; n < 60 && std::abs(contact.gap()) > 1e-3 * contact.push; ++n) {
      contact.raise(contact.gap(), contact.force(p_reg), p_reg);
      contact.settle();
    }
    EXPECT_LT(n, 60) << spring;
    EXPECT_NEAR(contact.force(p_reg), spring * contact.push, 2e-3 * spring * contact.push) << spring;
  }
}

TEST(AugmentedPenalty, PreloadsAreDueFromAQuarterOfWhatIsTolerated) {
  constexpr double much = 1e6;  // energy, to which nothing is lost
  const auto at_depth = [](double depth) {
    Pressed contact(1, 0);
    contact.at = -depth * radius;
    return contact;
  };
  Pressed shallow = at_depth(0.2 * target), deeper = at_depth(0.3 * target), deep = at_depth(1.1 * target);
  const Stiffening none = shallow.stiffen(much), due = deeper.stiffen(much), raised = deep.stiffen(much);
  EXPECT_FALSE(none.raised);
  EXPECT_FALSE(none.due);
  EXPECT_FALSE(due.raised);
  EXPECT_TRUE(due.due);
  EXPECT_TRUE(raised.raised);
  EXPECT_TRUE(raised.due);
  EXPECT_EQ(shallow.preload, 0);
  EXPECT_GT(deep.preload, 0);
  // On the way to rest deeper ones are let be, but are due.
  Pressed on_the_way = at_depth(1.1 * target);
  const Stiffening let_be = on_the_way.stiffen(much, 100);
  EXPECT_FALSE(let_be.raised);
  EXPECT_TRUE(let_be.due);
  // The same by energy: ½ f p is half a per cent of it, or an eighth of one.
  const double lost = 0.5 * at_depth(0.1 * target).force(p_reg) * 0.1 * target;
  EXPECT_FALSE(at_depth(0.1 * target).stiffen(lost / 0.001).due);
  EXPECT_TRUE(at_depth(0.1 * target).stiffen(lost / 0.002).due);
  EXPECT_FALSE(at_depth(0.1 * target).stiffen(lost / 0.004).raised);
  EXPECT_TRUE(at_depth(0.1 * target).stiffen(lost / 0.006).raised);
}

TEST(AugmentedPenalty, SingleOnesAreRaisedAlone) {
  constexpr double much = 1e6;
  const auto raised = [&](double depth_of_one) {
    std::vector<Pressed> contacts(20000, Pressed(1, 0.05));
    for (Pressed& c : contacts) c.at = -0.4 * target;
    contacts[7].at = depth_of_one * target;
    contacts[7].preload = 0.05;  // presses across a gap, too
    const bool any =
        raise_where_too_soft(
            contacts, target, much, 1, [](const Pressed&) { return radius; }, [](const Pressed&) { return p_reg; })
            .raised;
    EXPECT_EQ(contacts[8].preload, 0);
    EXPECT_EQ(any, contacts[7].preload != 0.05);
    return any;
  };
  EXPECT_FALSE(raised(2.9));
  EXPECT_TRUE(raised(3.1));
  EXPECT_FALSE(raised(-1.5));
}

TEST(AugmentedPenalty, AnAcceptedIncrementRaisesWhatIsDueOnce) {
  Pressed contact(1, 0.05);
  const double force = contact.force(p_reg), gap = contact.gap();
  contact.accept(gap, force, p_reg, false);
  EXPECT_EQ(contact.next_preload, 0);
  contact.accept(gap, force, p_reg, true);
  EXPECT_NEAR(penalty_force(-contact.next_preload, k, p_reg), force, 1e-12);
  // As deep again, as fibers are that are tied one in the other: it stays.
  contact.preload = contact.next_preload;
  contact.accept(gap, contact.law(p_reg).force(gap), p_reg, true);
  EXPECT_EQ(contact.next_preload, contact.preload);
  // Parted: gone.
  contact.accept(2 * contact.preload, 0, p_reg, true);
  EXPECT_EQ(contact.next_preload, 0);
}

}  // namespace
