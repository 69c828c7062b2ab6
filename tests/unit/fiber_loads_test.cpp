/// Loads on fibers: reading and refusals, what they cost, runs that go on.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "micro/cost_estimate.h"
#include "micro/model/model.h"
#include "tests/support/messages.h"
#include "tests/support/run_scene.h"
#include "tests/support/tied_rod.h"

namespace trame::micro {
namespace {

using trame::test::expect_mentions;
using trame::test::input_error;

std::string stage_text(const std::string& name, const std::string& loads) {
  return fmt::format("[[stage]]\nname = \"{}\"\nincrements = 4\n{}", name, loads);
}
std::string load_text(const std::string& keys) { return "[[stage.load]]\n" + keys + "\n"; }

/// A rod of 1 mm that is held at both ends, E = 1 GPa, R = 10 µm.
Scene scene_of(const std::string& stages, bool has_density = true) {
  std::string toml = trame::test::tied_rod(4);
  if (has_density) toml.replace(toml.find("[fiber_type"), 0, "density = \"1 g/cm3\"\n");
  return parse_scene(toml + stages, "s.toml");
}
Scene scene_with(const std::string& load) { return scene_of(stage_text("s", load_text(load))); }

TEST(FiberLoads, AreReadFromTheScene) {
  const Scene scene =
      scene_of(stage_text("s", load_text("force_per_length = [\"0 N/m\", \"2 mN/m\", \"-1 uN/mm\"]\nfibers = \"fib*\"\n"
                                         "name = \"drag\"\namplitude = [[0.5, 1], [1, 0]]") +
                                   load_text("gravity = [\"0 m/s2\", \"0 m/s2\", \"-9.81 m/s2\"]")));
  const std::vector<FiberLoad>& loads = scene.stages[0].loads;
  ASSERT_EQ(loads.size(), 2U);
  EXPECT_EQ(loads[0].name, "drag");
  EXPECT_EQ(loads[0].fibers, std::vector<std::string>{"fib*"});
  EXPECT_EQ(loads[0].kind, LoadKind::force_per_length);
  EXPECT_LT((loads[0].value - Vec3(0, 2e-3, -1e-3)).norm(), 1e-15);
  EXPECT_EQ(loads[0].amplitude, (Amplitude{{{0.5, 1}, {1, 0}}}));
  EXPECT_EQ(loads[1].name, "gravity");
  EXPECT_EQ(loads[1].fibers, std::vector<std::string>{"*"});
  EXPECT_EQ(loads[1].kind, LoadKind::gravity);
  EXPECT_LT((loads[1].value - Vec3(0, 0, -9.81)).norm(), 1e-12);
}

TEST(FiberLoads, ThatAreNoneAreRefusedWithTheirPlace) {
  const auto error = [](const std::string& load) { return input_error([&] { (void)scene_with(load); }); };
  const std::string down = "force_per_length = [\"0 N/m\", \"0 N/m\", \"-1 N/m\"]\n",
                    weight = "gravity = [\"0 m/s2\", \"0 m/s2\", \"-9.81 m/s2\"]\n";
  const std::string both = "must have either \"force_per_length\" or \"gravity\"";
  expect_mentions(error(down + weight), {"s.toml: stage[1].load[1]", both, "line"});
  expect_mentions(error("fibers = \"fiber\""), {"stage[1].load[1]", both});
  expect_mentions(error(down + "fibers = \"fibre\""),
                  {"stage[1].load[1].fibers = \"fibre\"", "the name of a fiber, bundle or yarn", "\"fiber\""});
  expect_mentions(error(down + "fibers = [\"fiber\", \"warp/*\"]"), {"fibers[2] = \"warp/*\"", "must fit the name"});
  expect_mentions(error("force_per_length = \"1 N/m\""), {"force_per_length", "a list of 3", "a force per length"});
  expect_mentions(error("force_per_length = [0, 0, 1]"), {"force_per_length[1] = 0", "a force per length"});
  expect_mentions(error("force_per_length = [\"0 N/m\", \"0 N\", \"0 N/m\"]"), {"force_per_length[2] = \"0 N\""});
  expect_mentions(error("gravity = [\"0 m/s2\", \"0 m/s2\", \"9.81\"]"), {"gravity[3] = \"9.81\"", "an acceleration"});
  for (const char* number : {"nan", "inf", "-inf", "1e400"})
    expect_mentions(error(fmt::format("force_per_length = [\"0 N/m\", \"0 N/m\", \"{} N/m\"]", number)),
                    {"force_per_length[3]", number});
  expect_mentions(error("gravity = [\"0 m/s2\", \"0 m/s2\", \"1e16 m/s2\"]"), {"gravity[3]", "must be at most 1e+15"});
  expect_mentions(error("force_per_length = [\"0 N/m\", \"1e13 N/m\", \"0 N/m\"]"),
                  {"force_per_length", "must be at most 1e+10 N/m"});
  expect_mentions(error(down + "amplitude = [[0.5, 1]]"), {"amplitude", "must end at stage time 1"});
  expect_mentions(error(down + "amplitude = [[0.1, 1], [1, 0]]"), {"amplitude", "at least an increment, 0.25"});
  expect_mentions(error(down + "force = 1"), {"stage[1].load[1].force", "unknown key"});
  expect_mentions(error(down + load_text(down)), {"stage[1].load[2]", "name of its own", "\"force_per_length\""});
  expect_mentions(error(down + "name = \"a\"\n" + load_text(weight + "name = \"a\"")), {"load[2].name = \"a\""});
  expect_mentions(input_error([&] { (void)scene_of(stage_text("s", load_text(weight)), false); }),
                  {"stage[1].load[1].gravity", "needs the density of material.m"});
  EXPECT_NO_THROW((void)scene_of(stage_text("s", load_text(down)), false));
}

TEST(FiberLoads, AreRefusedInACell) {
  const std::string cell = R"([material.m]
model = "isotropic"
young_modulus = "1 GPa"
poisson_ratio = 0.3
[fiber_type.f]
material = "m"
diameter = "20 um"
[weave]
pattern = "plain"
periodic = true
[weave.warp]
fiber_type = "f"
yarns = 2
fibers = 1
elements = 8
yarn_spacing = "100 um"
[weave.weft]
fiber_type = "f"
yarns = 2
fibers = 1
elements = 8
yarn_spacing = "100 um"
)";
  expect_mentions(input_error([&] {
                    (void)parse_scene(cell + stage_text("s", load_text("force_per_length = [\"0 N/m\", \"0 N/m\", "
                                                                       "\"1 N/m\"]")),
                                      "cell.toml");
                  }),
                  {"cell.toml: stage[1].load[1]", "weave is periodic"});
}

const std::string drag = "force_per_length = [\"0 N/m\", \"0 N/m\", \"10 mN/m\"]\nname = \"drag\"\n",
                  weight = "gravity = [\"0 m/s2\", \"2e5 m/s2\", \"0 m/s2\"]\n",
                  no_drag = "force_per_length = [\"0 N/m\", \"0 N/m\", \"0 N/m\"]\nname = \"drag\"\n";

TEST(FiberLoads, AreThereOnlyWhereASceneAsksForThem) {
  const Scene scene = scene_of(stage_text("before", "") + stage_text("loaded", load_text(weight)) +
                               stage_text("after", "") + stage_text("zero", load_text(no_drag)));
  const Scene natural = nondimensional(scene, natural_scales(scene));
  const Assembly assembly = assemble_scene(natural);
  StageStart start = start_of(assembly);
  const std::vector<bool> expected = {false, true, true, true};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const StageModel model(natural, assembly, natural.stages[i], start);
    EXPECT_EQ(model.fiber_loads != nullptr, expected[i]) << i;
    start.loads = model.standing_loads;
  }
  const auto price = [](const Scene& of) {
    const CostEstimate cost = estimate_cost(of);
    return std::any_of(cost.effects.begin(), cost.effects.end(),
                       [](const EffectCost& e) { return e.effect == PricedEffect::fiber_loads && e.seconds > 0; });
  };
  EXPECT_TRUE(price(scene));
  EXPECT_FALSE(price(scene_of(stage_text("before", ""))));
}

