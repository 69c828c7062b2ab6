// An HDF5 file of fiber nodes with any numbers in its datasets, of which some may be missing or of other sizes and
// types: the first two bytes say which, patches of numbers follow.

#include "tests/fuzz/nodes_fuzz.h"

#include "tests/fuzz/hdf5_numbers.h"
#include "tests/support/fiber_files.h"

namespace {

using namespace trame;
using test::Hdf5File;

const std::vector<Index> start = {0, 3, 5, 9};
const std::vector<Vec3> straight = {{0, 0, 0}, {1, 0, 0}, {3, 0, 0}, {0, 5, 0}, {2, 5, 0},
                                    {0, 1, 0}, {2, 1, 0}, {3, 1, 0}, {7, 1, 0}};

void write_good(Hdf5File& file) {
  file.put("fibers/start", std::vector<int>(start.begin(), start.end()));
  file.put("fibers/yarn", std::vector<int>{1, 0, 1});
  file.put("fibers/radius", std::vector<double>{1, 2, 3});
  file.put("yarns/family", std::vector<int>{1, 0});
  file.put("yarns/name", std::vector<const char*>{"weft/1", "warp/1"});
  for (const std::string increment : {"increments/0/", "increments/1/"}) {
    file.put(increment + "position", straight);
    file.put(increment + "tangent", straight);
    file.put(increment + "stage_time", std::vector<double>{0.5});
    file.put_fixed(increment + "stage", "load");
  }
}

/// Changes one dataset: not at all, removed, of any size, of texts, of one number.
void change(Hdf5File& file, const std::string& dataset, std::uint8_t how) {
  const std::size_t n = how / 5;
  switch (how % 5) {
    case 1: return file.remove(dataset);
    case 2: return file.put(dataset, std::vector<int>(n, 1));
    case 3: return file.put(dataset, std::vector<const char*>(n, "a text"));
    case 4: return file.put(dataset, std::vector<Vec3>(n, Vec3(1, 2, 3)));
    default: return;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::filesystem::path path = test::fuzzed_file(".h5");
  if (size < 2) return 0;
  std::filesystem::remove(path);
  {
    Hdf5File file(path);
    write_good(file);
    const std::vector<std::string> datasets = test::datasets_of(file.id());
    change(file, datasets[data[0] % datasets.size()], data[1]);
    test::put_numbers(file.id(), test::datasets_of(file.id()), data + 2, size - 2);
  }
  test::read_nodes(path);
  return 0;
}
