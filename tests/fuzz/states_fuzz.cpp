// A state file with any numbers in its datasets, which no checksum gives away: states that a run can go on from, or an
// InputError. Damage to the file's own bookkeeping is for the guard of `probe`, since it is HDF5 that stumbles there.

#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "micro/core/error.h"
#include "micro/model/model.h"
#include "micro/run/restart.h"
#include "micro/simulate.h"
#include "tests/fuzz/hdf5_numbers.h"

namespace {

using namespace trame;
using namespace trame::micro;

/// Two fibers of few elements that cross, pressed together in one short stage; a second one is to follow.
Scene two_stages() {
  Scene scene = read_scene(std::filesystem::path(TRAME_DATA_DIR) / "scenes/two_crossing_fibers.toml");
  for (FiberSpec& fiber : scene.fibers) fiber.n_elements = 4;
  scene.stages[0].n_increments = 1;
  scene.stages.emplace_back().name = "hold";
  return scene;
}

struct Good {
  Scene scene = two_stages();
  Scales scales = natural_scales(scene);
  Scene natural = nondimensional(scene, scales);
  Assembly assembly = assemble_scene(natural);
  std::filesystem::path file =
                            std::filesystem::temp_directory_path() / ("trame-fuzz-" + std::to_string(getpid()) + ".h5"),
                        damaged = file.string() + ".damaged";
  std::vector<std::string> datasets;

  Good() {
    std::filesystem::remove(file);
    SimulateOptions options;
    options.states = file;
    options.n_threads = 1;
    if (simulate(scene, options).status != SimulationSummary::Status::done) std::abort();
    const hid_t opened = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    datasets = test::datasets_of(opened);
    H5Fclose(opened);
  }
};

const Good& good_states() {
  static const Good good;
  return good;
}

}  // namespace

/// The simulation is not part of any input's time.
extern "C" int LLVMFuzzerInitialize(int*, char***) {
  (void)good_states();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Good& good = good_states();
  std::filesystem::copy_file(good.file, good.damaged, std::filesystem::copy_options::overwrite_existing);
  const hid_t file = H5Fopen(good.damaged.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  test::put_numbers(file, good.datasets, data, size);
  H5Fclose(file);
  try {
    const SnapshotReader states(good.damaged);
    for (Index i = 0; i < std::min<Index>(states.n_increments(), 10); ++i) (void)states.read(i);
    const Restart restart = restart_after("push", states, good.natural, good.assembly, good.scales);
    StageModel model(good.natural, good.assembly, good.natural.stages[1], restart.start);
    begin_at(model.effects, model.start, 1);
  } catch (const InputError&) {  // what is meant
  }
  return 0;
}
