/// \file
/// Rigid motions: of a state at rest they cost nothing, of a loaded scene they move the result.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numeric>

#include "micro/fiber/enriched_beam.h"
#include "micro/fiber/rod.h"
#include "tests/support/finite_differences.h"
#include "tests/support/run_scene.h"

namespace trame::micro {
namespace {

const Mat3 turn = rotation_matrix(Vec3(1.1, -2.0, 0.7));
const Vec3 shift(3, -40, 17);

struct Model {
  FiberModel fiber;
  Assembly assembly;
  Layout layout;
  RigidBodies bodies;
  FiberField field;
  State state;

  /// A fiber through `points` with a body at either end.
  Model(FiberModel model, const std::vector<Vec3>& points)
      : fiber(model), assembly(make_assembly(model, points)), bodies(2, layout), field(assembly.mesh, {model}, layout) {
    state.q.assign(layout.n_vectors(), Vec3::Zero());
    state.rotations.assign(2, Mat3::Identity());
    field.read_configuration(assembly.configuration, state);
    for (Index b = 0; b < 2; ++b) bodies.set_pose(state, b, {assembly.body_positions[b], Mat3::Identity()});
  }
  static Assembly make_assembly(FiberModel model, const std::vector<Vec3>& points) {
    Scene scene = test::cantilever(model, 0.3, 1, 5);
    scene.fibers[0].points = points;
    scene.bodies[1].position = points.back();
    return assemble_scene(scene);
  }

