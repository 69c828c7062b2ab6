#include "micro/states/snapshot.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <fstream>
#include <functional>
#include <random>

#include "micro/states/hdf5.h"
#include "tests/support/lattice_yarns.h"
#include "tests/support/temporary_folder.h"

namespace {
/// Writes to files that the process may still do before it ends abruptly; < 0: no limit.
std::atomic<long> writes_left{-1};

/// Writes and requests for room that a disk still grants before it is full; < 0: no limit.
std::atomic<long> writes_granted{-1}, requests_granted{-1};

bool is_granted(std::atomic<long>& granted) {
  const long left = granted.load();
  if (left > 0) granted = left - 1;
  if (left == 0) errno = ENOSPC;
  return left != 0;
}
}  // namespace

/// Stands in front of the system's fallocate, by which room is set aside.
extern "C" int fallocate(int file, int mode, off_t offset, off_t size) {
  using Function = int (*)(int, int, off_t, off_t);
  static const auto next = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "fallocate"));
  const bool asks_for_room = (mode & FALLOC_FL_PUNCH_HOLE) == 0;
  return asks_for_room && !is_granted(requests_granted) ? -1 : next(file, mode, offset, size);
}

/// Stands in front of the system's pwrite, through which HDF5 writes: ends the process at a chosen write. What a kill
/// can leave of that write is its part up to a page boundary.
extern "C" ssize_t pwrite(int file, const void* data, size_t size, off_t offset) {
  using Function = ssize_t (*)(int, const void*, size_t, off_t);
  static const auto next = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "pwrite"));
  if (!is_granted(writes_granted)) return -1;
  const long left = writes_left.load();
  if (left > 0) writes_left = left - 1;
  if (left == 0) {
    const size_t to_page_end = 4096 - static_cast<size_t>(offset) % 4096;
    if (to_page_end < size) next(file, data, to_page_end, offset);
    _exit(9);
  }
  return next(file, data, size, offset);
}

