/// \file
/// Every effect through one harness: its force is the gradient of its energy, its tangent the derivative of its force.

#include <gtest/gtest.h>

#include "micro/contact/contact.h"
#include "micro/contact/surface_contact.h"
#include "micro/fiber/enriched_beam.h"
#include "micro/fiber/fiber_loads.h"
#include "micro/fiber/rod.h"
#include "micro/rigid/rigid_body.h"
#include "micro/solve/proximal.h"
#include "micro/weave/crossing_order.h"
#include "tests/support/finite_differences.h"
#include "tests/support/meshes.h"
#include "tests/support/run_scene.h"

namespace trame::micro {
namespace {

using test::expect_consistent_derivatives;
using test::isotropic;
using test::perturbed;
using test::TwoFibers;

TEST(Derivatives, EnrichedBeam) {
  for (const bool twist_stretch : {false, true}) {
    TwoFibers scene(FiberModel::enriched);
    EnrichedBeams beams(scene.field, {isotropic(1, 0.39), isotropic(1, 0.39)}, scene.configuration, twist_stretch);
    expect_consistent_derivatives(beams, scene.layout, perturbed(scene.layout, scene.state, 0.1, 1));
  }
}

TEST(Derivatives, EnrichedBeamTransverselyIsotropic) {
  TwoFibers scene(FiberModel::enriched);
  const Material carbon{"carbon", 1, 0.065, 0.12, 0.25, 0.4};
  EnrichedBeams beams(scene.field, {carbon, carbon}, scene.configuration, false);
  expect_consistent_derivatives(beams, scene.layout, perturbed(scene.layout, scene.state, 0.1, 2));
}

TEST(Derivatives, LoadsOnFibers) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    TwoFibers scene(model);
    FiberLoads loads(scene.field, {{0, {0.1, 0.2, -0.3}, {0, 0.1, 0.4}, {{{0.5, 2}, {1, 0}}}},
                                   {1, Vec3::Zero(), {-0.1, 0, 0.2}, {}}});
    loads.begin_step(scene.state, 0.7);
    expect_consistent_derivatives(loads, scene.layout, perturbed(scene.layout, scene.state, 0.1, 5));
    // All of it arrives on positions, whatever else it does.
    const Eigen::VectorXd force = test::assemble(loads, scene.layout, scene.state).force;
    for (const Index f : {0, 1}) {
      Vec3 sum = Vec3::Zero();
      for (Index n = scene.field.element_node(f, 0); n <= scene.field.last_node(f); ++n)
        sum += force.segment<3>(scene.layout.first_dof(n));
      const Vec3 per_length = f == 0 ? Vec3(-0.02, 0.08, 0.54) : Vec3(-0.07, 0, 0.14);
      EXPECT_LT((sum + scene.field.mesh().length(f) * per_length).norm(), 1e-12);
    }
  }
}

TEST(Derivatives, Rod) {
  TwoFibers scene(FiberModel::rod);
  Rods rods(scene.field, {isotropic(1, 0.3), isotropic(1, 0.3)});
  expect_consistent_derivatives(rods, scene.layout, perturbed(scene.layout, scene.state, 0.1, 3));
}

/// Pressed to about 0.6 of their length, where stretch is answered by a logarithm.
TEST(Derivatives, PressedFibers) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    TwoFibers scene(model);
    State pressed = scene.state;
    for (Index f = 0; f < 2; ++f)
      for (Index n = scene.field.element_node(f, 0); n <= scene.field.last_node(f); ++n) {
        pressed.q[scene.layout.first_vector(n)].x() *= 0.6;
        if (model == FiberModel::rod) pressed.q[scene.layout.first_vector(n) + 1].x() *= 0.6;
      }
    const State state = perturbed(scene.layout, pressed, 0.02, 6);
    const std::vector<Material> materials(2, isotropic(1, 0.3));
    EnrichedBeams beams(scene.field, materials, scene.configuration, true);
    Rods rods(scene.field, materials);
    Effect& effect = model == FiberModel::rod ? static_cast<Effect&>(rods) : beams;
    EXPECT_NE(effect.doubt(state).find("is pressed to 0.5"), std::string::npos) << effect.doubt(state);
    EXPECT_EQ(effect.doubt(scene.state), "");
    expect_consistent_derivatives(effect, scene.layout, state);
  }
}

