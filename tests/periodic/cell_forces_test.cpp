/// \file
/// Forces of a periodic cell: they are the gradient of the energy, by its periods too; no place of a fiber is like an
/// end; turning and moving the whole changes nothing.

#include "micro/contact/contact.h"
#include "micro/fiber/enriched_beam.h"
#include "micro/fiber/rod.h"
#include "micro/periodic/anchors.h"
#include "micro/weave/crossing_order.h"
#include "tests/periodic/periodic_fixture.h"
#include "tests/support/finite_differences.h"

namespace trame::micro {
namespace {

using test::Cell;
using test::CellOptions;
using test::expect_consistent_derivatives;
using test::isotropic;
using test::perturbed;

std::vector<Material> materials(const Cell& cell) {
  return std::vector<Material>(cell.assembly.mesh.n_fibers(), isotropic(1, 0.25));
}

TEST(PeriodicDerivatives, FibersByNodesAndPeriods) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    const Cell cell({.model = model});
    const State state = perturbed(cell.model->layout, cell.state, 0.1, 1);
    if (model == FiberModel::rod) {
      Rods rods(cell.model->field, materials(cell));
      expect_consistent_derivatives(rods, cell.model->layout, state);
    } else {
      EnrichedBeams beams(cell.model->field, materials(cell), cell.assembly.configuration, true);
      expect_consistent_derivatives(beams, cell.model->layout, state);
    }
  }
}

TEST(PeriodicDerivatives, Anchors) {
  const Cell cell({});
  Anchors anchors(cell.model->field);
  anchors.begin_step(cell.state, 1);
  expect_consistent_derivatives(anchors, cell.model->layout, perturbed(cell.model->layout, cell.state, 0.1, 2));
}

// Of beams the sections are alike: forces do not know how sections grow from element to element.
TEST(PeriodicDerivatives, ContactAndFrictionWithImages) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    const Cell cell({.model = model, .n_weft = 1});
    ContactLaw law;
    law.friction_coefficient = 0.4;
    Contact contact(cell.model->field, law, std::vector<double>(cell.assembly.mesh.n_fibers(), 1.0));
    contact.begin_step(cell.state, 1);
    contact.update(cell.state);
    const auto& elements = contact.elements();
    // The fibers of the warp touch each other in the cell and across its side, and those of the weft.
    EXPECT_TRUE(std::any_of(elements.begin(), elements.end(),
                            [](const ContactElement& e) { return e.pair.image() != Image{} && e.gap() < 0; }));
    EXPECT_TRUE(std::any_of(elements.begin(), elements.end(), [](const ContactElement& e) { return e.crossing; }));
    for (const double amplitude : {0.003, 0.02}) {
      State state = perturbed(cell.model->layout, cell.state, amplitude, 4);
      for (Index n = cell.model->bodies.n_bodies(); n < cell.model->layout.n_nodes(); ++n)
        for (Index v = cell.model->layout.first_vector(n) + 1; v < cell.model->layout.first_vector(n) + 3; ++v)
          if (model == FiberModel::enriched) state.q[v] = cell.state.q[v];
      expect_consistent_derivatives(contact, cell.model->layout, state,
                                    {.of_force = model == FiberModel::rod ? 0 : 1e-5,
                                     .of_tangent = model == FiberModel::rod ? 1e-5 : 0.01 + 1.5 * amplitude});
    }
  }
}

// All that repeats within the cell feels the same forces, wherever the seam is; and the forces on all nodes of the
// cell's fibers add up to nothing.
TEST(PeriodicForces, NoPlaceIsLikeAnEnd) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    const Cell cell({.model = model});
    const Layout& layout = cell.model->layout;
    const FiberField& field = cell.model->field;
    const std::vector<double> force = cell.gradient(cell.state);
    const auto of_node = [&](Index n) { return Eigen::Map<const Vec3>(force.data() + layout.first_dof(n)); };
    double largest = 0;
    Vec3 sum = Vec3::Zero();
    for (Index f = 0; f < cell.assembly.mesh.n_fibers(); ++f) {
      const Index first = field.element_node(f, 0), n = field.last_node(f) + 1 - first;
      for (Index i = 0; i < n; ++i) {
        largest = std::max(largest, of_node(first + i).norm());
        sum += of_node(first + i);
        // Two crossing fibers in a period: what is half a period on is the same.
        EXPECT_LT((of_node(first + i) - of_node(first + (i + n / 2) % n)).norm(), 1e-10) << f << " " << i;
      }
    }
    EXPECT_GT(largest, 1e-4);
    EXPECT_LT(sum.norm(), 1e-12);
  }
}

double energy_of(const Cell& cell) {
  double sum = 0;
  for (const auto& effect : cell.model->effects) sum += effect->energy(cell.state);
  return sum;
}

