/// \file
/// The same scene in other units, turned, mirrored and renumbered gives the same dimensionless result.

#include <numbers>

#include "micro/solve/system.h"
#include "tests/support/hard_case.h"

namespace trame::micro {
namespace {

using namespace test;

/// A straight fiber of the scene below; all fibers are described so that a change of the scene is a change of these
/// numbers.
struct Rigged {
  std::string name;
  Vec3 from, to, axis;
  std::string start_body, end_body;
};

/// How a scene is changed without changing what happens.
struct Change {
  double length = 1, stress = 1;
  Mat3 turn = Mat3::Identity();  ///< orthogonal; a mirror where its determinant is −1
  Vec3 shift = Vec3::Zero();
  bool reversed_order = false;  ///< fibers and bodies the other way round
};

/// Three fibers, two of them side by side and one across them at 50°: pressed down, then dragged along with friction
/// and turned.
Scene rigged_scene(const Change& c) {
  const Vec3 across(std::cos(0.87), std::sin(0.87), 0);
  std::vector<Rigged> fibers = {
      {"left", {-15, 0, 0}, {15, 0, 0}, {0, 0.2, 1}, "table", "table"},
      {"right", {-15, 2.02, 0.05}, {15, 2.02, 0.05}, {0, 0.3, 1}, "table", "table"},
      {"over", Vec3(0, 1, 2.03) - 12 * across, Vec3(0, 1, 2.03) + 12 * across, {0, 0, 1}, "grip", "grip"}};
  const auto point = [&](const Vec3& p) -> Vec3 { return c.length * (c.turn * p + c.shift); };
  Scene scene;
  scene.name = "rigged";
  scene.materials = {isotropic(c.stress, 0.3)};
  scene.fiber_types = {{"f", 0, c.length, FiberModel::enriched}};
  std::vector<BodySpec> bodies = {{"table", point({0, 1, 0}), {}}, {"grip", point({0, 1, 2.03}), {}}};
  if (c.reversed_order) {
    std::reverse(fibers.begin(), fibers.end());
    std::reverse(bodies.begin(), bodies.end());
  }
  for (const Rigged& f : fibers) {
    scene.fibers.push_back({f.name, 0, {point(f.from), point(f.to)}, 8, Vec3(c.turn * f.axis)});
    for (BodySpec& b : bodies) {
      if (b.name == f.start_body) b.ties.push_back({f.name, FiberEnd::start, TieKind::clamped});
      if (b.name == f.end_body) b.ties.push_back({f.name, FiberEnd::end, TieKind::clamped});
    }
  }
  scene.bodies = bodies;
  const auto move = [&](const Vec3& by, const Vec3& rotation) {
    const Vec3 v = c.length * (c.turn * by);
    const Vec3 w = c.turn.determinant() * (c.turn * rotation);  // a rotation is an axial vector
    std::vector<Drive> drives;
    for (int d = 0; d < 3; ++d) {
      drives.push_back(displacement("grip", static_cast<BodyDof>(d), v[d]));
      drives.push_back(displacement("grip", static_cast<BodyDof>(3 + d), w[d]));
    }
    return drives;
  };
  scene.stages = {stage_with("press", 3, move({0, 0, -0.3}, Vec3::Zero())),
                  stage_with("drag", 4, move({0.8, 0.3, 0}, {0, 0, 0.05}))};
  scene.contact.friction_coefficient = 0.3;
  // Tight, so that what is left of the residual does not hide a difference.
  scene.solver.force_tolerance = scene.solver.geometry_tolerance = 1e-9;
  scene.solver.max_geometry_updates = 40;
  return scene;
}

/// Largest difference of the final states in radii, and of the final reactions in E R², once the change is undone.
struct Difference {
  double position = 0, force = 0, energy = 0;
};

Difference difference(const RunResult& plain, const RunResult& changed, const Change& c) {
  Difference d;
  const Index n = plain.header.mesh.n_fibers();
  for (Index f = 0; f < n; ++f) {
    const Index g = c.reversed_order ? n - 1 - f : f;
    const Index a = plain.header.mesh.first_node[f], b = changed.header.mesh.first_node[g];
    for (Index i = 0; i < plain.header.mesh.n_nodes(f); ++i) {
      const Vec3 back = c.turn.transpose() * (changed.last().fibers.r[b + i] / c.length - c.shift);
      d.position = std::max(d.position, (back - plain.last().fibers.r[a + i]).norm());
    }
  }
  for (Index body = 0; body < 2; ++body) {
    const Vec3 back = c.turn.transpose() * changed.last().bodies.force[c.reversed_order ? 1 - body : body];
    d.force = std::max(d.force, (back / (c.stress * c.length * c.length) - plain.last().bodies.force[body]).norm());
  }
  const double unit = c.stress * c.length * c.length * c.length;
  d.energy = std::abs(changed.summary.energy.friction / unit - plain.summary.energy.friction);
  return d;
}

const RunResult& plain() {
  static const RunResult result = run_scene(rigged_scene({}));
  return result;
}

void expect_same(const Change& change, const std::string& what, double tolerance = 1e-9) {
  expect_done(plain());
  ASSERT_GT(normal_resultant(plain().last()).norm(), 1e-4) << "nothing touches";
  ASSERT_GT(plain().summary.energy.friction, 0) << "nothing slides";
  const RunResult changed = run_scene(rigged_scene(change));
  expect_done(changed);
  const Difference d = difference(plain(), changed, change);
  measured(fmt::format("{}: positions {:.1e} R, forces {:.1e} E R^2, friction {:.1e} E R^3", what, d.position, d.force,
                       d.energy));
  EXPECT_LT(d.position, tolerance);
  EXPECT_LT(d.force, 1e-9);
  EXPECT_LT(d.energy, 1e-9);
}

TEST(SameInOtherWords, Nanometres) { expect_same({1e-9, 1}, "R = 1 nm"); }
TEST(SameInOtherWords, Kilometres) { expect_same({1e3, 1}, "R = 1 km"); }
TEST(SameInOtherWords, StiffnessOfABillion) { expect_same({1, 1e9}, "E = 1 GPa"); }
TEST(SameInOtherWords, StiffnessOfABillionthInNanometres) { expect_same({1e-9, 1e-9}, "R = 1 nm, E = 1 nPa"); }

TEST(SameInOtherWords, Turned) {
  Change c;
  c.turn = rotation_matrix(Vec3(0.7, -1.9, 0.4));
  expect_same(c, "turned");
}

TEST(SameInOtherWords, Shifted) {
  Change c;
  c.shift = Vec3(123, -77, 31);
  // Coordinates of 150 R leave round-off of 10⁻¹⁰ E R² in the ties (10³ E A/h · 150 R · 10⁻¹⁶, over all of them), below
  // which no residual is looked at; divided by the stiffness of the fibers in bending, 192 EI/L³ = 0.01 E R, that is
  // 10⁻⁸ R.
  expect_same(c, "shifted by 150 R", 1e-7);
}

TEST(SameInOtherWords, Mirrored) {
  Change c;
  c.turn = rotation_matrix(Vec3(0.2, 0.5, -1.1)) * Vec3(-1, 1, 1).asDiagonal();
  expect_same(c, "mirrored and turned");
}

TEST(SameInOtherWords, Renumbered) {
  Change c;
  c.reversed_order = true;
  expect_same(c, "fibers and bodies in reverse order");
}

}  // namespace
}  // namespace trame::micro