/// Two fibers side by side, in contact with friction.
struct RubbingFibers {
  explicit RubbingFibers(FiberModel model) : scene(model), contact(scene.field, law(), {1, 1}) {
    contact.begin_step(scene.state, 1);
    contact.update(scene.state);
  }
  static ContactLaw law() {
    ContactLaw law;
    law.friction_coefficient = 0.4;
    return law;
  }
  TwoFibers scene;
  Contact contact;
};

// Forces have a potential; how fast sections of beams grow along them, which feet feel that slide, is smoothed from
// element to element. How they turn as feet slide is not: that is all that the tangent of beams leaves out. That of
// rods leaves out that points are held away from where they are lowest.
TEST(Derivatives, ContactAndFriction) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    RubbingFibers rubbing(model);
    auto& [scene, contact] = rubbing;
    ASSERT_GE(contact.elements().size(), 3u);
    // Small steps stick, larger ones slide; both branches of the return mapping and of the penalty are met.
    for (const double amplitude : {0.003, 0.05}) {
      const State state = perturbed(scene.layout, scene.state, amplitude, 4);
      expect_consistent_derivatives(
          contact, scene.layout, state,
          {.of_force = model == FiberModel::rod ? 0 : 1e-5, .of_tangent = model == FiberModel::rod ? 1e-5 : 5e-5});
    }
  }
}

// Where limits of friction go with the normal force, the tangent is not symmetric. What it leaves out besides:
// particles and normals that friction follows are laid anew where the feet have slid to.
TEST(Derivatives, FrictionThatGoesWithTheNormalForce) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    RubbingFibers rubbing(model);
    auto& [scene, contact] = rubbing;
    for (const double amplitude : {0.003, 0.05}) {
      const State state = perturbed(scene.layout, scene.state, amplitude, 4);
      (void)contact.follow(state, Effect::Follow::renewal, everywhere);
      const Eigen::MatrixXd tangent = test::assemble(contact, scene.layout, state).tangent;
      UnsymmetricTerms terms;
      contact.add_unsymmetric(state, terms);
      ASSERT_FALSE(terms.empty());
      double symmetric_alone = 0, with_terms = 0, all = 0;
      for (std::uint32_t seed = 100; seed < 106; ++seed) {
        std::vector<double> step = test::random_step(scene.layout, seed);
        for (const Index vector : scene.layout.rotation_vectors())
          std::fill_n(step.begin() + 3 * static_cast<std::ptrdiff_t>(vector), 3, 0.0);
        const auto force_at = [&](double h) {
          State s;
          retract(scene.layout, state, step, h, s);
          (void)contact.follow(s, Effect::Follow::renewed_trial, everywhere);
          return test::assemble(contact, scene.layout, s).force;
        };
        constexpr double h = 1e-6;
        const Eigen::VectorXd exact = (force_at(h) - force_at(-h)) / (2 * h);
        std::vector<double> product(step.size(), 0.0);
        terms.add_product(step, product);
        const Eigen::Map<const Eigen::VectorXd> v(step.data(), scene.layout.n_dofs()),
            besides(product.data(), scene.layout.n_dofs());
        symmetric_alone += (tangent * v - exact).squaredNorm();
        with_terms += (tangent * v + besides - exact).squaredNorm();
        all += exact.squaredNorm();
      }
      EXPECT_LT(with_terms, 0.02 * 0.02 * all) << amplitude;
      EXPECT_LT(with_terms, 0.3 * 0.3 * symmetric_alone) << amplitude;
    }
  }
}

