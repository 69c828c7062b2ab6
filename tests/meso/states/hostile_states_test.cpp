/// States that are damaged or made to harm: whatever is in a file, reading and analysing it ends with results or with
/// an error that names it; no crash, no other exception, no endless loop, no huge memory.

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <climits>
#include <functional>
#include <memory>
#include <numeric>
#include <random>

#include "meso/comparison.h"
#include "tests/support/fiber_files.h"
#include "tests/support/lattice_yarns.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/text_file.h"
#include "workflows/strains/fiber_nodes.h"

namespace trame::workflows {
namespace {

using micro::test::LatticeYarns;
using micro::test::mapped;
using test::Hdf5File;
using test::read_text;
using test::write_text;
using trame::test::TemporaryFolder;
namespace fs = std::filesystem;
using Files = std::vector<fs::path>;

void read_all(const Files& files) {
  const auto states = open_states(files);
  for (Index i = 0; i < states->n_increments(); ++i) (void)states->read(i);
}

/// What strain_post does with the second of three states and the last.
void analyse_all(const Files& files) {
  const auto states = open_states(files);
  if (states->n_increments() == 0) return;
  const Index last = states->n_increments() - 1, from = std::min<Index>(1, last);
  const meso::YarnComparer comparer(*states, {.n_stations = 2, .n_threads = 1});
  (void)comparer.compare({from, last});
}

/// Exit codes of a process; 1 is that of the sanitizers.
enum class End { done = 0, refused = 2, failed = 3 };

/// How `action` ends. Where it throws anything but what strain_post tells a user, or an InputError that does not name
/// the file, it has failed.
End end_of(const Files& files, const std::function<void(const Files&)>& action, std::string& why) {
  try {
    action(files);
    return End::done;
  } catch (const InputError& error) {
    why = error.what();
    return why.find(files[0].parent_path().string()) != std::string::npos ? End::refused : End::failed;
  } catch (const std::exception& error) {
    why = error.what();
  }
  return End::failed;
}

/// The same in a process of its own, as it may crash.
End end_apart(const Files& files, const std::function<void(const Files&)>& action) {
  const pid_t child = fork();
  if (child == 0) {
    const rlimit seconds{100, 100};  // of computing; more than the guard allows
    setrlimit(RLIMIT_CPU, &seconds);
    std::string why;
    const End end = end_of(files, action, why);
    if (end == End::failed) fprintf(stderr, "%s\n", why.c_str());
    _exit(static_cast<int>(end));
  }
  int status = 0;
  waitpid(child, &status, 0);
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return code == 0 || code == 2 ? static_cast<End>(code) : End::failed;
}

/// A run of two yarns in three states, with bodies and contacts.
void write_run(const fs::path& file) {
  const LatticeYarns yarns{.n_yarns = 2, .n_elements = 3};
  micro::SnapshotWriter writer(file, {"1", "scene", "title = \"t\"", yarns.mesh(), {"left", "right"}});
  for (int i = 0; i < 3; ++i) {
    micro::Increment state;
    state.stage = "pull";
    state.fibers = mapped(yarns.configuration(), Vec3(1 + 0.01 * i, 1, 1).asDiagonal());
    state.bodies.position = state.bodies.force = state.bodies.moment = {Vec3::Zero(), Vec3::UnitX()};
    state.bodies.rotation = {Mat3::Identity(), Mat3::Identity()};
    micro::ContactRecord& contacts = state.contacts;
    contacts.fiber_a = {0, 1}, contacts.fiber_b = {5, 6};
    contacts.point = contacts.stuck = contacts.image_warp = contacts.image_weft = {0, 1};
    for (auto* values :
         {&contacts.s_a, &contacts.s_b, &contacts.gap, &contacts.normal_force, &contacts.penalty, &contacts.length,
          &contacts.preload})
      *values = {0.1, 0.2};
    for (auto* values : {&contacts.position, &contacts.normal, &contacts.friction_force, &contacts.slip})
      *values = {Vec3::UnitX(), Vec3::UnitY()};
    writer.append(state);
  }
}

/// The same fibers in the layout for nodes from elsewhere.
void write_nodes(const fs::path& file) {
  const LatticeYarns yarns{.n_yarns = 2, .n_elements = 3};
  const micro::FiberMesh mesh = yarns.mesh();
  Hdf5File nodes(file);
  nodes.put("fibers/start", std::vector<int>(mesh.first_node.begin(), mesh.first_node.end()));
  nodes.put("fibers/yarn", std::vector<int>(mesh.yarn_of_fiber.begin(), mesh.yarn_of_fiber.end()));
  nodes.put("fibers/radius", mesh.radius);
  nodes.put("yarns/name", std::vector<const char*>{"a", "b"});
  nodes.put("yarns/family", std::vector<int>{0, 1});
  for (int i = 0; i < 3; ++i) {
    const std::string path = "increments/" + std::to_string(i) + "/";
    const auto fibers = mapped(yarns.configuration(), Vec3(1 + 0.01 * i, 1, 1).asDiagonal());
    nodes.put(path + "position", fibers.r);
    nodes.put(path + "tangent", fibers.tangent);
    nodes.put(path + "stage_time", std::vector<double>{0.5});
    nodes.put_fixed(path + "stage", "pull");
  }
}

/// And as polylines.
void write_lines(const fs::path& file, double stretch) {
  const LatticeYarns yarns{.n_yarns = 2, .n_elements = 3};
  const micro::FiberMesh mesh = yarns.mesh();
  test::write_vtp(file, test::polylines(mapped(yarns.configuration(), Vec3(stretch, 1, 1).asDiagonal()).r,
                                        mesh.first_node, {mesh.yarn_of_fiber.begin(), mesh.yarn_of_fiber.end()}));
}

std::vector<std::string> dataset_paths(const fs::path& file) {
  std::vector<std::string> paths;
  const auto visit = [](hid_t, const char* name, const H5O_info_t* info, void* list) -> herr_t {
    if (info->type == H5O_TYPE_DATASET) static_cast<std::vector<std::string>*>(list)->emplace_back(name);
    return 0;
  };
  const Hdf5File opened(file);
  H5Ovisit(opened.id(), H5_INDEX_NAME, H5_ITER_INC, visit, &paths);
  return paths;
}

/// Largest resident memory that any process of `end_apart` had so far, in bytes.
std::int64_t peak_memory() {
  rusage used{};
  getrusage(RUSAGE_CHILDREN, &used);
  return 1024 * static_cast<std::int64_t>(used.ru_maxrss);
}

/// The program takes 150 MB before it reads anything.
constexpr std::int64_t most_memory = 600'000'000;

/// A way to spoil one dataset.
using Spoil = std::function<void(Hdf5File&, const std::string& path)>;

/// Other shapes and types in the place of a dataset.
std::vector<Spoil> other_shapes() {
  const std::vector<double> numbers = {1, 2, 3};
  return {
      [](Hdf5File& file, const std::string& path) { file.remove(path); },
      [](Hdf5File& file, const std::string& path) { file.put(path, std::vector<int>()); },
      [](Hdf5File& file, const std::string& path) {
        file.put(path, std::vector<int>{-1, 0, INT_MAX});
      },
      [=](Hdf5File& file, const std::string& path) { file.put(path, numbers); },
      [=](Hdf5File& file, const std::string& path) {
        file.put(path, H5T_IEEE_F64LE, {}, H5T_NATIVE_DOUBLE, numbers.data());
      },
      [](Hdf5File& file, const std::string& path) { file.put(path, std::vector<Vec3>(3, Vec3::Ones())); },
      [](Hdf5File& file, const std::string& path) {
        file.put(path, H5T_IEEE_F64LE, {2, 2, 2, 2, 2}, H5T_NATIVE_DOUBLE, nullptr);
      },
      [](Hdf5File& file, const std::string& path) {
        file.put(path, std::vector<const char*>{"a", "b", "c"});
      },
      [](Hdf5File& file, const std::string& path) { file.put_fixed(path, "text\x01\xff"); },
      // Sizes that are claimed, with nothing stored.
      [](Hdf5File& file, const std::string& path) {
        file.put(path, H5T_STD_I32LE, {hsize_t(1) << 28}, H5T_NATIVE_INT, nullptr);
      },
      [](Hdf5File& file, const std::string& path) {
        file.put(path, H5T_IEEE_F64LE, {3, hsize_t(1) << 28, 3}, H5T_NATIVE_DOUBLE, nullptr);
      },
      [](Hdf5File& file, const std::string& path) {
        file.put(path, H5T_IEEE_F64LE, {hsize_t(1) << 28, 3}, H5T_NATIVE_DOUBLE, nullptr);
      },
  };
}

/// Replaces the numbers that `where` (index, number of all) chooses.
void spoil_numbers(Hdf5File& file, const std::string& path, double value,
                   const std::function<bool(hssize_t, hssize_t)>& where) {
  const hid_t set = H5Dopen2(file.id(), path.c_str(), H5P_DEFAULT);
  const hid_t type = H5Dget_type(set), space = H5Dget_space(set);
  const hssize_t n = H5Sget_simple_extent_npoints(space);
  if (H5Tget_class(type) == H5T_FLOAT || H5Tget_class(type) == H5T_INTEGER) {
    std::vector<double> values(static_cast<std::size_t>(n));
    H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    for (hssize_t i = 0; i < n; ++i)
      if (where(i, n)) values[static_cast<std::size_t>(i)] = value;
    H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  }
  H5Sclose(space);
  H5Tclose(type);
  H5Dclose(set);
}

/// Numbers that cannot be: everywhere, first, in the middle, and at random. HDF5 turns those beyond the range of an
/// integer into its ends.
std::vector<Spoil> other_numbers() {
  std::vector<Spoil> spoils;
  auto random = std::make_shared<std::mt19937>(1);
  const std::vector<std::function<bool(hssize_t, hssize_t)>> places = {
      [](hssize_t, hssize_t) { return true; }, [](hssize_t i, hssize_t) { return i == 0; },
      [](hssize_t i, hssize_t n) { return i == n / 2; },
      [random](hssize_t, hssize_t) { return (*random)() % 10 == 0; }};
  for (const double value : {std::nan(""), double(INFINITY), -1e300, 1e300, 1e150, 1e9, 1e3, 1.0, 1e-300, 0.0, -1.0})
    for (const auto& where : places)
      spoils.emplace_back([=](Hdf5File& file, const std::string& path) { spoil_numbers(file, path, value, where); });
  return spoils;
}

class HostileStates : public ::testing::TestWithParam<void (*)(const fs::path&)> {
 protected:
  HostileStates() { GetParam()(file_); }