using Status = SimulationSummary::Status;

/// Runs in a folder of their own.
class FiberLoadRuns : public testing::Test {
 protected:
  [[nodiscard]] SimulationSummary run(const Scene& scene, const std::string& name, Index last = 0,
                                      bool resume = false) const {
    std::atomic<bool> stop = false;
    SimulateOptions options;
    options.states = folder_ / name;
    options.n_threads = 1;
    options.resume = resume;
    options.stop = &stop;
    options.on_increment = [&](const Progress& progress) { stop = progress.increment == last; };
    return simulate(scene, options);
  }
  [[nodiscard]] SimulationSummary run_after(const Scene& scene, const std::string& name, const std::string& from,
                                            const std::string& after) const {
    SimulateOptions options;
    options.states = folder_ / name;
    options.start_from = folder_ / from;
    options.after = after;
    options.n_threads = 1;
    return simulate(scene, options);
  }
  [[nodiscard]] Increment last_of(const std::string& name) const {
    const SnapshotReader states(folder_ / name);
    return states.read(states.n_increments() - 1);
  }
  trame::test::TemporaryFolder folder_;
};

// Force on the fiber: 0.01 N/m and 1 g/cm³ π (10 µm)² 2·10⁵ m/s² = 0.0628 N/m, times 1 mm.
TEST_F(FiberLoadRuns, BeginWithTheLoadsThatAreOn) {
  const std::string first = stage_text("first", load_text(drag) + load_text(weight)),
                    then = stage_text("wait", "") + stage_text("off", load_text(no_drag));
  const Scene whole = scene_of(first + then), stub = scene_of(stage_text("first", "") + then);
  ASSERT_EQ(run(scene_of(first), "first.h5").status, Status::done);
  ASSERT_EQ(run(whole, "whole.h5").status, Status::done);
  ASSERT_EQ(run_after(whole, "rest.h5", "first.h5", "first").status, Status::done);
  ASSERT_EQ(run_after(stub, "stub.h5", "first.h5", "first").status, Status::done);
  const Increment expected = last_of("whole.h5");
  const Vec3 pull = expected.bodies.force[0] + expected.bodies.force[1];
  EXPECT_NEAR(pull.y(), -6.2832e-5, 1e-8);
  EXPECT_NEAR(pull.z(), 0, 1e-10);
  for (const char* name : {"rest.h5", "stub.h5"}) {
    const Increment last = last_of(name);
    for (std::size_t n = 0; n < last.fibers.r.size(); ++n)
      EXPECT_LT((last.fibers.r[n] - expected.fibers.r[n]).norm(), 1e-12) << name;
    for (const std::size_t source : {std::size_t{0}, static_cast<std::size_t>(Source::fiber_loads)})
      EXPECT_NEAR(last.solver.energy.work[source], expected.solver.energy.work[source],
                  1e-6 * expected.solver.energy.external_work)
          << name;
    EXPECT_NEAR(last.solver.energy.release, expected.solver.energy.release, 1e-6 * expected.solver.energy.external_work)
        << "nothing jumps";
  }
  // What a scene says of stages that it does not run must be so.
  const Scene other = scene_of(stage_text("first", load_text(drag)) + then);
  expect_mentions(
      input_error([&] { (void)run_after(other, "no.h5", "first.h5", "first"); }),
      {"--start-from", "loads on fibers at the end of stage first",
       "in the states drag of up to 0.01 N/m, gravity of up to 0.0628319 N/m, in the scene drag of up to 0.01 N/m;"});
}

