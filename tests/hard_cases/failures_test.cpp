/// \file
/// What cannot be solved ends with a clear status and the last good state; what is not a number is caught where it is
/// born.

#include <limits>
#include <numbers>

#include "micro/model/model.h"
#include "micro/run/stage_settings.h"
#include "micro/weave/flat_start.h"
#include "tests/support/hard_case.h"

namespace trame::micro {
namespace {

using namespace test;

/// Where and what a bad effect spoils.
enum class Spoils { force, held_force, infinite_force, tangent, energy };

/// An effect of an unsound model: fine up to a stage time, then not a number.
class Unsound final : public Effect {
 public:
  Unsound(const Layout& layout, Spoils what, double from) : layout_(layout), what_(what), from_(from) {}
  [[nodiscard]] std::string_view name() const override { return "unsound"; }
  void begin_step(const State&, double stage_time) override { bad_ = stage_time > from_; }
  void add_sparsity(Pattern::Builder&) const override {}
  void add(const State&, Assembler& assembler) const override {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
    const Index last = layout_.n_nodes() - 1;
    if (!bad_) return;
    if (what_ == Spoils::force) assembler.add_force(last - 4, 0, Vec3(nan, 0, 0));
    if (what_ == Spoils::held_force) assembler.add_force(0, 0, Vec3(nan, 0, 0));
    if (what_ == Spoils::infinite_force) assembler.add_force(last - 4, 0, Vec3(0, infinite, 0));
    if (what_ == Spoils::tangent && assembler.wants_tangent() && assembler.owns(last))
      *assembler.block(last, last).data = nan;
  }
  [[nodiscard]] double energy(const State&) const override {
    return bad_ && what_ == Spoils::energy ? std::numeric_limits<double>::quiet_NaN() : 0;
  }

