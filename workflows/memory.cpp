#include "workflows/memory.h"

#include <fmt/format.h>
#include <omp.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "micro/core/error.h"
#include "workflows/program/terminal.h"

// Declared here, because the header's name and place depend on which BLAS the system prefers.
extern "C" void dgemm_(const char*, const char*, const int*, const int*, const int*, const double*, const double*,
                       const int*, const double*, const int*, const double*, double*, const int*);

namespace trame::workflows {

namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();

/// The number after `key` in a file of the kernel; `otherwise` where it has none.
double number_in(const char* file, const std::string& key, double otherwise) {
  std::ifstream stream(file);
  for (std::string word; stream >> word;)
    if (double value = 0; word == key && stream >> value) return value;
  return otherwise;
}

/// The only number of a file; "max" is no number.
double number_of(const char* file, double otherwise) {
  double value = 0;
  return std::ifstream(file) >> value ? value : otherwise;
}

double address_space_left() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unlimited;
  return static_cast<double>(limit.rlim_cur) - 1024 * number_in("/proc/self/status", "VmSize:", 0);
}

/// Nodes of one table of a scene, and what to call it.
struct Part {
  std::string name;
  double n_nodes = 0;
};

std::vector<Part> parts_of(const micro::Scene& scene) {
  std::vector<Part> parts;
  const auto add = [&](const std::string& name, double n_fibers, Index n_elements) {
    parts.push_back({name, n_fibers * (2.0 * n_elements + 1)});
  };
  for (std::size_t i = 0; i < scene.fibers.size(); ++i)
    add(fmt::format("fiber[{}].elements", i + 1), 1, scene.fibers[i].n_elements);
  for (std::size_t i = 0; i < scene.bundles.size(); ++i)
    add(fmt::format("bundle[{}].fibers and elements", i + 1), scene.bundles[i].n_fibers, scene.bundles[i].n_elements);
  if (scene.weave)
    for (const auto& [name, yarns] : {std::pair{"weave.warp", &scene.weave->warp}, {"weave.weft", &scene.weave->weft}})
      add(fmt::format("{}.yarns, fibers and elements", name), static_cast<double>(yarns->n_fibers()),
          yarns->n_elements);
  return parts;
}

}  // namespace

double available_memory() {
  const double machine = 1024 * number_in("/proc/meminfo", "MemAvailable:", unlimited);
  const double group = number_of("/sys/fs/cgroup/memory.max", unlimited) -
                       std::max(0.0, number_of("/sys/fs/cgroup/memory.current", 0) -
                                         number_in("/sys/fs/cgroup/memory.stat", "inactive_file", 0));
  return std::min({machine, group, address_space_left()});
}

void check_memory(const micro::Scene& scene, double available) {
  // A state, its copies, the matrix of a rod that touches nothing, and its factor. Contact takes many times that.
  constexpr double least_bytes_per_node = 2000;
  const std::vector<Part> parts = parts_of(scene);
  double n_nodes = 0;
  for (const Part& part : parts) n_nodes += part.n_nodes;
  if (n_nodes * least_bytes_per_node <= available) return;
  const auto largest =
      std::max_element(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.n_nodes < b.n_nodes; });
  throw InputError(
      fmt::format("{}: {}: {:.3g} of {:.3g} nodes, for which a run needs at least {}, and there are {}: take "
                  "fewer",
                  scene.name, largest->name, largest->n_nodes, n_nodes, bytes_text(n_nodes * least_bytes_per_node),
                  bytes_text(std::max(available, 0.0))));
}

void take_blas_buffers(int n_threads) {
  if (address_space_left() == unlimited) return;
  const int n = n_threads > 0 ? n_threads : omp_get_max_threads();
  constexpr std::size_t buffer = 128 << 20, of_a_thread = buffer + (16 << 20);  // with the stack and its surroundings
  void* room = mmap(nullptr, n * of_a_thread, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (room == MAP_FAILED)
    throw InputError(
        fmt::format("--threads {}: each takes {} for matrices, but the limit of address space (ulimit -v) "
                    "leaves {}; take fewer threads or a higher limit",
                    n, bytes_text(of_a_thread), bytes_text(std::max(address_space_left(), 0.0))));
  munmap(room, n * of_a_thread);
#pragma omp parallel num_threads(n)
  {
    constexpr int size = 64;  // large enough for the kernel that has a buffer
    constexpr double one = 1;
    const std::vector<double> a(size * size, 1.0), b = a;
    std::vector<double> c(size * size, 0.0);
    dgemm_("N", "N", &size, &size, &size, &one, a.data(), &size, b.data(), &size, &one, c.data(), &size);
  }
}

}  // namespace trame::workflows