// Warp fibers with two ends touch each other across the seam of the weft.
TEST(PeriodicForces, OfAStripOfTwoRepeats) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    const Cell one({.model = model, .is_strip = true}),
        two({.model = model, .n_warp = 4, .weft_elements = 2, .is_strip = true});
    const std::vector<double> force = one.gradient(one.state), of_two = two.gradient(two.state);
    EXPECT_TRUE(std::any_of(one.model->contact->elements().begin(), one.model->contact->elements().end(),
                            [](const ContactElement& e) { return e.pair.image()[1] != 0 && e.gap() < 0; }));
    EXPECT_LT(one.assembly.period_bodies[0], 0);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(force[6 * one.assembly.period_bodies[1] + c], of_two[6 * two.assembly.period_bodies[1] + c], 1e-10);
    EXPECT_NEAR(2 * energy_of(one), energy_of(two), 1e-10);
    EXPECT_GT(energy_of(one), 1e-5);
  }
}

// A cell of two by two repeats has four times the contacts of one, and twice the force on each period.
TEST(PeriodicForces, OfTwoByTwoRepeats) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    const Cell one({.model = model}), four({.model = model, .n_warp = 4, .n_weft = 4, .n_elements = 4});
    const std::vector<double> force = one.gradient(one.state), of_four = four.gradient(four.state);
    // Beside a point of contact samples take part that do not touch, as arc lengths have it.
    const auto touching = [](const Cell& cell) {
      std::pair<int, double> sum{0, 0};  // number and length
      for (const ContactElement& e : cell.model->contact->elements())
        if (e.gap() < 0) sum = {sum.first + 1, sum.second + e.length};
      return sum;
    };
    EXPECT_GE(touching(one).first, 8);
    EXPECT_EQ(4 * touching(one).first, touching(four).first);
    EXPECT_NEAR(4 * touching(one).second, touching(four).second, 1e-9);
    for (const Index period : one.assembly.period_bodies)
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(2 * force[6 * period + c], of_four[6 * period + c], 1e-10) << period << " " << c;
    EXPECT_NEAR(4 * energy_of(one), energy_of(four), 1e-10);
    EXPECT_GT(energy_of(one), 1e-5);
  }
}

TEST(PeriodicForces, TurnAndMoveWithTheCell) {
  for (const FiberModel model : {FiberModel::enriched, FiberModel::rod}) {
    Cell cell({.model = model});
    const Layout& layout = cell.model->layout;
    const State state = perturbed(layout, cell.state, 0.01, 7);
    const Mat3 turn = rotation_matrix({0.2, -0.4, 0.7});
    State moved = state;
    const Index n_bodies = cell.model->bodies.n_bodies();
    for (Index b = 0; b < n_bodies; ++b) moved.q[2 * b] = turn * state.q[2 * b];
    for (Index n = n_bodies; n < layout.n_nodes(); ++n)
      for (Index v = 0; v < layout.n_vectors(n); ++v) {
        Vec3& q = moved.q[layout.first_vector(n) + v];
        q = turn * q;
        if (v == 0) q += Vec3(3, -40, 7);
      }
    const std::vector<double> force = cell.gradient(state), of_moved = cell.gradient(moved);
    for (Index v = 0; v < layout.n_vectors(); ++v) {
      const Eigen::Map<const Vec3> f(force.data() + 3 * v), g(of_moved.data() + 3 * v);
      EXPECT_LT((turn * f - g).norm(), 1e-9) << v;
    }
  }
}

TEST(PeriodicForces, CrossingsAreSeenOnceAcrossSeams) {
  // Fibers whose seam is moved to where they cross: shifted in their own direction by half a cell.
  Cell cell({.model = FiberModel::rod});
  State state = cell.state;
  const FiberField& field = cell.model->field;
  for (Index f = 0; f < cell.assembly.mesh.n_fibers(); ++f) {
    const Vec3 along = 0.25 * field.period(state, cell.assembly.mesh.period(f));
    for (Index n = field.element_node(f, 0); n <= field.last_node(f); ++n)
      state.q[cell.model->layout.first_vector(n)] += along;
  }
  const ProximitySearch search;
  const auto count = [&](const State& at) {
    const std::vector<Proximity> found = find_proximities(field, at, search);
    return std::count_if(found.begin(), found.end(), [&](const Proximity& p) {
      return p.point && cell.assembly.mesh.period(p.fiber_a()) != cell.assembly.mesh.period(p.fiber_b());
    });
  };
  EXPECT_EQ(count(cell.state), 4);
  EXPECT_EQ(count(state), 4);
  CrossingOrder order(field, ordered_crossings(cell.assembly),
                      {.start_depth = -2, .penalty = 1, .p_reg = 0.03, .target_penetration = 0.3});
  order.begin_step(state, 1);
  order.update(state);
  EXPECT_EQ(order.elements().size(), 4u);
}

}  // namespace
}  // namespace trame::micro