  /// r → Q r + c; section vectors, tangents and bodies turn.
  [[nodiscard]] State moved() const {
    State s = state;
    for (Vec3& v : s.q) v = turn * v;
    for (Mat3& r : s.rotations) r = turn * r;
    for (Index n = 0; n < layout.n_nodes(); ++n) s.q[layout.first_vector(n)] += shift;
    return s;
  }
};

/// Energies and forces are in units of EA R and EA = π; coordinates of about 50 leave 1e-14 of round-off in the
/// strains.
void expect_at_rest(const Effect& effect, const Layout& layout, const State& state) {
  EXPECT_LT(effect.energy(state), 1e-20) << effect.name();
  EXPECT_LT(test::assemble(effect, layout, state).force.norm(), 1e-10) << effect.name();
}

const std::vector<Vec3> curved = {{0, 0, 0}, {10, 3, 1}, {20, 1, -2}, {30, 0, 5}};
const std::vector<Vec3> straight = {{1, 2, 3}, {21, -8, 13}};

TEST(RigidMotion, OfCurvedEnrichedBeams) {
  for (const bool twist_stretch : {false, true}) {
    Model model(FiberModel::enriched, curved);
    const EnrichedBeams beams(model.field, {test::isotropic(1, 0.39)}, model.assembly.configuration, twist_stretch);
    expect_at_rest(beams, model.layout, model.moved());
    // What costs nothing for every motion would pass as well.
    State stretched = model.moved();
    for (Vec3& v : stretched.q) v *= 1.01;
    EXPECT_GT(beams.energy(stretched), 1e-3);
  }
}

TEST(RigidMotion, OfRods) {
  Model model(FiberModel::rod, straight);
  const Rods rods(model.field, {test::isotropic(1, 0.39)});
  expect_at_rest(rods, model.layout, model.moved());
  State stretched = model.moved();
  for (Vec3& v : stretched.q) v *= 1.01;
  EXPECT_GT(rods.energy(stretched), 1e-3);
}

TEST(RigidMotion, OfTies) {
  for (const FiberModel fiber : {FiberModel::enriched, FiberModel::rod}) {
    Model model(fiber, curved);
    const Index node = model.field.last_node(0), mesh_node = model.assembly.mesh.n_nodes() - 1;
    const FiberConfiguration& reference = model.assembly.configuration;
    const Vec3 direction = fiber == FiberModel::enriched ? reference.g1[mesh_node] : reference.tangent[mesh_node];
    const Vec3 axis = Vec3(1, 1, 0).normalized();
    const auto holds = fiber == FiberModel::enriched ? TieTerm::Holds::vector : TieTerm::Holds::direction;
    Ties ties(model.layout, model.bodies,
              {{1, {{node, 0}}, TieTerm::Holds::point, Vec3::Zero(), Mat3::Identity(), 1000},
               {1, {{node, 1}}, holds, direction, Mat3::Identity(), 1000},
               {0,
                {{node, 0}},
                TieTerm::Holds::point,
                reference.r[mesh_node],
                Mat3::Identity() - axis * axis.transpose(),
                1000}});
    const State moved = model.moved();
    ties.begin_step(moved, 1);
    expect_at_rest(ties, model.layout, moved);
    EXPECT_LT(ties.pull(moved, 1).first.norm(), 1e-10);
    State apart = moved;
    apart.q[model.layout.first_vector(model.bodies.node(1))].z() += 0.1;
    EXPECT_GT(ties.energy(apart), 1);
  }
}

/// A curved fiber bent onto a clamped one that it crosses, friction included; all turned and shifted.
Scene crossing_scene(const Mat3& q, const Vec3& c) {
  Scene scene;
  scene.name = "crossing";
  scene.materials = {test::isotropic(1, 0.3)};
  scene.fiber_types = {{"f", 0, 1.0, FiberModel::enriched}};
  scene.fibers = {{"under", 0, {{8, -8, 0}, {8, 8, 0}}, 4, Vec3(q * Vec3::UnitZ())},
                  {"over", 0, {{0, 0, 2.2}, {8, 0.5, 2.3}, {16, 0, 2.2}}, 6, Vec3(q * Vec3::UnitZ())}};
  scene.bodies = {{"table", {8, 0, 0}, {{"under", FiberEnd::start, {}}, {"under", FiberEnd::end, {}}}},
                  {"wall", {0, 0, 2.2}, {{"over", FiberEnd::start, {}}}},
                  {"tip", {16, 0, 2.2}, {{"over", FiberEnd::end, {}}}}};
  for (FiberSpec& fiber : scene.fibers)
    for (Vec3& p : fiber.points) p = q * p + c;
  for (BodySpec& body : scene.bodies) body.position = q * body.position + c;
  Stage press;
  press.name = "press";
  press.n_increments = 6;
  press.drives = test::free_body("tip", q * Vec3(0.002, 0.001, -0.01));
  scene.stages = {press};
  scene.solver.force_tolerance = scene.solver.geometry_tolerance = 1e-8;
  scene.solver.max_geometry_updates = 25;
  return scene;
}

double total(const std::vector<double>& forces) { return std::accumulate(forces.begin(), forces.end(), 0.0); }

TEST(RigidMotion, OfALoadedSceneMovesTheResult) {
  const auto home = test::run_scene(crossing_scene(Mat3::Identity(), Vec3::Zero()));
  const auto away = test::run_scene(crossing_scene(turn, shift));
  ASSERT_TRUE(home.done()) << home.summary.message;
  ASSERT_TRUE(away.done()) << away.summary.message;
  const double pressed_home = total(home.last().contacts.normal_force),
               pressed_away = total(away.last().contacts.normal_force);
  ASSERT_GT(pressed_home, 1e-3) << "the fibers must touch for the test to mean something";
  // Both runs stop at residuals of 1e-8 of forces that axial stiffness dominates; bending is (L/R)² = 256 times softer.
  EXPECT_NEAR(pressed_away / pressed_home, 1, 1e-4);
  for (std::size_t i = 0; i < home.last().fibers.r.size(); ++i) {
    EXPECT_LT((away.last().fibers.r[i] - (turn * home.last().fibers.r[i] + shift)).norm(), 1e-4) << "node " << i;
    EXPECT_LT((away.last().fibers.g1[i] - turn * home.last().fibers.g1[i]).norm(), 1e-4) << "node " << i;
  }
}

}  // namespace
}  // namespace trame::micro