/// Two fibers, and surfaces of a turned body that are pressed into the first one, each seen in another way.
struct RubbedBySurfaces {
  explicit RubbedBySurfaces(FiberModel model)
      : scene(model), contact(scene.field, scene.bodies, surfaces(), {}, {1, 1}) {
    contact.begin_step(scene.state, 1);
    contact.update(scene.state);
  }
  /// Given where they are seen from: the middle of the fiber, 0.95 of its radius away along n.
  [[nodiscard]] std::vector<BodySurface> surfaces() const {
    const Pose pose = scene.bodies.pose(scene.state, 0);
    const Mat3 to_body = pose.rotation.transpose();
    const Vec3 seen_from = to_body * (Vec3(5, 0.4, 0.2) - pose.position), n = to_body * Vec3(0.1, -0.2, 1).normalized(),
               axis = to_body * Vec3(0.1, 1, 0.2).normalized(), across = (axis - n * n.dot(axis)).normalized();
    const double away = 0.95;
    const Vec3 foot = seen_from - away * n;
    std::vector<Surface> all(9);
    all[0] = {SurfaceShape::plane, foot, n};
    all[1] = {SurfaceShape::cylinder, foot - 3 * n, across, 3};
    all[2] = {SurfaceShape::sphere, foot - 4 * n, Vec3::UnitZ(), 4};
    // Its rounded end.
    const Vec3 leaning = (n + 0.8 * across).normalized();
    all[3] = {SurfaceShape::cylinder, foot - 2 * n - 1.5 * leaning, leaning, 2, 1.5};
    // From inside.
    all[4] = {SurfaceShape::cylinder, foot + 6 * n, across, 6};
    all[4].inside = true;
    // An edge, and a face.
    all[5] = {.shape = SurfaceShape::box, .half_size = {1, 2, 3}};
    all[5].center = seen_from - Vec3(1 + 0.6 * away, 2 + 0.8 * away, 2);
    all[6] = {.shape = SurfaceShape::box, .half_size = {1, 2, 3}};
    all[6].center = seen_from - Vec3(0.5, 1, 3 + away);
    // An edge of a mesh, and a corner, each seen from where nothing of it is nearer.
    const Vec3 half(1, 2, 3), beyond_edge = Vec3(0, 0.8, -0.6) * away, beyond_corner = Vec3(2, -1, 2) / 3 * away;
    all[7] = {.shape = SurfaceShape::mesh, .mesh = test::mesh_of(test::box_corners(-half, half))};
    all[7].center = seen_from - Vec3(0.5, 2, -3) - beyond_edge;
    all[8] = {.shape = SurfaceShape::mesh, .mesh = all[7].mesh};
    all[8].center = seen_from - Vec3(1, -2, 3) - beyond_corner;
    std::vector<BodySurface> result;
    for (const Surface& surface : all) result.push_back({0, surface, 0.3, "body"});
    return result;
  }
  TwoFibers scene;
  SurfaceContact contact;
};

TEST(Derivatives, ContactWithSurfaces) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    RubbedBySurfaces rubbed(model);
    auto& [scene, contact] = rubbed;
    std::vector<bool> pressed(contact.surfaces().size());
    for (const SurfaceContactElement& e : contact.elements())
      if (e.gap() < -0.02) pressed[e.surface] = true;
    EXPECT_EQ(pressed, std::vector<bool>(pressed.size(), true));
    for (const double amplitude : {0.003, 0.05})
      expect_consistent_derivatives(contact, scene.layout, perturbed(scene.layout, scene.state, amplitude, 7));
  }
}

TEST(Derivatives, CrossingOrder) {
  TwoFibers scene(FiberModel::rod, TwoFibers::Arrangement::crossed);
  CrossingOrder order(scene.field, {{0, 1}},
                      {.start_depth = -2, .penalty = 1, .p_reg = 0.03, .target_penetration = 0.3});
  order.begin_step(scene.state, 1);
  order.update(scene.state);
  ASSERT_EQ(order.elements().size(), 1u);
  // Vertical forces have a potential where fibers are level; what is left out goes with their slopes.
  const double slope = 0.25;
  expect_consistent_derivatives(order, scene.layout, perturbed(scene.layout, scene.state, 0.05, 5), {slope, slope});
  expect_consistent_derivatives(order, scene.layout, perturbed(scene.layout, scene.state, 0.001, 5),
                                {0.5 * slope, 0.5 * slope});
}

