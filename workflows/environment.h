#pragma once
/// \file
/// What has to be in the process environment before the linear algebra starts.

#include <string>

namespace trame::workflows {

/// The OpenBLAS kernel that fits the instruction sets of a CPU; empty where OpenBLAS's own choice is as good.
[[nodiscard]] std::string fitting_blas_kernel(bool has_avx512, bool has_avx2_fma);

/// OpenBLAS meets CPUs newer than itself with kernels two to three times too slow, and reads OPENBLAS_CORETYPE, which
/// tells it better, only as the process starts. So where that variable is unset this sets it and executes the program
/// again. Call it first thing in main; OPENBLAS_CORETYPE set by the user, even to nothing, is left alone.
void choose_blas_kernel(char** argv);

/// The kernel that OpenBLAS runs, for a log.
[[nodiscard]] std::string blas_kernel();

}  // namespace trame::workflows