namespace trame::micro {
namespace {

using test::input_error;
using trame::test::TemporaryFolder;

SnapshotHeader sample_header() {
  const test::LatticeYarns yarns{.n_yarns = 2};
  return {"1.2.3", "sample", "# a scene\nname = \"µ\"\n", yarns.mesh(), {"side/warp/start", "side/warp/end"}};
}

/// Increment i with values that are all different, exact in 32 bits where they are stored so, and known from i alone.
Increment sample_increment(Index i, Index n_contacts) {
  Increment increment;
  increment.stage = i < 3 ? "separate" : "relax µ";
  increment.stage_time = 0.1 * i;
  increment.fibers = test::mapped(test::LatticeYarns{.n_yarns = 2}.configuration(),
                                  Mat3(Vec3(1 + 0.1 * i, 1, 1 - 0.01 * i).asDiagonal()));
  for (Index c = 0; c < n_contacts; ++c) {
    const double x = i + c / 32768.0;
    increment.contacts.fiber_a.push_back(c % 24);
    increment.contacts.fiber_b.push_back((c + 1 + i) % 24);
    increment.contacts.s_a.push_back(0.1 * c);
    increment.contacts.s_b.push_back(0.3 * c + i);
    increment.contacts.position.emplace_back(x, 2 * x, 3 * x);
    increment.contacts.normal.emplace_back(0, 0.5, x);
    increment.contacts.gap.push_back(-x);
    increment.contacts.normal_force.push_back(4 * x);
    increment.contacts.friction_force.emplace_back(x, 0, -x);
    increment.contacts.slip.emplace_back(0, x, 0.25);
    increment.contacts.penalty.push_back(8 * x);
    increment.contacts.length.push_back(9 * x);
    increment.contacts.preload.push_back(10 * x);
    increment.contacts.point.push_back(c % 2);
    increment.contacts.stuck.push_back(c % 3 == 0 ? 1 : 0);
    increment.contacts.image_warp.push_back(c % 2);
    increment.contacts.image_weft.push_back(-(c % 3));
  }
  Mat3 rotation;
  rotation << 1, 2, 3, 4, 5, 6, 7, 8, 9 + i;
  increment.bodies = {{Vec3(i, 1, 2), Vec3(3, 4, 5)},       {rotation, Mat3::Identity()},
                      {Vec3(0.1, 0.2, i), Vec3::Zero()},    {Vec3(6, 7, 8), Vec3(-i, 0, 0)},
                      {Vec3(0.5 * i, 1, 0), Vec3(2, 0, i)}, {Vec3(0, 4.0 * i, 1), Vec3(i, 3, 0)}};
  increment.sides = {{0.01 * i, -0.02}, {3.0 * i, 0.25}};
  increment.solver = {11,   12 + i, 13,   14,   1e-5,
                      0.02, 1e-6,   1e-7, 1e-4, {1.5, 2.5, 3.5, 4.5, 5.5 * i, 6.5, {1, 2, 3, 4, 5, 6, 7.5}},
                      0.75, 1};
  return increment;
}

void expect_equal(const SolverRecord& a, const SolverRecord& b) {
  EXPECT_EQ(a.n_newton_iterations, b.n_newton_iterations);
  EXPECT_EQ(a.n_factorizations, b.n_factorizations);
  EXPECT_EQ(a.n_geometry_updates, b.n_geometry_updates);
  EXPECT_EQ(a.n_cuts, b.n_cuts);
  EXPECT_EQ(a.residual, b.residual);
  EXPECT_EQ(a.max_penetration_over_radius, b.max_penetration_over_radius);
  EXPECT_EQ(a.force_imbalance, b.force_imbalance);
  EXPECT_EQ(a.moment_imbalance, b.moment_imbalance);
  EXPECT_EQ(a.proximal, b.proximal);
  EXPECT_EQ(a.seconds, b.seconds);
  EXPECT_EQ(a.unstable, b.unstable);
  EXPECT_EQ(a.energy.external_work, b.energy.external_work);
  EXPECT_EQ(a.energy.stored, b.energy.stored);
  EXPECT_EQ(a.energy.friction, b.energy.friction);
  EXPECT_EQ(a.energy.damping, b.energy.damping);
  EXPECT_EQ(a.energy.imbalance, b.energy.imbalance);
  EXPECT_EQ(a.energy.release, b.energy.release);
  EXPECT_EQ(a.energy.work, b.energy.work);
}

void expect_equal(const Increment& a, const Increment& b) {
  EXPECT_EQ(a.stage, b.stage);
  EXPECT_EQ(a.stage_time, b.stage_time);
  EXPECT_EQ(a.fibers.r, b.fibers.r);
  EXPECT_EQ(a.fibers.g1, b.fibers.g1);
  EXPECT_EQ(a.fibers.g2, b.fibers.g2);
  EXPECT_EQ(a.fibers.tangent, b.fibers.tangent);
  EXPECT_EQ(a.contacts.fiber_a, b.contacts.fiber_a);
  EXPECT_EQ(a.contacts.fiber_b, b.contacts.fiber_b);
  EXPECT_EQ(a.contacts.s_a, b.contacts.s_a);
  EXPECT_EQ(a.contacts.s_b, b.contacts.s_b);
  EXPECT_EQ(a.contacts.position, b.contacts.position);
  EXPECT_EQ(a.contacts.normal, b.contacts.normal);
  EXPECT_EQ(a.contacts.gap, b.contacts.gap);
  EXPECT_EQ(a.contacts.normal_force, b.contacts.normal_force);
  EXPECT_EQ(a.contacts.friction_force, b.contacts.friction_force);
  EXPECT_EQ(a.contacts.slip, b.contacts.slip);
  EXPECT_EQ(a.contacts.penalty, b.contacts.penalty);
  EXPECT_EQ(a.contacts.length, b.contacts.length);
  EXPECT_EQ(a.contacts.preload, b.contacts.preload);
  EXPECT_EQ(a.contacts.point, b.contacts.point);
  EXPECT_EQ(a.contacts.stuck, b.contacts.stuck);
  EXPECT_EQ(a.contacts.image_warp, b.contacts.image_warp);
  EXPECT_EQ(a.contacts.image_weft, b.contacts.image_weft);
  EXPECT_EQ(a.bodies.position, b.bodies.position);
  EXPECT_EQ(a.bodies.rotation, b.bodies.rotation);
  EXPECT_EQ(a.bodies.force, b.bodies.force);
  EXPECT_EQ(a.bodies.moment, b.bodies.moment);
  EXPECT_EQ(a.bodies.motion, b.bodies.motion);
  EXPECT_EQ(a.bodies.turn, b.bodies.turn);
  EXPECT_EQ(a.sides.strain, b.sides.strain);
  EXPECT_EQ(a.sides.force, b.sides.force);
  expect_equal(a.solver, b.solver);
}

/// Contacts of increment i in the round trips: none, few, and more than a chunk of the file holds.
Index sample_n_contacts(Index i) { return i == 2 ? 20000 : i % 2 == 0 ? 0 : 7; }

void write_sample(const std::filesystem::path& file, Index n_increments) {
  SnapshotWriter writer(file, sample_header());
  for (Index i = 0; i < n_increments; ++i) writer.append(sample_increment(i, sample_n_contacts(i)));
}

TEST(Snapshot, HeaderRoundTrip) {
  const TemporaryFolder folder;
  write_sample(folder / "states.h5", 0);
  const SnapshotReader reader(folder / "states.h5");
  const SnapshotHeader expected = sample_header();
  const SnapshotHeader& header = reader.header();
  EXPECT_EQ(reader.n_increments(), 0);
  EXPECT_EQ(header.version, expected.version);
  EXPECT_EQ(header.scene_name, expected.scene_name);
  EXPECT_EQ(header.scene_text, expected.scene_text);
  EXPECT_EQ(header.body_names, expected.body_names);
  EXPECT_EQ(header.mesh.first_node, expected.mesh.first_node);
  EXPECT_EQ(header.mesh.radius, expected.mesh.radius);
  EXPECT_EQ(header.mesh.axial_stiffness, expected.mesh.axial_stiffness);
  EXPECT_EQ(header.mesh.yarn_of_fiber, expected.mesh.yarn_of_fiber);
  EXPECT_EQ(header.mesh.arc_length, expected.mesh.arc_length);
  ASSERT_EQ(header.mesh.yarns.size(), 2u);
  for (int y = 0; y < 2; ++y) {
    EXPECT_EQ(header.mesh.yarns[y].name, expected.mesh.yarns[y].name);
    EXPECT_EQ(header.mesh.yarns[y].family, expected.mesh.yarns[y].family);
    EXPECT_EQ(header.mesh.yarns[y].first_fiber, expected.mesh.yarns[y].first_fiber);
    EXPECT_EQ(header.mesh.yarns[y].n_fibers, expected.mesh.yarns[y].n_fibers);
  }
}

TEST(Snapshot, IncrementsRoundTrip) {
  const TemporaryFolder folder;
  write_sample(folder / "states.h5", 7);
  const SnapshotReader reader(folder / "states.h5");
  ASSERT_EQ(reader.n_increments(), 7);
  for (const Index i : {6, 0, 2, 1, 5, 3, 4}) {
    expect_equal(reader.read(i), sample_increment(i, sample_n_contacts(i)));
    EXPECT_EQ(reader.read_fibers(i).r, sample_increment(i, 0).fibers.r);
  }
}

TEST(Snapshot, SceneWithoutBodiesOrYarns) {
  const TemporaryFolder folder;
  SnapshotHeader header;
  header.mesh.first_node = {0, 3};
  header.mesh.radius = {1e-5};
  header.mesh.axial_stiffness = {2.0};
  header.mesh.yarn_of_fiber = {0};
  header.mesh.arc_length = {0, 1e-3, 2e-3};
  header.mesh.yarns = {{"single", YarnFamily::free, 0, 1}};
  Increment increment;
  increment.fibers.resize(3);
  for (int n = 0; n < 3; ++n) increment.fibers.r[n] = Vec3(1e-3 * n, 0, 0);
  SnapshotWriter(folder / "states.h5", header).append(increment);
  const SnapshotReader reader(folder / "states.h5");
  EXPECT_EQ(reader.read(0).fibers.r, increment.fibers.r);
  EXPECT_TRUE(reader.read(0).bodies.position.empty());
  EXPECT_EQ(reader.header().scene_text, "");
}

TEST(Snapshot, ContactQuantitiesKeepSevenDigits) {
  const TemporaryFolder folder;
  Increment increment = sample_increment(1, 1);
  increment.contacts.gap = {-1.23456789e-8};
  SnapshotWriter(folder / "states.h5", sample_header()).append(increment);
  EXPECT_NEAR(SnapshotReader(folder / "states.h5").read(0).contacts.gap[0], -1.23456789e-8, 1e-15);
}

TEST(Snapshot, ReadableWhileTheRunGoesOn) {
  const TemporaryFolder folder;
  SnapshotWriter writer(folder / "states.h5", sample_header());
  for (Index i = 0; i < 4; ++i) {
    writer.append(sample_increment(i, sample_n_contacts(i)));
    int status = -1;
    if (const pid_t child = fork(); child == 0) {  // another program, without this one's open file
      const SnapshotReader reader(folder / "states.h5");
      const bool ok = reader.n_increments() == i + 1 && reader.read(i).fibers.r == sample_increment(i, 0).fibers.r;
      _exit(ok ? 0 : 1);
    } else {
      waitpid(child, &status, 0);
    }
    EXPECT_EQ(status, 0) << "after increment " << i;
  }
}

TEST(Snapshot, WriterRefusesExistingFileMissingFolderAndOddArrays) {
  const TemporaryFolder folder;
  write_sample(folder / "states.h5", 1);
  EXPECT_NE(input_error([&] { SnapshotWriter(folder / "states.h5", sample_header()); }).find("exists already"),
            std::string::npos);
  EXPECT_NE(input_error([&] { SnapshotWriter(folder / "no/states.h5", sample_header()); }).find("cannot be created"),
            std::string::npos);
  SnapshotWriter writer(folder / "other.h5", sample_header());
  Increment increment = sample_increment(0, 3);
  increment.contacts.gap.pop_back();
  EXPECT_THROW(writer.append(increment), std::invalid_argument);
  increment = sample_increment(0, 3);
  increment.fibers.g2.pop_back();
  EXPECT_THROW(writer.append(increment), std::invalid_argument);
  increment = sample_increment(0, 3);
  increment.stage = std::string(129, 's');
  EXPECT_THROW(writer.append(increment), InputError);
}

TEST(Snapshot, ReaderRefusesIncrementsOutOfRange) {
  const TemporaryFolder folder;
  write_sample(folder / "states.h5", 2);
  const SnapshotReader reader(folder / "states.h5");
  EXPECT_NE(input_error([&] { (void)reader.read(2); }).find("no increment 2: it holds 2"), std::string::npos);
  EXPECT_THROW((void)reader.read_fibers(-1), InputError);
}

// ---- interrupted runs ---------------------------------------------------------------------------------------------

/// Everything that the file counts must be what was written.
void expect_intact(const std::filesystem::path& file, Index n_at_least) {
  const SnapshotReader reader(file);
  EXPECT_GE(reader.n_increments(), n_at_least);
  for (Index i = 0; i < reader.n_increments(); ++i)
    expect_equal(reader.read(i), sample_increment(i, sample_n_contacts(i)));
}

/// What is thrown as WriteError by `action`; empty where nothing is.
std::string write_error(const std::function<void()>& action) {
  try {
    action();
  } catch (const WriteError& error) {
    return error.what();
  }
  return {};
}

// ---- full disks ---------------------------------------------------------------------------------------------------

TEST(FullDisk, IsNoticedBeforeAnythingIsWritten) {
  const TemporaryFolder folder;
  const auto file = folder / "states.h5";
  {
    SnapshotWriter writer(file, sample_header());
    for (Index i = 0; i < 3; ++i) writer.append(sample_increment(i, sample_n_contacts(i)));
    requests_granted = 0;
    const std::string message = write_error([&] { writer.append(sample_increment(3, 7)); });
    requests_granted = -1;
    EXPECT_NE(message.find(file.string()), std::string::npos) << message;
    EXPECT_NE(message.find("No space left on device; the first 3 states are whole in it"), std::string::npos)
        << message;
    EXPECT_EQ(write_error([&] { writer.append(sample_increment(3, 7)); }), "") << "there is room again";
  }
  expect_intact(file, 4);
}

TEST(FullDisk, LeavesNoFileWithoutAState) {
  const TemporaryFolder folder;
  const auto file = folder / "states.h5";
  for (const long granted : {0L, 1L}) {  // of the header, of the first state
    requests_granted = granted;
    const std::string message =
        write_error([&] { SnapshotWriter(file, sample_header()).append(sample_increment(0, 0)); });
    requests_granted = -1;
    EXPECT_NE(message.find("nothing is saved"), std::string::npos) << message;
    EXPECT_FALSE(std::filesystem::exists(file));
  }
}

/// Where room cannot be set aside, a disk can be full amid the library's bookkeeping: in a process of its own, which
/// must end as it means to, with nothing said by the library, and leave every state that it has counted.
TEST(FullDisk, AmidAWriteLosesNothingThatWasCounted) {
  int n_failed = 0;
  for (long granted = 0; granted < 150; granted += 7) {
    const TemporaryFolder folder;
    const auto file = folder / "states.h5", said = folder / "stderr.txt";
    const pid_t child = fork();
    if (child == 0) {
      dup2(open(said.c_str(), O_WRONLY | O_CREAT, 0600), STDERR_FILENO);
      Index n_saved = 0;
      const std::string message = write_error([&] {
        SnapshotWriter writer(file, sample_header());
        for (; n_saved < 6; ++n_saved) {
          if (n_saved == 2) writes_granted = granted;
          writer.append(sample_increment(n_saved, sample_n_contacts(n_saved)));
        }
      });
      exit(message.empty() ? 100 : n_saved);
    }
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFEXITED(status)) << "signal " << WTERMSIG(status) << " after " << granted << " writes";
    EXPECT_EQ(std::filesystem::file_size(said), 0U) << granted;
    n_failed += WEXITSTATUS(status) < 100 ? 1 : 0;
    EXPECT_NO_THROW(expect_intact(file, std::min(WEXITSTATUS(status), 6))) << granted;
  }
  EXPECT_GT(n_failed, 10);
}

TEST(FullDisk, LimitsOfFilesAreNamed) {
  const TemporaryFolder folder;
  const auto file = folder / "states.h5";
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1'000'000, 1'000'000};
    setrlimit(RLIMIT_FSIZE, &limit);
    const std::string message = write_error([&] {
      SnapshotWriter writer(file, sample_header());
      for (Index i = 0; i < 1000; ++i) writer.append(sample_increment(i, 7));
    });
    exit(message.find("ulimit -f") != std::string::npos ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_GT(SnapshotReader(file).n_increments(), 0);
}

TEST(Snapshot, WriterNoticesThatItsFileIsGone) {
  const TemporaryFolder folder;
  const auto file = folder / "states.h5";
  SnapshotWriter writer(file, sample_header());
  writer.append(sample_increment(0, 0));
  std::filesystem::remove(file);
  const auto append = [&] { writer.append(sample_increment(1, 7)); };
  EXPECT_NE(write_error(append).find("was removed or replaced"), std::string::npos);
  std::ofstream(file) << "another";
  EXPECT_NE(write_error(append).find("was removed or replaced"), std::string::npos);
}

/// Runs `n_increments` appends in a process that tells the number of finished ones through a pipe, and ends at the
/// `n_writes`-th write after increment `first_at_risk` has begun (< 0: not at all). Returns the number of finished
/// appends, and whether the process ended early.
std::pair<Index, bool> run_until_write(const std::filesystem::path& file, Index first_at_risk, Index n_increments,
                                       long n_writes) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("pipe");
  const pid_t child = fork();
  if (child == 0) {
    SnapshotWriter writer(file, sample_header());
    for (Index i = 0; i < n_increments; ++i) {
      if (i == first_at_risk) writes_left = n_writes;
      writer.append(sample_increment(i, sample_n_contacts(i)));
      if (write(ends[1], "+", 1) != 1) _exit(1);
    }
    _exit(0);
  }
  close(ends[1]);
  Index n_done = 0;
  for (char sign; read(ends[0], &sign, 1) == 1;) ++n_done;
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  return {n_done, WEXITSTATUS(status) == 9};
}