  /// Spoils every dataset, one at a time, in `n` of the ways; returns how many of the files were refused.
  int spoil_all(const std::vector<Spoil>& spoils, std::size_t n) const {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // sizes that cannot be written are among them
    const std::string good = read_text(file_);
    int n_refused = 0;
    for (const std::string& path : dataset_paths(file_)) {
      std::vector<std::size_t> ways(spoils.size());
      std::iota(ways.begin(), ways.end(), std::size_t(0));
      std::shuffle(ways.begin(), ways.end(), std::mt19937(static_cast<unsigned>(path.size())));
      for (std::size_t k = 0; k < std::min(n, ways.size()); ++k) {
        write_text(file_, good);
        {
          Hdf5File file(file_);
          spoils[ways[k]](file, path);
        }
        const End end = end_apart({file_}, is_analysed(path) ? analyse_all : read_all);
        EXPECT_NE(end, End::failed) << path << ", way " << ways[k];
        n_refused += end == End::refused ? 1 : 0;
      }
    }
    return n_refused;
  }
  /// What is only read need not be analysed.
  static bool is_analysed(const std::string& path) {
    const auto in = [&](const char* folder) { return path.rfind(folder, 0) == 0; };
    return !in("bodies/") && !in("contacts/") && !in("energy/") && !in("solver/") && !in("scene/");
  }

