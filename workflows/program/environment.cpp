#include "workflows/program/environment.h"

#include <unistd.h>

#include <cstdlib>
#include <string_view>

namespace trame::workflows {

namespace {

std::string fitting_blas_kernel_here() {
#ifdef __x86_64__
  __builtin_cpu_init();
  const bool has_avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                          __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw");
  return fitting_blas_kernel(has_avx512, __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"));
#else
  return fitting_blas_kernel(false, false);
#endif
}

}  // namespace

std::string fitting_blas_kernel(bool has_avx512, bool has_avx2_fma) {
  return has_avx512 ? "SKYLAKEX" : has_avx2_fma ? "HASWELL" : "";
}

void prepare_blas(char** argv) {
  const char *kernel = "OPENBLAS_CORETYPE", *n_threads = "OPENBLAS_NUM_THREADS";
  const std::string fitting = fitting_blas_kernel_here();
  const bool keeps_kernel = std::getenv(kernel) != nullptr || fitting.empty();
  const char* given_threads = std::getenv(n_threads);
  if (keeps_kernel && given_threads != nullptr && given_threads == std::string_view("1")) return;
  if (!keeps_kernel) setenv(kernel, fitting.c_str(), 0);
  setenv(n_threads, "1", 1);
  execv("/proc/self/exe", argv);
  // Without /proc the program goes on, correct but slower.
}

}  // namespace trame::workflows
