// Runs that were ended and are gone on with.

#include <gtest/gtest.h>
#include <hdf5.h>

#include <atomic>
#include <fstream>

#include "micro/core/error.h"
#include "micro/solve/system.h"
#include "tests/support/run_scene.h"
#include "tests/support/text_file.h"

namespace trame::micro {
namespace {

using Status = SimulationSummary::Status;
namespace fs = std::filesystem;

/// Two fibers that are pressed onto each other and dragged, with friction, in two stages, saved now and then.
Scene dragged() {
  Scene scene = read_scene(fs::path(TRAME_DATA_DIR) / "scenes/two_crossing_fibers.toml");
  scene.stages[0].n_increments = 5;
  scene.stages[0].save_every = 2;
  Stage drag;
  drag.name = "drag";
  drag.n_increments = 4;
  drag.save_every = 3;
  drag.drives = {{"upper/*", BodyDof::x, DriveMode::displacement, 5e-6, ""}};
  scene.stages.push_back(drag);
  return scene;
}

/// Runs into `states`, and asks for the end after increment `last`; 0: never.
SimulationSummary run_until(const Scene& scene, const fs::path& states, Index last, bool resume, int n_threads = 1) {
  std::atomic<bool> stop = false;
  SimulateOptions options;
  options.states = states;
  options.n_threads = n_threads;
  options.resume = resume;
  options.stop = &stop;
  options.on_increment = [&](const Progress& progress) { stop = progress.increment == last; };
  return simulate(scene, options);
}

std::string refusal(const Scene& scene, const fs::path& states, const std::string& changes = "") {
  SimulateOptions options;
  options.states = states;
  options.resume = true;
  options.changes = changes;
  try {
    (void)check_start(scene, options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

void expect_same(const fs::path& a, const fs::path& b) {
  const SnapshotReader x(a), y(b);
  ASSERT_EQ(x.n_increments(), y.n_increments());
  for (Index i = 0; i < x.n_increments(); ++i) {
    const Increment p = x.read(i), q = y.read(i);
    EXPECT_EQ(p.stage, q.stage);
    EXPECT_EQ(p.stage_time, q.stage_time);
    EXPECT_EQ(p.fibers.r, q.fibers.r) << i;
    EXPECT_EQ(p.fibers.g1, q.fibers.g1) << i;
    EXPECT_EQ(p.contacts.s_a, q.contacts.s_a) << i;
    EXPECT_EQ(p.contacts.normal_force, q.contacts.normal_force) << i;
    EXPECT_EQ(p.contacts.friction_force, q.contacts.friction_force) << i;
    EXPECT_EQ(p.contacts.preload, q.contacts.preload) << i;
    EXPECT_EQ(p.bodies.force, q.bodies.force) << i;
    EXPECT_EQ(p.solver.n_newton_iterations, q.solver.n_newton_iterations) << i;
    EXPECT_EQ(p.solver.energy.external_work, q.solver.energy.external_work) << i;
    EXPECT_EQ(p.solver.energy.friction, q.solver.energy.friction) << i;
  }
}

void expect_same(const SimulationSummary& a, const SimulationSummary& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.n_increments, b.n_increments);
  EXPECT_EQ(a.n_newton_iterations, b.n_newton_iterations);
  EXPECT_EQ(a.n_factorizations, b.n_factorizations);
  EXPECT_EQ(a.warnings, b.warnings);
  EXPECT_EQ(a.energy.imbalance, b.energy.imbalance);
  ASSERT_EQ(a.curve.size(), b.curve.size());
  for (std::size_t i = 0; i < a.curve.size(); ++i) {
    EXPECT_EQ(a.curve[i].stage, b.curve[i].stage);
    EXPECT_EQ(a.curve[i].stage_time, b.curve[i].stage_time);
    EXPECT_EQ(a.curve[i].side_force, b.curve[i].side_force);
    EXPECT_EQ(a.curve[i].motion, b.curve[i].motion);
    EXPECT_EQ(a.curve[i].reaction, b.curve[i].reaction);
    EXPECT_EQ(a.curve[i].energy.stored, b.curve[i].energy.stored);
  }
}

class Resume : public testing::Test {
 protected:
  [[nodiscard]] fs::path file(const std::string& name) const { return folder_ / name; }
  trame::test::TemporaryFolder folder_;
};

TEST_F(Resume, AfterAnyIncrementLeavesWhatTheWholeRunDoes) {
  const Scene scene = dragged();
  const SimulationSummary whole = run_until(scene, file("whole.h5"), 0, false);
  ASSERT_EQ(whole.status, Status::done);
  for (Index last = 1; last <= whole.n_increments; ++last) {
    SCOPED_TRACE(last);
    const fs::path states = file(std::to_string(last) + ".h5");
    EXPECT_EQ(run_until(scene, states, last, false).n_increments, last);
    expect_same(run_until(scene, states, 0, true, 1 + last % 2), whole);
    expect_same(states, file("whole.h5"));
    EXPECT_FALSE(fs::exists(states.string() + ".part"));
  }
}

/// A fiber that a ball is pressed on, which then turns.
Scene rolled() {
  Scene scene = dragged();
  scene.bodies.push_back({"ball", {0, 20e-6, 62e-6}, {}, {{}}});
  scene.bodies.back().surfaces[0].surface = {.shape = SurfaceShape::sphere, .radius = 30e-6};
  scene.stages[0].drives.push_back({"ball", BodyDof::z, DriveMode::displacement, -25e-6, ""});
  scene.stages[1].drives.push_back({"ball", BodyDof::rx, DriveMode::displacement, 0.1, ""});
  return scene;
}

TEST_F(Resume, WithSurfaces) {
  const Scene scene = rolled();
  const SimulationSummary whole = run_until(scene, file("whole.h5"), 0, false);
  ASSERT_EQ(whole.status, Status::done) << whole.message;
  const Increment last_state = SnapshotReader(file("whole.h5")).read(3);
  EXPECT_GT(last_state.bodies.force.back().norm(), 0) << "it touches nothing";
  for (Index last = 1; last <= whole.n_increments; ++last) {
    SCOPED_TRACE(last);
    const fs::path states = file(std::to_string(last) + ".h5");
    (void)run_until(scene, states, last, false);
    expect_same(run_until(scene, states, 0, true, 1 + last % 2), whole);
    expect_same(states, file("whole.h5"));
  }
}

TEST_F(Resume, AgainAndAgain) {
  const Scene scene = dragged();
  const SimulationSummary whole = run_until(scene, file("whole.h5"), 0, false);
  for (Index last = 1; last < whole.n_increments; ++last) (void)run_until(scene, file("pieces.h5"), last, true);
  expect_same(run_until(scene, file("pieces.h5"), 0, true), whole);
  expect_same(file("pieces.h5"), file("whole.h5"));
}

TEST_F(Resume, OfARunThatIsDoneGoesOnWithTheStagesThatTheSceneHasGained) {
  const Scene longer = dragged();
  Scene scene = longer;
  scene.stages.pop_back();
  (void)run_until(scene, file("grown.h5"), 0, false);
  const auto before = trame::test::read_text(file("grown.h5"));
  const SimulationSummary again = run_until(scene, file("grown.h5"), 0, true);
  EXPECT_EQ(again.status, Status::done);
  EXPECT_EQ(again.n_increments, 5);
  EXPECT_EQ(trame::test::read_text(file("grown.h5")), before) << "nothing was left to do";
  const SimulationSummary grown = run_until(longer, file("grown.h5"), 0, true);
  expect_same(grown, run_until(longer, file("whole.h5"), 0, false));
  expect_same(file("grown.h5"), file("whole.h5"));
}

TEST_F(Resume, WithoutStatesBeginsAtTheStart) {
  EXPECT_EQ(run_until(dragged(), file("new.h5"), 0, true).status, Status::done);
}

TEST_F(Resume, KeepsTheStatesUntilTheNextIsSaved) {
  (void)run_until(dragged(), file("states.h5"), 2, false);
  const auto before = trame::test::read_text(file("states.h5"));
  trame::test::write_text(file("states.h5.part"), "of a run that was killed while it copied");
  std::atomic<bool> stop = true;
  SimulateOptions options;
  options.states = file("states.h5");
  options.n_threads = 1;
  options.resume = true;
  options.stop = &stop;
  (void)simulate(dragged(), options);
  EXPECT_EQ(trame::test::read_text(file("states.h5")), before);
  EXPECT_FALSE(fs::exists(file("states.h5.part")));
}

TEST_F(Resume, OfAnotherSceneIsRefused) {
  const Scene scene = dragged();
  (void)run_until(scene, file("states.h5"), 2, false);
  EXPECT_EQ(refusal(scene, file("states.h5")), "");
  Scene other = scene;
  const auto changed = [&](const std::string& from, const std::string& to) {
    other.text = scene.text;
    other.text.replace(other.text.find(from), from.size(), to);
    return refusal(other, file("states.h5"));
  };
  EXPECT_NE(changed("\"3 GPa\"", "\"4 GPa\"")
                .find("of another scene: material.pa66.young_modulus is '3 GPa' there and '4 GPa' here"),
            std::string::npos);
  EXPECT_NE(changed("friction_coefficient = 0.2", "friction_coefficient = 0.3")
                .find("contact.friction_coefficient is 0.2 there and 0.3 here"),
            std::string::npos);
  other.text = scene.text;
  other.text.replace(other.text.find("friction_coefficient = 0.2"), 26, "friction_coefficient = 0.3");
  other.text.replace(other.text.find("diameter = \"20 um\""), 18, "diameter = \"20.0 um\"");
  EXPECT_NE(refusal(other, file("states.h5")).find("contact.friction_coefficient is 0.2 there"), std::string::npos)
      << "the same diameter in other words is no difference";
  EXPECT_NE(changed("\"-20 um\"", "\"-19 um\"").find("stage push differs"), std::string::npos);
  EXPECT_EQ(changed("Two crossing", "Crossing"), "") << "a title makes no difference";
  EXPECT_NE(refusal(scene, file("states.h5"), "--alpha 1").find("is of a run with the scene as it is, not --alpha 1"),
            std::string::npos);
}

TEST_F(Resume, FromDamageIsRefused) {
  (void)run_until(dragged(), file("states.h5"), 2, false);
  const auto with_byte = [&](hsize_t at) {
    fs::copy_file(file("states.h5"), file("bad.h5"), fs::copy_options::overwrite_existing);
    const hid_t opened = H5Fopen(file("bad.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    for (const char* name : {"continuation/odd", "continuation/even"}) {
      const hid_t set = H5Dopen2(opened, name, H5P_DEFAULT), space = H5Dget_space(set);
      std::vector<std::uint8_t> bytes(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
      if (!bytes.empty()) {
        H5Dread(set, H5T_NATIVE_UINT8, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data());
        bytes[at % bytes.size()] ^= 16;
        H5Dwrite(set, H5T_NATIVE_UINT8, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data());
      }
      H5Sclose(space), H5Dclose(set);
    }
    H5Fclose(opened);
    return refusal(dragged(), file("bad.h5"));
  };
  for (const hsize_t at : {0, 9, 17, 30, 1000})
    EXPECT_NE(with_byte(at).find("--start-from and --after"), std::string::npos) << at;
}

/// A second run of the crossing fibers, in which a body comes in that grips the end of a fiber that was free.
TEST(StartFrom, MayAddBodies) {
  const trame::test::TemporaryFolder folder;
  Scene scene = test::cantilever(FiberModel::enriched, 0.3, 100, 8);
  BodySpec tip = scene.bodies[1], post{"post", {3, 4, 5}, {}};
  scene.bodies[1].ties.clear();
  scene.bodies[1].name = "idle";
  scene.bodies.push_back({"hand", {50, 0, 0}, {}});
  Stage stage;
  stage.name = "turn";
  stage.n_increments = 4;
  stage.drives = {{"wall", BodyDof::rz, DriveMode::displacement, 1.0, ""}};
  scene.stages = {stage};
  SimulateOptions options;
  options.states = folder / "first.h5";
  options.n_threads = 1;
  ASSERT_EQ(simulate(scene, options).status, Status::done);

  Scene more = scene;
  more.bodies.insert(more.bodies.begin(), {post, tip});
  stage.name = "hold";
  stage.drives.clear();
  more.stages.push_back(stage);
  options.start_from = options.states;
  options.after = "turn";
  options.states = folder / "second.h5";
  EXPECT_EQ(check_start(more, options).stage, 1u);
  ASSERT_EQ(simulate(more, options).status, Status::done);
  const SnapshotReader states(options.states);
  const auto& names = states.header().body_names;
  const auto body = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  const Increment start = states.read(1), end = states.read(states.n_increments() - 1);
  EXPECT_LT((start.bodies.position[body("tip")] - start.fibers.r.back()).norm(), 1e-9) << "taken along with the end";
  EXPECT_LT((start.bodies.rotation[body("tip")] - rotation_matrix({0, 0, 1})).norm(), 1e-6);
  EXPECT_EQ(start.bodies.position[body("post")], Vec3(3, 4, 5));
  EXPECT_LT((end.fibers.r.back() - start.fibers.r.back()).norm(), 1e-6) << "nothing pulls";
  EXPECT_LT(end.bodies.force[body("tip")].norm(), 1e-9);

  // One fewer is another scene.
  scene.stages.push_back(stage);
  options.start_from = options.states;
  options.states = folder / "third.h5";
  EXPECT_THROW((void)simulate(scene, options), InputError);
}

}  // namespace
}  // namespace trame::micro