  TemporaryFolder folder_;
  fs::path file_ = folder_ / "states.h5";
};

TEST_P(HostileStates, AGoodFileIsAnalysed) { EXPECT_EQ(end_apart({file_}, analyse_all), End::done); }

TEST_P(HostileStates, EveryDatasetOfAnotherShapeOrType) {
  EXPECT_GT(spoil_all(other_shapes(), 3), 20);
  EXPECT_LT(peak_memory(), most_memory) << "claims of gigabytes must be refused before memory is taken";
}

TEST_P(HostileStates, EveryDatasetWithNumbersThatCannotBe) {
  EXPECT_GT(spoil_all(other_numbers(), 3), 5);
  EXPECT_LT(peak_memory(), most_memory);
}

class HostileStatesStudy : public HostileStates {};

TEST_P(HostileStatesStudy, EveryDatasetInEveryWay) {
  EXPECT_GT(spoil_all(other_shapes(), 1000) + spoil_all(other_numbers(), 1000), 100);
  EXPECT_LT(peak_memory(), most_memory);
}

std::string kind(const ::testing::TestParamInfo<void (*)(const fs::path&)>& info) {
  return info.index == 0 ? "Run" : "Nodes";
}
INSTANTIATE_TEST_SUITE_P(, HostileStates, ::testing::Values(&write_run, &write_nodes), kind);
INSTANTIATE_TEST_SUITE_P(, HostileStatesStudy, ::testing::Values(&write_run, &write_nodes), kind);

/// The way of strain_post: what the library may do to a process, the guard finds out first.
void analyse_guarded(const Files& files) {
  probe_states(files, [](const meso::FiberStates& states) {
    std::vector<Index> all(static_cast<std::size_t>(states.n_increments()));
    std::iota(all.begin(), all.end(), 0);
    return all;
  });
  analyse_all(files);
}

/// Writes `n` damaged versions of the last of `files`, each with some bytes of another value or its end cut off.
void damage(const Files& files, int n, unsigned seed) {
  const std::string good = read_text(files.back());
  std::mt19937 random(seed);
  for (int k = 0; k < n; ++k) {
    std::string bad = good;
    const std::size_t range = k % 2 == 0 ? bad.size() : std::min<std::size_t>(bad.size(), 4096);
    for (int i = 0; i < 1 << k % 4; ++i) bad[random() % range] = static_cast<char>(random());
    if (k % 8 == 7) bad.resize(random() % bad.size());
    write_text(files.back(), bad);
    EXPECT_NE(end_apart(files, analyse_guarded), End::failed) << "damaged file " << k;
  }
}

void damage_all_kinds(int n) {
  const TemporaryFolder folder;
  write_run(folder / "run.h5");
  write_nodes(folder / "nodes.h5");
  write_lines(folder / "0.vtp", 1);
  write_lines(folder / "1.vtp", 1.02);
  damage({folder / "run.h5"}, n, 1);
  damage({folder / "nodes.h5"}, n, 2);
  damage({folder / "0.vtp", folder / "1.vtp"}, n, 3);
}

TEST(DamagedStates, AreRefusedOrAnalysed) { damage_all_kinds(24); }
TEST(DamagedStatesStudy, AreRefusedOrAnalysed) { damage_all_kinds(1500); }

}  // namespace
}  // namespace trame::workflows