 private:
  const Layout& layout_;
  Spoils what_;
  double from_;
  bool bad_ = false;
};

struct StageRun {
  StageOutcome outcome;
  State last_accepted, end;
  int n_accepted = 0;
};

/// A pressed pair of fibers with one more effect, through one stage of ten increments.
StageRun run_with(Spoils what, double from) {
  Scene scene = pair_scene({});
  scene.fibers[1].points = {{0, -20, 2}, {0, 20, 2}};
  scene.stages = {stage_with("press", 10, {displacement("grip", BodyDof::z, -0.5)})};
  const Assembly assembly = assemble_scene(scene);
  StageModel model(scene, assembly, scene.stages[0], start_of(assembly));
  model.effects.push_back(std::make_unique<Unsound>(model.layout, what, from));

  Timers timers;
  NewtonSolver newton(model.layout, newton_settings(scene, model, [] { return false; }), 1, timers);
  const LoadPathSettings path{.n_increments = 10,
                              .max_geometry_updates = 12,
                              .friction_tolerance = 1e-4,
                              .min_increment = 1e-2,
                              .prediction_cap = 0.5};
  StageRun run;
  StageDriver driver;
  driver.motion = [&](const State& s, double a, double b) { return model.motion(s, a, b); };
  driver.accepted = [&](const State& state, const IncrementReport&) {
    run.last_accepted = state;
    ++run.n_accepted;
    return true;
  };
  run.end = model.start;
  StagePosition position;
  run.outcome = run_stage(newton, model.effects, path, driver, timers, position, run.end);
  return run;
}

bool all_finite(const State& state) {
  return std::all_of(state.q.begin(), state.q.end(), [](const Vec3& v) { return v.allFinite(); });
}

/// Given up in the increment after `from`, to which no smaller one could help; the state is the last good one, to the
/// bit.
void expect_caught(const StageRun& run, double from) {
  EXPECT_EQ(run.outcome.status, StageOutcome::Status::gave_up);
  EXPECT_GE(run.outcome.stage_time, from - 0.02);
  EXPECT_LE(run.outcome.stage_time, from + 1e-12);
  EXPECT_GT(run.n_accepted, 4);
  ASSERT_TRUE(all_finite(run.end));
  ASSERT_EQ(run.end.q.size(), run.last_accepted.q.size());
  for (std::size_t v = 0; v < run.end.q.size(); ++v) EXPECT_EQ(run.end.q[v], run.last_accepted.q[v]);
  measured(fmt::format("gave up at stage time {:.4f} of a spoilt {:.4f}: {}", run.outcome.stage_time, from,
                       run.outcome.reason));
}

TEST(Failures, SoundEffectsGoThrough) {
  const StageRun run = run_with(Spoils::force, 2);
  EXPECT_EQ(run.outcome.status, StageOutcome::Status::done);
  EXPECT_EQ(run.n_accepted, 10);
}

TEST(Failures, ForceThatIsNotANumber) {
  const StageRun run = run_with(Spoils::force, 0.55);
  expect_caught(run, 0.55);
  EXPECT_NE(run.outcome.reason.find("not a number"), std::string::npos) << run.outcome.reason;
}

TEST(Failures, ForceThatIsInfinite) {
  const StageRun run = run_with(Spoils::infinite_force, 0.55);
  expect_caught(run, 0.55);
  EXPECT_NE(run.outcome.reason.find("infinite"), std::string::npos) << run.outcome.reason;
}

TEST(Failures, ReactionThatIsNotANumber) {
  // At a held dof, which the residual leaves out.
  expect_caught(run_with(Spoils::held_force, 0.55), 0.55);
}

TEST(Failures, TangentThatIsNotANumber) { expect_caught(run_with(Spoils::tangent, 0.55), 0.55); }

TEST(Failures, EnergyThatIsNotANumber) {
  // Forces and tangent are sound: Newton's method sees nothing.
  const StageRun run = run_with(Spoils::energy, 0.55);
  expect_caught(run, 0.55);
  EXPECT_NE(run.outcome.reason.find("energy of unsound"), std::string::npos) << run.outcome.reason;
}

/// The fiber of a stage, straight along x, with all of it stretched.
State stretched(const StageModel& model, double stretch) {
  State state = model.start;
  for (Index n = model.field.element_node(0, 0); n <= model.field.last_node(0); ++n) {
    const Index r = model.layout.first_vector(n);
    state.q[r].x() *= stretch;
    if (model.field.model(0) == FiberModel::rod) state.q[r + 1].x() *= stretch;
  }
  return state;
}

TEST(Failures, CollapsedFibersAreRefused) {
  for (const FiberModel fiber_model : {FiberModel::enriched, FiberModel::rod}) {
    Scene scene = cantilever(fiber_model, 0, 4, 2);
    scene.stages = {stage_with("crush", 1, {})};
    const Assembly assembly = assemble_scene(scene);
    const StageModel model(scene, assembly, scene.stages[0], start_of(assembly));
    const auto inadmissibility = [&](const State& state) {
      std::string text;
      for (const auto& effect : model.effects) text += effect->inadmissibility(model.start, state);
      return text;
    };
    EXPECT_EQ(inadmissibility(model.start), "");
    EXPECT_EQ(inadmissibility(stretched(model, 1.5)), "");
    EXPECT_EQ(inadmissibility(stretched(model, 0.051)), "");
    EXPECT_NE(inadmissibility(stretched(model, 0.049)).find("fiber 0 of yarn beam at"), std::string::npos);
    EXPECT_NE(inadmissibility(stretched(model, 0.049)).find("stretch is 0.049"), std::string::npos);
    EXPECT_NE(inadmissibility(stretched(model, -1)).find("inside out"), std::string::npos);
  }
}

/// A stub of one element that is pressed by a dead load, a share of E A.
Scene pressed_stub(FiberModel model, double share) {
  Scene scene = cantilever(model, 0, 40, 1);
  scene.solver.step_cap = 0.2;
  scene.solver.min_increment = 1e-3;
  scene.stages = {stage_with("crush", 20, {force("tip", BodyDof::x, -share * std::numbers::pi)})};
  return scene;
}

TEST(Failures, CrushedFiberAnswersByALogarithmAndIsWarnedOf) {
  // Nominal stress over E: λ (λ² − 1)/2 down to λ = 0.8, −0.144 there; then −0.144 + 0.368 ln(λ/0.8).
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod})
    for (const double share : {0.12, 0.25, 0.5}) {
      const RunResult result = run_scene(pressed_stub(model, share));
      const std::vector<Vec3>& r = result.last().fibers.r;  // ties give way a little, too
      const double stretch = (r.back() - r.front()).x() / 40;
      const double expected = share < 0.144 ? 0.846439 : 0.8 * std::exp((0.144 - share) / 0.368);
      measured(fmt::format("{}: stretch {:.5f} under {} E A, closed form {:.5f}",
                           model == FiberModel::rod ? "rod" : "enriched", stretch, share, expected));
      ASSERT_TRUE(result.done()) << result.summary.message;
      EXPECT_NEAR(stretch, expected, 1e-5);
      const auto& warnings = result.summary.warnings;
      EXPECT_EQ(std::any_of(warnings.begin(), warnings.end(),
                            [](const std::string& w) { return w.find("its elastic law is a guess") != w.npos; }),
                share > 0.144);
    }
}