/// Ends a run at each of its writes in turn, from increment `first_at_risk` on. Returns how many there were.
Index check_every_write(Index first_at_risk, Index n_increments) {
  const TemporaryFolder folder;
  const auto file = folder / "states.h5";
  for (Index n_writes = 0;; ++n_writes) {
    std::filesystem::remove(file);
    const auto [n_done, ended_early] = run_until_write(file, first_at_risk, n_increments, n_writes);
    EXPECT_NO_THROW(expect_intact(file, n_done)) << "ended at write " << n_writes;
    if (!ended_early || ::testing::Test::HasFailure()) return n_writes;
  }
}

TEST(Snapshot, EveryWriteOfTheFirstIncrementsMayBeTheLast) {
  EXPECT_GT(check_every_write(0, 4), 4 * 20) << "each increment takes many writes";
}

/// The library's index of where increments are stored takes another form at the 21st.
TEST(Snapshot, EveryWriteOfALaterIncrementMayBeTheLast) { EXPECT_GT(check_every_write(20, 21), 20); }

TEST(Snapshot, KilledAtRandomMoments) {
  const TemporaryFolder folder;
  std::mt19937 random(7);
  for (int round = 0; round < 20; ++round) {
    const auto file = folder / "states.h5";
    std::filesystem::remove(file);
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    const pid_t child = fork();
    if (child == 0) {
      SnapshotWriter writer(file, sample_header());
      for (Index i = 0;; ++i) {
        writer.append(sample_increment(i, sample_n_contacts(i)));
        if (write(ends[1], "+", 1) != 1) _exit(1);
      }
    }
    close(ends[1]);
    Index n_done = 0;
    char sign;
    for (const Index wanted = 1 + random() % 8; n_done < wanted && read(ends[0], &sign, 1) == 1;) ++n_done;
    usleep(random() % 20000);
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    while (read(ends[0], &sign, 1) == 1) ++n_done;
    close(ends[0]);
    ASSERT_NO_THROW(expect_intact(file, n_done)) << "round " << round;
  }
}

