/// \file
/// How contact follows fibers within an increment: to the lowest gap, and around each other.

#include "micro/contact/contact.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/support/finite_differences.h"

namespace trame::micro {
namespace {

using test::TwoFibers;

/// Of the elements that press, how far the worst of their feet is from where it feels nothing along its fiber, over the
/// distance of the axes.
double restlessness(const Contact& contact) {
  double worst = 0;
  for (const ContactElement& e : contact.elements()) {
    if (e.gap() > 0) continue;
    const Chord& chord = e.pair.chord;
    for (int i = 0; i < chord.n_free; ++i)
      worst = std::max(worst, std::abs(chord.free[i].dot(e.measured.lean - e.pair.lean)) / chord.c.norm());
  }
  return worst;
}

/// Sections of all fibers incline against their axes, by an angle that grows and falls along them; as a parabola, which
/// elements and what is smooth over them agree on.
void incline_sections(const TwoFibers& scene, double angle, State& state) {
  for (Index f = 0; f < 2; ++f) {
    const Index first = scene.field.element_node(f, 0), last = scene.field.last_node(f);
    for (Index n = first; n <= last; ++n) {
      const double at = static_cast<double>(n - first) / static_cast<double>(last - first);
      const Vec3 tangent = scene.field.curve(state, f, at * scene.field.mesh().length(f)).tangent;
      Vec3* q = state.q.data() + scene.layout.first_vector(n);
      for (int v = 1; v <= 2; ++v) q[v] += angle * 4 * at * (1 - at) * tangent;
    }
  }
}

// Where sections incline, a gap is not lowest where axes are nearest. Feet have to find the lowest one from wherever
// they were, or forces would go with how they came there.
TEST(Contact, FeetFindTheLowestGapOfInclinedSections) {
  for (const auto arrangement : {TwoFibers::Arrangement::side_by_side, TwoFibers::Arrangement::crossed})
    for (const double angle : {0.05, 0.2, 0.4}) {
      TwoFibers scene(FiberModel::enriched, arrangement);
      Contact contact(scene.field, {}, {1, 1});
      contact.begin_step(scene.state, 1);
      contact.update(scene.state);
      State inclined = scene.state;
      incline_sections(scene, angle, inclined);
      (void)contact.follow(inclined, Effect::Follow::iteration, everywhere);
      EXPECT_LT(restlessness(contact), 1e-8) << angle;
      const Eigen::VectorXd at_once = test::assemble(contact, scene.layout, inclined).force;
      // By another way.
      State other = scene.state;
      incline_sections(scene, -0.5 * angle, other);
      (void)contact.follow(other, Effect::Follow::iteration, everywhere);
      (void)contact.follow(inclined, Effect::Follow::iteration, everywhere);
      EXPECT_LT((test::assemble(contact, scene.layout, inclined).force - at_once).norm(), 1e-6 * at_once.norm());
    }
}

/// ∂g/∂s of a pair at feet that are anywhere, which vanishes where they rest: by its free directions.
Vec2 felt_by_feet(const TwoFibers& scene, const State& state, ContactElement e, const Vec2& ds) {
  const Chord resting = e.pair.chord;
  Foot a = resting.a, b = resting.b;
  a.s += ds[0];
  b.s += ds[1];
  e.pair.chord = chord_between(scene.field, state, a, b);
  measure(scene.field, state, e);
  const Hold& hold = e.pair.hold;
  const double held = e.pair.point ? hold.stiffness * hold.distance(e.pair.chord) : 0;
  Vec2 felt = Vec2::Zero();
  for (int i = 0; i < resting.n_free; ++i)
    felt[i] =
        e.measured.inverse_length * resting.free[i].dot(e.pair.chord.slope() + held * hold.along() + e.measured.lean);
  return felt;
}

TEST(Contact, FeetSlideAsTheGapCurves) {
  for (const auto arrangement : {TwoFibers::Arrangement::side_by_side, TwoFibers::Arrangement::crossed}) {
    TwoFibers scene(FiberModel::enriched, arrangement);
    State inclined = scene.state;
    incline_sections(scene, 0.4, inclined);
    // Away from where elements join, at which curvatures jump.
    for (Index n = scene.field.element_node(1, 0); n <= scene.field.last_node(1); ++n)
      inclined.q[scene.layout.first_vector(n)] += Vec3(0.9, 0.7, 0);
    Contact contact(scene.field, {}, {1, 1});
    contact.begin_step(inclined, 1);
    contact.update(inclined);
    (void)contact.follow(inclined, Effect::Follow::iteration, everywhere);
    int n = 0;
    for (const ContactElement& e : contact.elements()) {
      const Gap::Sliding& sliding = e.measured.sliding;
      if (e.gap() > 0 || sliding.n == 0) continue;
      ++n;
      constexpr double h = 1e-5;
      Eigen::MatrixXd curvature(sliding.n, sliding.n);
      for (int i = 0; i < sliding.n; ++i) {
        const Vec2 ds = h * e.pair.chord.free[i];
        curvature.col(i) =
            ((felt_by_feet(scene, inclined, e, ds) - felt_by_feet(scene, inclined, e, -ds)) / (2 * h)).head(sliding.n);
      }
      const Eigen::MatrixXd product = curvature * sliding.inverse.topLeftCorner(sliding.n, sliding.n);
      EXPECT_LT((product - Eigen::MatrixXd::Identity(sliding.n, sliding.n)).norm(), 2e-3) << product;
    }
    EXPECT_GE(n, 1);
  }
}

/// Fiber b, turned about the axis of x.
State rolled(const TwoFibers& scene, double angle) {
  State state = scene.state;
  const Mat3 turn = rotation_matrix({angle, 0, 0});
  for (Index n = scene.field.element_node(1, 0); n <= scene.field.last_node(1); ++n)
    for (int v = 0; v < scene.layout.n_vectors(n); ++v) {
      Vec3& q = state.q[scene.layout.first_vector(n) + v];
      q = turn * q;
    }
  return state;
}

/// Smallest gap.
double deepest(const Contact& contact) {
  double gap = 0;
  for (const ContactElement& e : contact.elements()) gap = std::min(gap, e.gap());
  return gap;
}

// A fiber that rolls to the other side of another one has not passed through it; one that is there at once has.
TEST(Contact, RollingAroundIsNotPassingThrough) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    TwoFibers scene(model);
    Contact contact(scene.field, {}, {1, 1});
    contact.begin_step(scene.state, 1);
    contact.update(scene.state);
    const double at_start = deepest(contact);
    ASSERT_LT(at_start, 0);
    constexpr int n = 12;
    for (int i = 1; i <= n; ++i)
      (void)contact.follow(rolled(scene, i * std::numbers::pi / n), Effect::Follow::iteration, everywhere);
    EXPECT_GT(deepest(contact), -0.5);
    contact.update(scene.state);
    (void)contact.follow(rolled(scene, std::numbers::pi), Effect::Follow::iteration, everywhere);
    EXPECT_LT(deepest(contact), -3);  // pushed back all the way
  }
}

}  // namespace
}  // namespace trame::micro
