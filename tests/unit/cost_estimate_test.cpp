/// \file
/// What effects are said to cost before a run: every one has a price, and without it the run is said to be cheaper.

#include "micro/cost_estimate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <functional>
#include <string>

#include "micro/model/model.h"
#include "micro/simulate.h"
#include "tests/support/run_scene.h"

namespace trame::micro {
namespace {

Scene plain_small() { return read_scene(TRAME_DATA_DIR "/scenes/plain_small.toml"); }

/// The price of an effect; nothing where the scene does not call for it.
const EffectCost* price(const CostEstimate& cost, PricedEffect effect) {
  const auto found =
      std::find_if(cost.effects.begin(), cost.effects.end(), [=](const EffectCost& c) { return c.effect == effect; });
  return found == cost.effects.end() ? nullptr : &*found;
}

TEST(CostEstimate, DofsAreThoseOfTheEffects) {
  const Scene scene = plain_small();
  const CostEstimate cost = estimate_cost(scene);
  // 30 fibers of 13 elements: 27 nodes of 9 dofs, or 14 of 6; 8 yarn ends and 4 sides.
  EXPECT_EQ(price(cost, PricedEffect::enriched_beams)->n_dofs, 30 * 27 * 9);
  EXPECT_EQ(price(cost, PricedEffect::rods)->n_dofs, 30 * 14 * 6);
  EXPECT_EQ(price(cost, PricedEffect::bodies)->n_dofs, 12 * 6);
  for (const auto effect :
       {PricedEffect::contact, PricedEffect::friction, PricedEffect::crossing_order, PricedEffect::proximal})
    EXPECT_EQ(price(cost, effect)->n_dofs, 0);
  EXPECT_EQ(model_size(scene).n_dofs, 30 * 27 * 9 + 12 * 6);
}

TEST(CostEstimate, TheWholeIsMoreThanItsParts) {
  const CostEstimate cost = estimate_cost(plain_small());
  double seconds = 0, largest = 0;
  for (const EffectCost& c : cost.effects) {
    EXPECT_GT(c.seconds, 0);
    seconds += c.seconds;
    largest = std::max(largest, c.bytes);
  }
  EXPECT_GT(cost.seconds, seconds);
  EXPECT_GT(cost.bytes, largest);
}

struct Switch {
  const char* name;
  PricedEffect effect;
  std::function<void(Scene&)> on, off;
};

TEST(CostEstimate, WithoutAnEffectARunIsCheaper) {
  const auto leave = [](Scene&) {};
  const Switch switches[] = {
      {"contact", PricedEffect::contact, leave, [](Scene& s) { s.contact.scope = ContactScope::none; }},
      {"self_contact", PricedEffect::self_contact, [](Scene& s) { s.contact.self_contact = true; }, leave},
      {"friction", PricedEffect::friction, leave,
       [](Scene& s) {
         s.contact.friction = false;
         for (Stage& stage : s.stages) stage.friction = false;
       }},
      {"adapt_penalty", PricedEffect::adaptation, leave, [](Scene& s) { s.contact.adapt_penalty = false; }},
      {"twist_stretch", PricedEffect::twist_stretch, leave, [](Scene& s) { s.twist_stretch = false; }},
      {"enriched beams", PricedEffect::enriched_beams, leave,
       [](Scene& s) {
         for (Stage& stage : s.stages) stage.fiber_model = FiberModel::rod;
       }},
      {"proximal", PricedEffect::proximal, leave,
       [](Scene& s) {
         for (Stage& stage : s.stages) stage.proximal_start = stage.proximal_end = 0;
       }},
      {"crossing order", PricedEffect::crossing_order, leave,
       [](Scene& s) {
         for (Stage& stage : s.stages) stage.separate_yarns = false;
       }},
  };
  for (const Switch& s : switches) {
    SCOPED_TRACE(s.name);
    Scene with = plain_small(), without = plain_small();
    s.on(with);
    s.off(without);
    const CostEstimate dear = estimate_cost(with), cheap = estimate_cost(without);
    EXPECT_NE(price(dear, s.effect), nullptr);
    EXPECT_EQ(price(cheap, s.effect), nullptr);
    // Without the crossing order ordinary contact meets yarns that lie through each other, and costs as much.
    if (s.effect == PricedEffect::crossing_order) continue;
    EXPECT_LT(cheap.seconds, dear.seconds);
    EXPECT_LE(cheap.bytes, dear.bytes);
  }
}

TEST(CostEstimate, ContactOfFewerPairsIsCheaper) {
  Scene between = plain_small();
  between.contact.scope = ContactScope::between_yarns;
  const CostEstimate all = estimate_cost(plain_small()), some = estimate_cost(between);
  EXPECT_LT(some.seconds, all.seconds);
  EXPECT_LT(some.bytes, all.bytes);
}

TEST(CostEstimate, SinglePrecisionTakesLess) {
  Scene single = plain_small();
  single.solver.factor_precision = FactorPrecision::single_precision;
  EXPECT_LT(estimate_cost(single).seconds, estimate_cost(plain_small()).seconds);
  EXPECT_LT(estimate_cost(single).bytes, estimate_cost(plain_small()).bytes);
}

TEST(CostEstimate, IsThatOfThePreconditionerInUse) {
  Scene factor = plain_small(), two_levels = plain_small();
  factor.solver.preconditioner = Preconditioner::factor;
  two_levels.solver.preconditioner = Preconditioner::two_level;
  const double bytes = estimate_cost(factor).bytes;
  EXPECT_EQ(estimate_cost(plain_small()).bytes, bytes) << "so few fibers";
  EXPECT_GT(estimate_cost(two_levels).bytes, bytes);
}

TEST(CostEstimate, BodiesHaveAPriceOnlyWhereThereAreAny) {
  Scene scene = test::cantilever(FiberModel::rod, 0.3, 100, 10);
  Stage stage;
  stage.name = "s";
  stage.drives = {{"tip", BodyDof::z, DriveMode::force, 1e-5, ""}};
  scene.stages = {stage};
  CostEstimate cost = estimate_cost(scene);
  EXPECT_EQ(price(cost, PricedEffect::bodies)->n_dofs, 12);
  EXPECT_NE(price(cost, PricedEffect::loads), nullptr);
  EXPECT_EQ(price(cost, PricedEffect::follow), nullptr);
  scene.bodies.clear();
  scene.stages[0].drives.clear();
  cost = estimate_cost(scene);
  ASSERT_EQ(cost.effects.size(), 1u);  // rods
  EXPECT_EQ(cost.effects[0].n_dofs, 6 * 11);
}

TEST(CostEstimate, IsTheSameInAnyUnit) {
  Scene scene = plain_small(), large = plain_small();
  large = nondimensional(scene, {1e-6, 1});  // in micrometres
  EXPECT_NEAR(estimate_cost(large).seconds / estimate_cost(scene).seconds, 1, 0.01);
}

/// Yarns of so many fibers: what all of them would cost is never laid out.
CostEstimate cost_of_weave(Index n_fibers) {
  Scene scene;
  scene.materials = {{"m", 3e9, 3e9, 1e9, 0.39, 0.39, 0}};
  scene.fiber_types = {{"f", 0, 1e-5, FiberModel::rod}};
  const YarnSystem yarns{{{.type = 0, .n_fibers = n_fibers, .n_layers = 4}}, {0}, 2, 6, 2e-3, 2e-3};
  scene.weave = Weave{{{true, false}, {false, true}}, yarns, yarns};
  scene.stages.resize(1);
  scene.stages[0].separate_yarns = true;
  return estimate_cost(scene);
}

TEST(CostEstimate, OfManyFibersIsExtrapolatedFromFewer) {
  const CostEstimate few = cost_of_weave(100), many = cost_of_weave(400), most = cost_of_weave(1600);
  EXPECT_FALSE(few.extrapolated);
  EXPECT_TRUE(many.extrapolated);
  EXPECT_TRUE(most.extrapolated);
  // Pairs of crossing fibers, and so the elements between them, go with the square.
  EXPECT_GT(many.bytes, 4 * few.bytes);
  EXPECT_GT(most.bytes, 8 * many.bytes);
  EXPECT_GT(many.seconds, 4 * few.seconds);
  EXPECT_GT(most.seconds, 8 * many.seconds);
}

/// Bundles side by side.
CostEstimate cost_of_bundles(Index n_bundles, Index n_fibers, Index n_elements) {
  Scene scene;
  scene.materials = {{"m", 3e9, 3e9, 1e9, 0.39, 0.39, 0}};
  scene.fiber_types = {{"f", 0, 1e-5, FiberModel::rod}};
  const double length = 5e-5 * n_elements;
  for (Index i = 0; i < n_bundles; ++i) {
    BundleSpec bundle;
    bundle.name = std::to_string(i);
    bundle.points = {Vec3(0, 1e-4 * i, 0), Vec3(length, 1e-4 * i, 0)};
    bundle.n_elements = n_elements;
    bundle.n_fibers = n_fibers;
    scene.bundles.push_back(bundle);
  }
  scene.stages.resize(1);
  return estimate_cost(scene);
}

TEST(CostEstimate, OfLongFibersIsExtrapolatedFromFewerElements) {
  const CostEstimate few = cost_of_bundles(1, 7, 200), many = cost_of_bundles(1, 7, 2000);
  EXPECT_FALSE(few.extrapolated);
  EXPECT_TRUE(many.extrapolated);
  EXPECT_EQ(price(many, PricedEffect::rods)->n_dofs, 7 * 2001 * 6);
  EXPECT_NEAR(price(many, PricedEffect::rods)->seconds / price(few, PricedEffect::rods)->seconds, 10, 5);
  EXPECT_NEAR(many.seconds / few.seconds, 10, 5);
}

TEST(CostEstimate, OfManyBundlesIsExtrapolatedFromFewer) {
  const CostEstimate few = cost_of_bundles(1000, 2, 2), many = cost_of_bundles(10'000, 2, 2);
  EXPECT_FALSE(few.extrapolated);
  EXPECT_TRUE(many.extrapolated);
  EXPECT_EQ(price(many, PricedEffect::rods)->n_dofs, 20'000 * 3 * 6);
  EXPECT_NEAR(price(many, PricedEffect::rods)->seconds / price(few, PricedEffect::rods)->seconds, 10, 3);
}

TEST(CostEstimate, StagesThatDifferInValuesAloneAreLookedAtOnce) {
  Scene one = test::cantilever(FiberModel::rod, 0.3, 100, 10);
  Stage stage;
  stage.drives = {{"tip", BodyDof::z, DriveMode::force, 1e-5, ""}};
  stage.n_increments = 6000;
  one.stages = {stage};
  Scene many = one;
  many.stages.clear();
  for (int i = 0; i < 3000; ++i) {
    stage.name = std::to_string(i);
    stage.n_increments = 1 + 2 * (i % 2);
    stage.drives[0].value = 1e-6 * i;
    many.stages.push_back(stage);
  }
  const std::clock_t begin = std::clock();
  const CostEstimate cost = estimate_cost(many);
  EXPECT_LT(std::clock() - begin, CLOCKS_PER_SEC / 2) << "of processor time; looking at each takes more";
  EXPECT_NEAR(cost.seconds / estimate_cost(one).seconds, 1, 1e-6);
}

}  // namespace
}  // namespace trame::micro