// ---- hostile files ------------------------------------------------------------------------------------------------

class HostileFile : public ::testing::Test {
 protected:
  HostileFile() { write_sample(file_, 3); }

  /// What reading everything complains about.
  std::string complaint() const {
    return input_error([&] {
      const SnapshotReader reader(file_);
      for (Index i = 0; i < reader.n_increments(); ++i) (void)reader.read(i);
    });
  }
  void expect_complaint(const std::string& part) const {
    const std::string message = complaint();
    EXPECT_NE(message.find(part), std::string::npos) << "message: " << message;
    EXPECT_NE(message.find(file_.string()), std::string::npos) << "message names the file: " << message;
  }
  template <class Change>
  void change(Change&& change) const {
    const hid_t file = H5Fopen(file_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    ASSERT_GE(file, 0);
    change(file);
    H5Fclose(file);
  }
  void remove_dataset(const char* path) const {
    change([&](hid_t file) { H5Ldelete(file, path, H5P_DEFAULT); });
  }
  /// Puts a dataset of `values` in the place of `path`.
  void replace(const char* path, const std::vector<int>& values) const {
    change([&](hid_t file) {
      H5Ldelete(file, path, H5P_DEFAULT);
      const hsize_t size = values.size();
      const hid_t space = H5Screate_simple(1, &size, nullptr);
      const hid_t set = H5Dcreate2(file, path, H5T_STD_I32LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
      H5Dwrite(set, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
      H5Dclose(set);
      H5Sclose(space);
    });
  }
  void write_first(const char* path, hid_t type, const void* values, std::vector<hsize_t> count) const {
    change([&](hid_t file) {
      const hid_t set = H5Dopen2(file, path, H5P_DEFAULT), space = H5Dget_space(set);
      const std::vector<hsize_t> start(count.size(), 0);
      H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr);
      const hid_t memory = H5Screate_simple(int(count.size()), count.data(), nullptr);
      EXPECT_GE(H5Dwrite(set, type, memory, space, H5P_DEFAULT, values), 0);
      H5Sclose(memory);
      H5Sclose(space);
      H5Dclose(set);
    });
  }
  void replace_content(const std::string& content) const { std::ofstream(file_, std::ios::binary) << content; }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "states.h5";
};

TEST_F(HostileFile, AGoodOneHasNoComplaint) { EXPECT_EQ(complaint(), ""); }

TEST_F(HostileFile, Missing) {
  std::filesystem::remove(file_);
  expect_complaint("no such file");
}

TEST_F(HostileFile, AFolder) {
  std::filesystem::remove(file_);
  std::filesystem::create_directory(file_);
  expect_complaint("not a file");
}

TEST_F(HostileFile, Empty) {
  replace_content("");
  expect_complaint("not an HDF5 file");
}

TEST_F(HostileFile, NotHdf5) {
  replace_content("stage,force\nrelax,1.0\n");
  expect_complaint("not an HDF5 file");
}

TEST_F(HostileFile, OnlyTheSignature) {
  replace_content("\x89HDF\r\n\x1a\n");
  expect_complaint("truncated or damaged");
}

TEST_F(HostileFile, TruncatedAnywhere) {
  const auto size = std::filesystem::file_size(file_);
  for (const double part : {0.9999, 0.9, 0.5, 0.1, 0.01}) {
    std::filesystem::resize_file(file_, static_cast<std::uintmax_t>(part * double(size)));
    expect_complaint("truncated or damaged");
  }
}

TEST_F(HostileFile, TruncatedAfterAnInterruptedRun) {
  std::filesystem::remove(file_);
  ASSERT_EQ(run_until_write(file_, 0, 3, -1).first, 3);
  ASSERT_EQ(complaint(), "");
  // A page: less of the last one may be room that nothing stands in yet.
  std::filesystem::resize_file(file_, std::filesystem::file_size(file_) - 4096);
  EXPECT_NE(complaint(), "");
}

TEST_F(HostileFile, ForeignHdf5) {
  std::filesystem::remove(file_);
  H5Fclose(H5Fcreate(file_.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, H5P_DEFAULT));
  expect_complaint("not a state file");
}

TEST_F(HostileFile, OtherLayoutVersion) {
  change([&](hid_t file) {
    const hid_t attribute = H5Aopen(file, "layout_version", H5P_DEFAULT);
    const int next = 4;
    H5Awrite(attribute, H5T_NATIVE_INT, &next);
    H5Aclose(attribute);
  });
  expect_complaint("layout_version 4; this program reads versions 2 to 3");
}

TEST_F(HostileFile, OlderFileSaysNothingOfStability) {
  remove_dataset("solver/unstable");
  EXPECT_EQ(complaint(), "");
  EXPECT_EQ(SnapshotReader(file_).read(0).solver.unstable, 0);
}

/// A file that leads to others, made while the library still knows such links: before any test.
const std::string leading_elsewhere = [] {
  H5dont_atexit();  // as our programs have it, which begin with our code
  const TemporaryFolder folder;
  const auto path = folder / "links.h5";
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, H5P_DEFAULT);
  H5Lcreate_external("/etc/passwd", "/x", file, "external", H5P_DEFAULT, H5P_DEFAULT);
  H5Lcreate_soft("/external", file, "soft", H5P_DEFAULT, H5P_DEFAULT);
  const hsize_t size = 4;
  const hid_t space = H5Screate_simple(1, &size, nullptr), raw = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_external(raw, "/etc/passwd", 0, size * 4);
  H5Dclose(H5Dcreate2(file, "raw", H5T_STD_I32LE, space, H5P_DEFAULT, raw, H5P_DEFAULT));
  const hid_t mapped = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_virtual(mapped, space, "/etc/passwd", "/x", space);
  H5Dclose(H5Dcreate2(file, "virtual", H5T_STD_I32LE, space, H5P_DEFAULT, mapped, H5P_DEFAULT));
  H5Pclose(mapped), H5Pclose(raw), H5Sclose(space), H5Fclose(file);
  std::ifstream stream(path, std::ios::binary);
  return std::string{std::istreambuf_iterator<char>(stream), {}};
}();

TEST(HdfLinks, OutOfAFileAreNotFollowed) {
  const TemporaryFolder folder;
  const auto path = folder / "links.h5";
  std::ofstream(path, std::ios::binary) << leading_elsewhere;
  const hdf5::Quiet quiet;
  const hdf5::Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, hdf5::file_access()));
  ASSERT_TRUE(file.valid());
  const auto why_not = [&](const char* dataset) {
    std::string why;
    const bool opened = hdf5::open_dataset(file, dataset, why).valid();
    return opened ? std::string("opened") : why;
  };
  EXPECT_EQ(why_not("external"), "is a link to another file, which is not followed");
  EXPECT_EQ(why_not("external/below"), "is a link to another file, which is not followed");
  EXPECT_EQ(why_not("soft"), "is missing");
  EXPECT_EQ(why_not("raw"), "keeps its data in another file, which is not followed");
  EXPECT_EQ(why_not("virtual"), "is put together from other files, which is not followed");
  EXPECT_LT(H5Dopen2(file, "external", H5P_DEFAULT), 0) << "whoever opens it";
}