TEST_F(FiberLoadRuns, GoOnToTheBit) {
  const Scene scene = scene_of(stage_text("first", load_text(drag + "amplitude = [[0.6, 1], [1, 0.5]]")) +
                               stage_text("then", load_text(weight)));
  const SimulationSummary whole = run(scene, "whole.h5");
  ASSERT_EQ(whole.status, Status::done);
  ASSERT_GE(whole.n_increments, 8);
  const Increment expected = last_of("whole.h5");
  for (Index last = 1; last < whole.n_increments; ++last) {
    const std::string name = fmt::format("{}.h5", last);
    ASSERT_EQ(run(scene, name, last).status, Status::interrupted);
    ASSERT_EQ(run(scene, name, 0, true).status, Status::done);
    const Increment end = last_of(name);
    EXPECT_EQ(end.fibers.r, expected.fibers.r) << last;
    EXPECT_EQ(end.bodies.force, expected.bodies.force) << last;
    EXPECT_EQ(end.solver.energy.work, expected.solver.energy.work) << last;
  }
  // Other loads are another scene.
  const Scene other = scene_of(stage_text("first", load_text(drag)) + stage_text("then", load_text(weight)));
  expect_mentions(input_error([&] { (void)run(other, "1.h5", 0, true); }), {"--resume", "stage first differs"});
}

}  // namespace
}  // namespace trame::micro