TEST(Derivatives, Proximal) {
  TwoFibers scene(FiberModel::rod);
  Proximal proximal(scene.layout, {.first_node = 2, .start = 0.3, .end = 0.3});
  proximal.begin_step(scene.state, 0.5);
  expect_consistent_derivatives(proximal, scene.layout, perturbed(scene.layout, scene.state, 0.1, 6));
}

TEST(Derivatives, Ties) {
  TwoFibers scene(FiberModel::enriched);
  const Vec3 axis = Vec3(1, 2, -1).normalized();
  using Holds = TieTerm::Holds;
  std::vector<TieTerm> terms;
  terms.push_back({0, {{scene.field.element_node(0, 0), 0}}, Holds::point, Vec3(0.2, 0.3, -0.4), Mat3::Identity(), 3});
  terms.push_back({0, {{scene.field.element_node(0, 0), 1}}, Holds::vector, Vec3(0.1, 0.9, 0.2), Mat3::Identity(), 2});
  terms.push_back({1,
                   {{scene.field.last_node(0), 0}, {scene.field.last_node(1), 0}},
                   Holds::point,
                   Vec3(0.5, 0.1, 0.7),
                   Mat3::Identity() - axis * axis.transpose(),
                   5});
  Ties ties(scene.layout, scene.bodies, terms);
  ties.begin_step(scene.state, 1);
  expect_consistent_derivatives(ties, scene.layout, perturbed(scene.layout, scene.state, 0.2, 7));
}

/// Ties of the directions of both rods' ends, away from their equilibrium.
struct TiedDirections {
  TwoFibers scene{FiberModel::rod};
  Vec3 held = Vec3(0.9, 0.3, -0.2).normalized();
  Ties ties{scene.layout,
            scene.bodies,
            {{0, {{scene.field.element_node(0, 0), 1}}, TieTerm::Holds::direction, held, Mat3::Identity(), 3},
             {1, {{scene.field.last_node(1), 1}}, TieTerm::Holds::direction, held, Mat3::Identity(), 2}}};
};

TEST(Derivatives, TiesOfDirections) {
  TiedDirections tied;
  tied.ties.begin_step(tied.scene.state, 1);
  for (const double amplitude : {0.02, 0.4})
    expect_consistent_derivatives(tied.ties, tied.scene.layout,
                                  perturbed(tied.scene.layout, tied.scene.state, amplitude, 10));
}

TEST(Derivatives, ProjectedTangentOfTiedDirectionsIsPositive) {
  TiedDirections tied;
  tied.ties.begin_step(tied.scene.state, 1);
  const State away = perturbed(tied.scene.layout, tied.scene.state, 0.6, 11);
  const auto smallest = [&](Assembler::Tangent kind) {
    const Eigen::MatrixXd k = test::assemble(tied.ties, tied.scene.layout, away, kind).tangent;
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvalues().minCoeff();
  };
  EXPECT_GT(smallest(Assembler::Tangent::projected), -1e-12);
  EXPECT_LT(smallest(Assembler::Tangent::exact), -1e-3);  // so that the projection has something to do

  // In equilibrium, whatever the length of r', both are the same: nothing is left to project.
  State held = tied.scene.state;
  const auto turn_to = [&](Index node, Index body, double length) {
    held.q[tied.scene.layout.first_vector(node) + 1] = length * tied.scene.bodies.pose(held, body).rotation * tied.held;
  };
  turn_to(tied.scene.field.element_node(0, 0), 0, 1.3);
  turn_to(tied.scene.field.last_node(1), 1, 0.7);
  EXPECT_NEAR(tied.ties.energy(held), 0, 1e-28);
  const Eigen::MatrixXd exact = test::assemble(tied.ties, tied.scene.layout, held).tangent;
  const Eigen::MatrixXd projected =
      test::assemble(tied.ties, tied.scene.layout, held, Assembler::Tangent::projected).tangent;
  EXPECT_LT((exact - projected).norm(), 1e-12 * exact.norm());
}