TEST_F(HostileFile, MissingDatasets) {
  for (const char* path : {"energy/stored", "fibers/g1", "n_increments", "mesh/radius"}) {
    remove_dataset(path);
    expect_complaint(std::string("dataset ") + path + " is missing");
  }
}

TEST_F(HostileFile, OddShapes) {
  replace("fibers/r", {1, 2, 3});
  expect_complaint("dataset fibers/r has size (3), expected (1 x 264 x 3)");
  replace("mesh/yarn_of_fiber", {0, 1, 1});
  expect_complaint("dataset mesh/yarn_of_fiber has 3 entries, expected 24");
}

TEST_F(HostileFile, OtherType) {
  replace("stage", {1, 2, 3});
  expect_complaint("dataset stage has another type");
}

TEST_F(HostileFile, FiberWithAnEvenNumberOfNodes) {
  replace("mesh/first_node", {0, 4});
  expect_complaint("dataset mesh/first_node gives fiber 0 4 nodes");
}

TEST_F(HostileFile, YarnIndexOutOfRange) {
  replace("mesh/yarn_of_fiber", std::vector<int>(24, 2));
  expect_complaint("dataset mesh/yarn_of_fiber holds 2, allowed 0 … 1");
}

TEST_F(HostileFile, ContactWithAFiberThatIsNotThere) {
  const int fiber = 24;
  write_first("contacts/fiber_b", H5T_NATIVE_INT, &fiber, {1});
  expect_complaint("contacts of increment 1 name fiber 24, allowed 0 … 23");
}