TEST(Failures, CrushedFiberEndsAtItsLimitWithTheLastGoodState) {
  // At a twentieth of its length a fiber bears 0.144 − 0.368 ln(0.05/0.8) = 1.1643 E A. States would be saved every
  // 1000 increments only, so the last one is there because the run gave up.
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    Scene scene = pressed_stub(model, 1.25);
    scene.stages[0].save_every = 1000;
    const RunResult result = run_scene(scene);
    expect_clear_status(result);
    const double carried = -result.last().bodies.force[1].x() / std::numbers::pi;
    measured(fmt::format("{}: gave up at {:.4f} E A (limit 1.1643), {} saved states, stretch {:.3f}",
                         model == FiberModel::rod ? "rod" : "enriched", carried, result.increments.size(),
                         result.tip().x() / 40));
    EXPECT_EQ(result.increments.size(), 2u);
    EXPECT_FALSE(result.done());
    EXPECT_NE(result.summary.message.find("fiber 0 of yarn beam"), std::string::npos) << result.summary.message;
    EXPECT_GT(carried, 1.15);
    EXPECT_LT(carried, 1.1643);
  }
}

/// A cantilever that is bent by a force at its tip and held back to the end.
Scene held_back(const std::vector<Drive>& drives, double share) {
  Scene scene = cantilever(FiberModel::rod, 0, 40, 10);
  Stage bend = stage_with("bend", 2, drives);
  bend.proximal_start = bend.proximal_end = share;
  scene.stages = {bend};
  return scene;
}

TEST(Failures, TheLastStageEndsInEquilibriumWhateverHoldsFibersBack) {
  const std::vector<Drive> drives = {force("tip", BodyDof::z, 1e-5), force("tip", BodyDof::ry, 0)};
  Scene free = held_back(drives, 0);
  const RunResult right = run_scene(free);
  expect_done(right);
  const RunResult held = run_scene(held_back(drives, 1e-4));
  expect_done(held);
  ASSERT_EQ(held.increments.size(), right.increments.size());
  const double on_the_way = held.increments[1].fibers.r.back().z() / right.increments[1].fibers.r.back().z();
  measured(fmt::format("deflection held back over free: on the way {:.3f}, at the end {:.5f}", on_the_way,
                       held.tip().z() / right.tip().z()));
  EXPECT_LT(on_the_way, 0.9);
  EXPECT_NEAR(held.tip().z(), right.tip().z(), 2e-4 * right.tip().z());
  EXPECT_TRUE(right.summary.warnings.empty());
  ASSERT_EQ(held.summary.warnings.size(), 1u);
  EXPECT_NE(held.summary.warnings[0].find("stage bend: a proximal term (proximal_end = 0.0001)"), std::string::npos);
}

TEST(Failures, FibersThatOnlyAProximalTermHoldsAreNoEquilibrium) {
  Scene scene = held_back({force("tip", BodyDof::x, 1e-3), force("wall", BodyDof::x, 0)}, 1e-6);
  const RunResult result = run_scene(scene);
  expect_clear_status(result);
  EXPECT_FALSE(result.done());
  EXPECT_NE(result.summary.message.find("does not come to rest"), std::string::npos) << result.summary.message;
  EXPECT_EQ(result.summary.message.find("smallest allowed increment"), std::string::npos) << result.summary.message;
}

}  // namespace
}  // namespace trame::micro
