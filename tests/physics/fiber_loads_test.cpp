/// \file
/// Loads per length on fibers against closed forms and an elastica that is integrated here.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "tests/support/run_scene.h"

namespace trame::micro {
namespace {

using std::numbers::pi;

constexpr double axial = pi, bending = pi / 4;  // E A and E I for E = 1, R = 1
constexpr std::array both_models = {FiberModel::enriched, FiberModel::rod};

const char* name_of(FiberModel model) { return model == FiberModel::rod ? "rod" : "enriched"; }

FiberLoad force_per_length(const Vec3& value) { return {"load", {"*"}, LoadKind::force_per_length, value, {}}; }

Stage stage_with(std::vector<FiberLoad> loads, Index n_increments) {
  Stage stage;
  stage.name = "load";
  stage.n_increments = n_increments;
  stage.loads = std::move(loads);
  return stage;
}

/// A fiber along x, clamped at its start, with a free end.
Scene clamped_fiber(FiberModel model, double length, Index n_elements, const Stage& stage) {
  Scene scene = test::cantilever(model, 0.3, length, n_elements);
  scene.bodies.pop_back();
  scene.stages = {stage};
  return scene;
}

/// x where f, which ascends, is 0.
double root(double low, double high, const std::function<double(double)>& f) {
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (f(middle) > 0 ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

double work_of_loads(const test::RunResult& result) {
  return result.last().solver.energy.work[static_cast<std::size_t>(Source::fiber_loads)];
}

// w = q L⁴/(8 E I), half of q ∫ w ds is stored. Shear adds 4 E I/(κ G A L²) = 3e-4 of it.
TEST(FiberLoads, CantileverBendsLittle) {
  const double length = 100, deflection = 0.5, q = 8 * bending * deflection / std::pow(length, 4);
  for (const FiberModel model : both_models) {
    const auto result =
        test::run_scene(clamped_fiber(model, length, 20, stage_with({force_per_length({0, 0, -q})}, 1)));
    ASSERT_TRUE(result.done()) << result.summary.message;
    fmt::print("{}: deflection / closed form {:.6f}\n", name_of(model), -result.tip().z() / deflection);
    EXPECT_NEAR(result.tip().z() / -deflection, 1, 1e-3) << name_of(model);
    const BodyRecord& wall = result.last().bodies;
    EXPECT_NEAR(wall.force[0].z() / (q * length), 1, 1e-5);
    EXPECT_NEAR(wall.moment[0].y() / (-q * length * length / 2), 1, 1e-3);
    const double work = q * q * std::pow(length, 5) / (40 * bending);
    EXPECT_NEAR(work_of_loads(result) / work, 1, 2e-3);
    EXPECT_NEAR(result.last().solver.energy.imbalance / work, 0, 1e-3);
    EXPECT_LT(result.summary.moment_imbalance, 1e-5);
  }
}

/// End of an inextensible cantilever of unit length and E I under a dead load q across its start: θ'' = −q (1 − s) cos
/// θ with θ(0) = 0, θ'(1) = 0; θ' at the clamp by bisection, Runge–Kutta of fourth order in between.
Vec2 bent_end(double q) {
  constexpr int n = 2000;
  using Y = Eigen::Vector4d;  // θ, θ', x, z
  const auto integrate = [&](double slope) {
    const auto rate = [&](double s, const Y& y) {
      return Y(y[1], -q * (1 - s) * std::cos(y[0]), std::cos(y[0]), std::sin(y[0]));
    };
    Y y(0, slope, 0, 0);
    const double h = 1.0 / n;
    for (int i = 0; i < n; ++i) {
      const double s = i * h;
      const Y a = rate(s, y), b = rate(s + h / 2, y + h / 2 * a), c = rate(s + h / 2, y + h / 2 * b),
              d = rate(s + h, y + h * c);
      y += h / 6 * (a + 2 * b + 2 * c + d);
    }
    return y;
  };
  const Y end = integrate(root(0, q / 2, [&](double slope) { return integrate(slope)[1]; }));
  return {end[2], end[3]};
}

TEST(FiberLoads, CantileverBendsFar) {
  const double length = 100;
  for (const double load : {2.0, 10.0, 40.0}) {
    const Vec2 expected = length * bent_end(load);
    const double q = load * bending / std::pow(length, 3);
    for (const FiberModel model : both_models) {
      const auto result =
          test::run_scene(clamped_fiber(model, length, 40, stage_with({force_per_length({0, 0, q})}, 10)));
      ASSERT_TRUE(result.done()) << result.summary.message;
      const EnergyRecord& energy = result.last().solver.energy;
      fmt::print("{}, q L^3/EI = {}: off by {:.2e} L; imbalance {:.2e} of the work\n", name_of(model), load,
                 (Vec2(result.tip().x(), result.tip().z()) - expected).norm() / length,
                 energy.imbalance / energy.external_work);
      EXPECT_NEAR(result.tip().x() / length, expected[0] / length, 1e-3) << name_of(model) << ", " << load;
      EXPECT_NEAR(result.tip().z() / length, expected[1] / length, 1e-3) << name_of(model) << ", " << load;
      EXPECT_NEAR(energy.imbalance / energy.external_work, 0, 0.02) << name_of(model) << ", " << load;
      EXPECT_LT(result.summary.moment_imbalance, 1e-4);
    }
  }
}

// The work of a load is trapezoidal: what it is off by falls with the square of the increments.
TEST(FiberLoads, BooksBalanceToSecondOrder) {
  const double length = 100, q = 10 * bending / std::pow(length, 3);
  const auto imbalance = [&](Index n_increments) {
    const auto result = test::run_scene(
        clamped_fiber(FiberModel::rod, length, 10, stage_with({force_per_length({0, 0, q})}, n_increments)));
    EXPECT_TRUE(result.done()) << result.summary.message;
    const EnergyRecord& energy = result.last().solver.energy;
    EXPECT_NEAR(work_of_loads(result) / energy.external_work, 1, 1e-9) << "the wall does not move";
    return energy.imbalance / energy.external_work;
  };
  EXPECT_NEAR(imbalance(8) / imbalance(16), 4, 0.5);
}

// ρ g L²/(2 E), and all of the weight at the upper end. In SI units, of two fibers of different sections and materials.
TEST(FiberLoads, HangingFibersBearTheirWeight) {
  const double length = 4e-3, g = 1e5, density = 1140, radius[] = {1e-4, 5e-5}, modulus[] = {1e9, 3e9};
  for (const FiberModel model : both_models) {
    Scene scene;
    scene.name = "hanging";
    for (int i : {0, 1}) {
      scene.materials.push_back(test::isotropic(modulus[i], 0.3));
      scene.materials.back().density = density * (1 + i);
      scene.fiber_types.push_back({fmt::format("f{}", i), i, radius[i], model});
      const double y = 1e-3 * i;
      scene.fibers.push_back({fmt::format("fiber {}", i), i, {{0, y, 0}, {0, y, -length}}, 8, {}});
      scene.bodies.push_back({fmt::format("hook {}", i), {0, y, 0}, {{scene.fibers[i].name, FiberEnd::start, {}}}});
    }
    scene.contact.scope = ContactScope::none;
    scene.solver.force_tolerance = scene.solver.geometry_tolerance = 1e-7;
    scene.stages = {stage_with({{"gravity", {"fiber ?"}, LoadKind::gravity, {0, 0, -g}, {}}}, 1)};
    const auto result = test::run_scene(scene);
    ASSERT_TRUE(result.done()) << result.summary.message;
    for (int i : {0, 1}) {
      const double rho = density * (1 + i), weight = rho * pi * radius[i] * radius[i] * length * g,
                   elongation = rho * g * length * length / (2 * modulus[i]);
      fmt::print("{} {}: elongation / closed form {:.6f}\n", name_of(model), i,
                 (-result.tip(i).z() - length) / elongation);
      EXPECT_NEAR((-result.tip(i).z() - length) / elongation, 1, 1e-3) << name_of(model) << i;
      EXPECT_NEAR(result.last().bodies.force[i].z() / weight, 1, 1e-6) << name_of(model) << i;
    }
  }
}

// An elastic catenary (Irvine): of the unstressed length S and the pull H,
//   span = H S/EA + 2 (H/w) asinh(w S/2H),   sag = w S²/(8 EA) + (H/w) (√(1 + (w S/2H)²) − 1)
TEST(FiberLoads, SlenderCableHangsAsACatenary) {
  const double length = 4000, w = 1e-6, span = 0.9 * length;
  Scene scene = test::cantilever(FiberModel::rod, 0.3, length, 40);
  Stage sag = stage_with({force_per_length({0, 0, -w})}, 10), close = stage_with({}, 20);
  close.name = "close";
  for (Stage* stage : {&sag, &close})
    for (const char* body : {"wall", "tip"}) stage->drives.push_back({body, BodyDof::ry, DriveMode::force, 0, ""});
  close.drives.push_back({"tip", BodyDof::x, DriveMode::displacement, span - length, ""});
  scene.stages = {sag, close};
  const auto result = test::run_scene(scene);
  ASSERT_TRUE(result.done()) << result.summary.message;
  const auto span_of = [&](double pull) {
    return pull * length / axial + 2 * pull / w * std::asinh(w * length / (2 * pull));
  };
  const double pull = root(0.01 * w * length, 10 * w * length, [&](double h) { return span_of(h) - span; }),
               deepest = w * length * length / (8 * axial) + pull / w * (std::hypot(1.0, w * length / (2 * pull)) - 1);
  const Vec3 middle = result.last().fibers.r[result.last_node(0) / 2];
  const BodyRecord& ends = result.last().bodies;
  fmt::print("sag / closed form {:.5f}, pull / closed form {:.5f}\n", -middle.z() / deepest, ends.force[1].x() / pull);
  EXPECT_NEAR(-middle.z() / deepest, 1, 2e-3);
  EXPECT_NEAR(ends.force[1].x() / pull, 1, 2e-3);
  for (const Vec3& force : ends.force) EXPECT_NEAR(force.z() / (0.5 * w * length), 1, 1e-3);
  const EnergyRecord& energy = result.last().solver.energy;
  EXPECT_NEAR(energy.imbalance / work_of_loads(result), 0, 0.01);
}

TEST(FiberLoads, PlaneBearsTheWeightOfAFiberThatLiesOnIt) {
  const double length = 100, w = 1e-5;
  for (const FiberModel model : both_models) {
    Scene scene = clamped_fiber(model, length, 10, stage_with({force_per_length({0, 0, -w})}, 2));
    scene.stages[0].drives = {{"wall", BodyDof::z, DriveMode::force, 0, ""},
                              {"wall", BodyDof::ry, DriveMode::force, 0, ""}};
    scene.stages[0].proximal_start = 1e-4;  // nothing else holds it before it is pressed on
    scene.bodies.push_back(
        {"floor", {0, 0, -1}, {}, {{{SurfaceShape::plane, Vec3::Zero(), Vec3::UnitZ()}, 0.0, {}, true}}});
    scene.contact.friction = false;
    scene.solver = {};
    const auto result = test::run_scene(scene);
    ASSERT_TRUE(result.done()) << result.summary.message;
    const BodyRecord& bodies = result.last().bodies;
    EXPECT_NEAR(bodies.force[1].z() / (w * length), 1, 1e-5) << name_of(model);
    EXPECT_NEAR(bodies.force[0].z() / (w * length), 0, 1e-5) << name_of(model);
    for (const Vec3& r : result.last().fibers.r) EXPECT_NEAR(r.z(), 0, 0.02);
    EXPECT_LT(result.last().solver.max_penetration_over_radius, 0.011);
  }
}

// What is on stays on, goes from what it was to what a later stage says, and by a table there and back.
TEST(FiberLoads, StayOnUntilAStageChangesThem) {
  const double length = 100, q = 1e-7;
  for (const FiberModel model : both_models) {
    Scene scene = clamped_fiber(model, length, 10, stage_with({force_per_length({0, 0, q})}, 2));
    const auto add = [&](const char* name, std::vector<FiberLoad> loads) {
      scene.stages.push_back(stage_with(std::move(loads), 2));
      scene.stages.back().name = name;
    };
    FiberLoad side = force_per_length({0, 3 * q, 0});
    side.name = "side";
    side.amplitude = {{{0.5, 1}, {1, 0}}};
    add("wait", {});
    add("twice", {force_per_length({0, 0, 2 * q})});
    add("there and back", {side});
    add("off", {force_per_length(Vec3::Zero())});
    add("nothing", {});
    const auto result = test::run_scene(scene);
    ASSERT_TRUE(result.done()) << result.summary.message;
    const std::vector<Vec3> on = {{0, 0, 0.5}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1},   {0, 0, 1.5}, {0, 0, 2},
                                  {0, 3, 2},   {0, 0, 2}, {0, 0, 1}, {0, 0, 0.0}, {0, 0, 0},   {0, 0, 0}};
    ASSERT_EQ(result.increments.size(), on.size() + 1);
    for (std::size_t i = 0; i < on.size(); ++i)
      EXPECT_LT((result.increments[i + 1].bodies.force[0] / (q * length) + on[i]).norm(), 1e-4) << i;
    EXPECT_NEAR(result.tip().z(), 0, 1e-4);
    EXPECT_NEAR(work_of_loads(result) / result.increments[1].solver.energy.stored, 0, 2e-3)
        << "it comes back, but for trapezoids";
  }
}

}  // namespace
}  // namespace trame::micro