TEST_F(HostileFile, MoreIncrementsCountedThanStored) {
  change([&](hid_t file) {
    const hid_t set = H5Dopen2(file, "n_increments", H5P_DEFAULT);
    const int count = 4;
    H5Dwrite(set, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, &count);
    H5Dclose(set);
  });
  expect_complaint("has size (3), expected (4");
}

TEST_F(HostileFile, PositionsThatAreNotNumbers) {
  const double nan = std::nan("");
  write_first("fibers/r", H5T_NATIVE_DOUBLE, &nan, {1, 1, 1});
  expect_complaint("fibers/r of increment 0 holds values that are not finite");
}

TEST_F(HostileFile, FlippedBitsInStoredNumbers) {
  haddr_t offset = 0;
  hsize_t size = 0;
  change([&](hid_t file) {
    const hid_t set = H5Dopen2(file, "fibers/g2", H5P_DEFAULT), space = H5Dget_space(set);
    EXPECT_GE(H5Dget_chunk_info(set, space, 1, nullptr, nullptr, &offset, &size), 0);
    H5Sclose(space);
    H5Dclose(set);
  });
  std::fstream stream(file_, std::ios::in | std::ios::out | std::ios::binary);
  stream.seekp(static_cast<std::streamoff>(offset + size / 2));
  stream << "????";
  stream.close();
  expect_complaint("dataset fibers/g2 is damaged");
}

}  // namespace
}  // namespace trame::micro
