/// \file
/// The energy books: what each line is worth, and that a run balances with all of them.

#include "micro/core/ledger.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "micro/contact/contact.h"
#include "micro/solve/proximal.h"
#include "tests/support/finite_differences.h"
#include "tests/support/run_scene.h"

namespace trame::micro {
namespace {

TEST(Ledger, NothingComesInUnderALawThatStays) {
  const PenaltyLaw law{2, 0.1, 0.03};
  for (const double start : {-0.3, -0.01, 0.05, 0.5})
    for (const double end : {-0.3, -0.01, 0.05, 0.5}) EXPECT_EQ(work_of_new_law(start, end, law, law), 0);
}

TEST(Ledger, APreloadThatTakesOverAForceCostsWhatThePenetrationWasShortOf) {
  // ½ k p² was stored and f p comes back when the penetration goes: of a penalty without regularisation, half of that.
  const double k = 2, p = 0.3;
  EXPECT_NEAR(work_of_new_law(-p, 0, {k, 0, 1e-9}, {k, p, 1e-9}), 0.5 * k * p * p, 1e-8);
}

// A force that rises while preloads take it over, so that nothing penetrates at the ends of steps: nothing moves, and
// nothing comes in. Nor does it where the contact closes on the way.
TEST(Ledger, PreloadsThatRiseWithTheForceCostNothing) {
  const double k = 2;
  for (const double start_gap : {0.0, 0.4})
    EXPECT_NEAR(work_of_new_law(start_gap, 0, {k, 0.1, 1e-9}, {k, 0.2, 1e-9}), 0, 1e-8);
}

// Pressed and let go without friction, fibers give back what they took, whatever became of preloads on the way.
TEST(Ledger, ContactsThatArePressedAndLetGoAreEven) {
  Scene scene = read_scene(std::filesystem::path(TRAME_DATA_DIR) / "scenes/two_crossing_fibers.toml");
  scene.contact.friction = false;
  scene.stages[0].drives[0].amplitude.points = {{0.5, 1}, {1, 0}};
  const auto result = test::run_scene(scene);
  ASSERT_TRUE(result.done()) << result.summary.message;
  double most = 0;
  for (const Increment& i : result.increments) most = std::max(most, i.solver.energy.external_work);
  EXPECT_GT(most, 0);
  EXPECT_LT(std::abs(result.last().solver.energy.imbalance), 0.002 * most);
}

TEST(Ledger, ContactsAreCountedWhereTheyPressLess) {
  const ContactAt apart{}, pressed{2, 0.5}, harder{3, 1};
  EXPECT_EQ(energy_brought(apart, pressed), 0);     // it came before it pressed
  EXPECT_EQ(energy_brought(pressed, apart), 0);     // it has gone when it no longer did
  EXPECT_EQ(energy_brought(pressed, harder), 0.5);  // it takes the place of another one
  EXPECT_EQ(energy_brought(harder, pressed), 0.5);
}

TEST(Ledger, TheProximalTermTakesTheMeanOfItsForces) {
  const test::TwoFibers scene(FiberModel::rod);
  Proximal proximal(scene.layout, {.first_node = 2, .start = 0.3, .end = 0.3});
  State from = scene.state, to = from;
  double expected = 0, force = 0;
  for (const double motion : {0.2, 0.5}) {
    to.q[scene.layout.first_vector(2)].x() += motion;
    proximal.begin_step(from, 0.5);
    proximal.commit(to);
    expected += 0.5 * (force + 0.3 * motion) * motion;
    force = 0.3 * motion;
    from = to;
  }
  EXPECT_NEAR(proximal.ledger(to)[Sink::damping], expected, 1e-12);
  EXPECT_EQ(proximal.ledger(to).stored, 0);
}

/// The second of two crossed fibers, moved.
State moved(const test::TwoFibers& scene, const Vec3& by) {
  State state = scene.state;
  for (Index n = scene.field.element_node(1, 0); n <= scene.field.last_node(1); ++n)
    state.q[scene.layout.first_vector(n)] += by;
  return state;
}

Contact contact_of(const test::TwoFibers& scene, bool friction) {
  ContactLaw law;
  law.adapt_penalty = false;
  law.friction = friction;
  return {scene.field, law, {1, 1}};
}

/// A step that ends at `end`, to contacts found at `found`.
void step(Contact& contact, const State& start, const State& found, const State& end) {
  contact.begin_step(start, 1);
  contact.update(found);
  (void)contact.follow(end, Effect::Follow::renewal, everywhere);
  contact.commit(end);
}

TEST(Ledger, ContactsThatComeOrGoUnderPressureAreWork) {
  const test::TwoFibers scene(FiberModel::rod, test::TwoFibers::Arrangement::crossed);
  const State pressed = scene.state, apart = moved(scene, {0, 0, -5});
  Contact contact = contact_of(scene, false);
  step(contact, apart, apart, apart);
  ASSERT_EQ(contact.elements().size(), 0u);
  step(contact, pressed, pressed, pressed);
  ASSERT_GT(contact.ledger(pressed).stored, 0);
  EXPECT_DOUBLE_EQ(contact.ledger(pressed)[Source::contacts], contact.ledger(pressed).stored);
  step(contact, pressed, apart, pressed);
  EXPECT_EQ(contact.ledger(pressed).stored, 0);
  EXPECT_NEAR(contact.ledger(pressed)[Source::contacts], 0, 1e-15);
}

TEST(Ledger, ContactsThatAreFoundInTimeBringNothing) {
  const test::TwoFibers scene(FiberModel::rod, test::TwoFibers::Arrangement::crossed);
  const State pressed = scene.state, near = moved(scene, {0, 0, -0.4}), apart = moved(scene, {0, 0, -5});
  Contact contact = contact_of(scene, false);
  step(contact, apart, apart, apart);
  step(contact, near, near, pressed);
  EXPECT_GT(contact.ledger(pressed).stored, 0);
  EXPECT_EQ(contact.ledger(pressed)[Source::contacts], 0);
}

TEST(Ledger, ReversibleSlipGoesWithTheNormalForce) {
  // Dragged by less than the reversible slip, then pressed harder: the same traction on a stiffer spring stores less.
  const test::TwoFibers scene(FiberModel::rod, test::TwoFibers::Arrangement::crossed);
  const State pressed = scene.state, dragged = moved(scene, {0.02, 0, 0}), harder = moved(scene, {0.02, 0, 0.1});
  Contact contact = contact_of(scene, true);
  step(contact, pressed, pressed, pressed);
  step(contact, pressed, pressed, dragged);
  ASSERT_EQ(contact.stick_slip().size(), 1u);
  const double traction = contact.tractions()[0].norm(), soft = contact.stick_slip()[0].tangential_stiffness;
  ASSERT_GT(traction, 0);
  const double before = contact.ledger(dragged)[Source::friction_limits];
  step(contact, dragged, dragged, harder);
  const double stiff = contact.stick_slip()[0].tangential_stiffness,
               carried = contact.stick_slip()[0].traction_start.norm();
  ASSERT_GT(stiff, 1.2 * soft);
  EXPECT_NEAR(contact.ledger(harder)[Source::friction_limits] - before,
              0.5 * (carried * carried / stiff - traction * traction / soft), 1e-12);
  EXPECT_LT(contact.ledger(harder)[Source::friction_limits], before);
}

TEST(Ledger, SlidingUnderAForceThatRisesTakesTheMeanOfItsLimits) {
  const test::TwoFibers scene(FiberModel::rod, test::TwoFibers::Arrangement::crossed);
  const State pressed = scene.state, slid = moved(scene, {0.5, 0, 0}), on = moved(scene, {1.0, 0, 0.1});
  Contact contact = contact_of(scene, true);
  step(contact, pressed, pressed, pressed);
  step(contact, pressed, pressed, slid);
  ASSERT_EQ(contact.elements().size(), 1u);
  const double first = contact.stick_slip()[0].slip_limit, before = contact.ledger(slid)[Sink::friction];
  ASSERT_GT(before, 0);
  step(contact, slid, slid, on);
  const StickSlip& s = contact.stick_slip()[0];
  ASSERT_GT(s.slip_limit, 1.1 * first);
  const double slip = friction(s, contact.elements()[0].relative_position(scene.layout, on)).dissipated / s.slip_limit;
  EXPECT_NEAR(contact.ledger(on)[Sink::friction] - before, 0.5 * (first + s.slip_limit) * slip, 1e-9 * before);
}

TEST(Ledger, SumsItsLines) {
  Ledger a, b;
  a.stored = 1;
  a[Source::bodies] = 4;
  b[Source::contacts] = 2;
  b[Sink::friction] = 3;
  a += b;
  EXPECT_EQ(a.total_supplied(), 6);
  EXPECT_EQ(a.total_dissipated(), 3);
  EXPECT_EQ(a.imbalance(), 2);
}

/// Two warp over two weft yarns of three fibers, separated and relaxed as rods and settled as beams: a run with every
/// line of the books, though with little that slides, is damped, or comes and goes: tests above look at those.
Scene woven() {
  Scene scene;
  scene.name = "weave";
  scene.materials = {test::isotropic(1, 0.39)};
  scene.fiber_types = {{"f", 0, 1.0, FiberModel::enriched}};
  const YarnSystem yarns{{{.type = 0, .n_fibers = 3, .n_layers = 1, .lattice_spacing = 1.05}}, {0}, 2, 9, 14, 10};
  scene.weave = Weave{{{true, false}, {false, true}}, yarns, yarns};
  scene.contact.friction = true;
  scene.contact.friction_coefficient = 0.2;
  const auto pull = [](const char* bodies, BodyDof dof, double force) {
    return Drive{bodies, dof, DriveMode::force, force, ""};
  };
  const auto stage = [&](const char* name, int n_increments, double force) {
    Stage s;
    s.name = name;
    s.n_increments = n_increments;
    s.drives = {pull("warp/*/start", BodyDof::x, -force), pull("warp/*/end", BodyDof::x, force),
                pull("weft/*/start", BodyDof::y, -force), pull("weft/*/end", BodyDof::y, force)};
    return s;
  };
  scene.stages = {stage("separate", 12, 4e-3), stage("relax", 8, 4e-4), stage("settle", 2, 4e-4)};
  scene.stages[0].separate_yarns = true;
  scene.stages[0].friction = false;
  scene.stages[0].proximal_start = scene.stages[0].proximal_end = scene.stages[1].proximal_start = 1e-3;
  scene.stages[0].fiber_model = scene.stages[1].fiber_model = FiberModel::rod;
  return scene;
}

class Books : public testing::Test {
 protected:
  static void SetUpTestSuite() { run_ = new test::RunResult(test::run_scene(woven())); }
  static void TearDownTestSuite() { delete run_; }
  static const EnergyRecord& energy() { return run_->summary.energy; }
  static test::RunResult* run_;
};
test::RunResult* Books::run_ = nullptr;

TEST_F(Books, Balance) {
  ASSERT_TRUE(run_->done()) << run_->summary.message;
  EXPECT_LT(std::abs(energy().imbalance), 0.01 * energy().external_work);
  double work = 0;
  for (const double w : energy().work) work += w;
  EXPECT_NEAR(work, energy().external_work, 1e-12 * work);
  EXPECT_NEAR(energy().imbalance, work - energy().stored - energy().friction - energy().damping - energy().release,
              1e-12 * work);
}

TEST_F(Books, WouldNotBalanceWithoutAnyOfTheirLines) {
  const double imbalance = std::abs(energy().imbalance);
  for (const Source s : {Source::bodies, Source::separation, Source::preloads, Source::gap_offsets}) {
    const auto line = static_cast<std::size_t>(s);
    EXPECT_GT(std::abs(energy().work[line]), imbalance) << source_names[line];
  }
  // What the last stage brings is measured by what the books are off by since then.
  const auto& all = run_->increments;
  const auto before = std::find_if(all.begin(), all.end(), [](const Increment& i) { return i.stage == "settle"; }) - 1;
  const auto stages = static_cast<std::size_t>(Source::stages);
  EXPECT_GT(std::abs(energy().work[stages] - before->solver.energy.work[stages]),
            100 * std::abs(energy().imbalance - before->solver.energy.imbalance));
  EXPECT_GT(energy().release, imbalance);
}

}  // namespace
}  // namespace trame::micro
