// A state file with any numbers in its datasets, which no checksum gives away: states that a run can go on from, or an
// InputError. Damage to the file's own bookkeeping is for the guard of `probe`, since it is HDF5 that stumbles there.

#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "micro/core/error.h"
#include "micro/model.h"
#include "micro/restart.h"
#include "micro/simulate.h"

namespace {

using namespace trame;
using namespace trame::micro;

/// Two fibers that cross, pressed together in one short stage; a second one is to follow.
Scene two_stages() {
  Scene scene = read_scene(std::filesystem::path(TRAME_DATA_DIR) / "scenes/two_crossing_fibers.toml");
  scene.stages[0].n_increments = 2;
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
    const auto visit = [](hid_t, const char* name, const H5O_info_t* info, void* list) -> herr_t {
      if (info->type == H5O_TYPE_DATASET) static_cast<std::vector<std::string>*>(list)->emplace_back(name);
      return 0;
    };
    H5Ovisit2(opened, H5_INDEX_NAME, H5_ITER_INC, visit, &datasets, H5O_INFO_BASIC);
    H5Fclose(opened);
  }
};

/// Puts a number of eight bytes in the place of one of a dataset.
void put(hid_t file, const std::string& dataset, std::uint32_t at, const std::uint8_t* bytes) {
  const hid_t set = H5Dopen2(file, dataset.c_str(), H5P_DEFAULT), type = H5Dget_type(set), space = H5Dget_space(set);
  const hssize_t n = H5Sget_simple_extent_npoints(space);
  const H5T_class_t kind = H5Tget_class(type);
  if (n > 0 && (kind == H5T_FLOAT || kind == H5T_INTEGER)) {
    std::vector<double> reals(kind == H5T_FLOAT ? static_cast<std::size_t>(n) : 0);
    std::vector<std::int64_t> integers(kind == H5T_FLOAT ? 0 : static_cast<std::size_t>(n));
    void* values = kind == H5T_FLOAT ? static_cast<void*>(reals.data()) : static_cast<void*>(integers.data());
    const hid_t memory = kind == H5T_FLOAT ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64;
    H5Dread(set, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
    std::memcpy(static_cast<char*>(values) + 8 * (at % static_cast<std::uint32_t>(n)), bytes, 8);
    H5Dwrite(set, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
  }
  H5Sclose(space), H5Tclose(type), H5Dclose(set);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Good good;
  std::filesystem::copy_file(good.file, good.damaged, std::filesystem::copy_options::overwrite_existing);
  const hid_t file = H5Fopen(good.damaged.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  constexpr std::size_t patch = 11;  // dataset, place of two bytes, number
  for (; size >= patch; data += patch, size -= patch)
    put(file, good.datasets[data[0] % good.datasets.size()], data[1] + 256U * data[2], data + 3);
  H5Fclose(file);
  try {
    const SnapshotReader states(good.damaged);
    for (Index i = 0; i < std::min<Index>(states.n_increments(), 10); ++i) (void)states.read(i);
    const Restart restart = restart_after("push", states, good.natural, good.assembly, good.scales);
    const StageModel model(good.natural, good.assembly, good.natural.stages[1], restart.carried);
    begin_at(model.effects, model.start, 1);
  } catch (const InputError&) {  // what is meant
  }
  return 0;
}
