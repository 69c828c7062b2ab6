#pragma once
/// \file
/// Loops over yarns on several threads.

#include <omp.h>

#include <cstddef>
#include <exception>

namespace trame::meso {

/// Runs `work(i)` for 0 ≤ i < n on `n_threads` threads, 0: all cores. What one throws is thrown here, after all have
/// ended.
template <class Work>
void parallel_for(std::size_t n, int n_threads, Work&& work) {
  std::exception_ptr failure;
  const int n_used = n_threads > 0 ? n_threads : omp_get_max_threads();
#pragma omp parallel for schedule(dynamic) num_threads(n_used)
  for (std::size_t i = 0; i < n; ++i) {
    try {
      work(i);
    } catch (...) {
#pragma omp critical(trame_meso_failure)
      failure = std::current_exception();
    }
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace trame::meso
