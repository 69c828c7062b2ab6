#include "workflows/environment.h"

#include <unistd.h>

#include <cstdlib>

// Declared here, because the header's name and place depend on which BLAS the system prefers.
extern "C" char* openblas_get_corename();

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

void choose_blas_kernel(char** argv) {
  const char* variable = "OPENBLAS_CORETYPE";
  const std::string kernel = fitting_blas_kernel_here();
  if (std::getenv(variable) != nullptr || kernel.empty()) return;
  setenv(variable, kernel.c_str(), 0);
  execv("/proc/self/exe", argv);
  // Without /proc the program goes on, correct but slower.
}

std::string blas_kernel() { return openblas_get_corename(); }

}  // namespace trame::workflows