TEST(Derivatives, Follow) {
  TwoFibers scene(FiberModel::rod);
  Follow follow(scene.bodies, {{1, 0, 2, {Vec3(0.1, 0.2, 0.3), Mat3::Identity()}, Vec3(1, -2, 0.5), 4.0}});
  expect_consistent_derivatives(follow, scene.layout, perturbed(scene.layout, scene.state, 0.3, 8));
}

/// To first order nothing is strained by a rotation, which along its tangent strains by its square.
TEST(ExpectedStress, OfARotationIsNone) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    TwoFibers scene(model);
    const Vec3 turn(0.2, -0.3, 0.4);
    std::vector<double> step(scene.layout.n_dofs());
    std::vector<Vec3> last_step(scene.layout.n_vectors());
    for (Index v = 0; v < scene.layout.n_vectors(); ++v) {
      last_step[v] = turn.cross(scene.state.q[v]);  // of positions, and of what points along fibers and sections
      for (const Index r : scene.layout.rotation_vectors())
        if (v == r) last_step[v] = turn;
      Eigen::Map<Vec3>(step.data() + 3 * v) = last_step[v];
    }
    State turned;
    retract(scene.layout, scene.state, step, 1, turned);

    const Index first = scene.field.element_node(0, 0), last = scene.field.last_node(1);
    const Pose start = scene.bodies.pose(scene.state, 0), end = scene.bodies.pose(scene.state, 1);
    const auto at = [&](Index node, int v) { return scene.state.q[scene.layout.first_vector(node) + v]; };
    std::vector<std::unique_ptr<Effect>> effects;
    using Holds = TieTerm::Holds;
    effects.push_back(std::make_unique<Ties>(
        scene.layout, scene.bodies,
        std::vector<TieTerm>{
            {0,
             {{first, 0}},
             Holds::point,
             start.rotation.transpose() * (at(first, 0) - start.position),
             Mat3::Identity(),
             3},
            {0, {{first, 1}}, Holds::vector, start.rotation.transpose() * at(first, 1), Mat3::Identity(), 3},
            {1,
             {{last, 1}},
             Holds::direction,
             end.rotation.transpose() * at(last, 1).normalized(),
             Mat3::Identity(),
             3}}));
    effects.push_back(
        std::make_unique<Follow>(scene.bodies, std::vector<FollowTerm>{{1, 0, 2, start, end.position, 4.0}}));
    const std::vector<Material> materials(2, isotropic(1, 0.39));
    if (model == FiberModel::rod)
      effects.push_back(std::make_unique<Rods>(scene.field, materials));
    else
      for (const bool twist_stretch : {false, true})
        effects.push_back(std::make_unique<EnrichedBeams>(scene.field, materials, scene.configuration, twist_stretch));
    for (const auto& effect : effects) {
      effect->begin_step(scene.state, 1);
      using Tangent = Assembler::Tangent;
      // Rods are bent a little at the start: their forces go with r'', which the step makes longer by √(1 + θ²) at
      // most.
      const double at_rest = test::assemble(*effect, scene.layout, scene.state).force.norm();
      EXPECT_GT(test::assemble(*effect, scene.layout, turned).force.norm(), at_rest + 0.01) << effect->name();
      EXPECT_LT(test::assemble(*effect, scene.layout, turned, Tangent::exact, last_step.data()).force.norm(),
                (1 + turn.squaredNorm()) * at_rest + 1e-12)
          << effect->name();
    }
  }
}

TEST(Derivatives, BodyForces) {
  TwoFibers scene(FiberModel::rod);
  BodyLoads loads(scene.bodies, {{0, BodyDof::y, 1.0, 3.0}, {1, BodyDof::z, 0.0, -2.0}});
  loads.begin_step(scene.state, 0.25);
  expect_consistent_derivatives(loads, scene.layout, perturbed(scene.layout, scene.state, 0.3, 9));
}

}  // namespace
}  // namespace trame::micro
