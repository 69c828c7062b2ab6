#pragma once
/// \file
/// What has to be in the process environment before the linear algebra starts.

#include <string>

namespace trame::workflows {

/// The OpenBLAS kernel that fits the instruction sets of a CPU; empty where OpenBLAS's own choice is as good.
[[nodiscard]] std::string fitting_blas_kernel(bool has_avx512, bool has_avx2_fma);

/// Sets what OpenBLAS reads only as the process starts, and executes the program again where that was not so already.
/// OPENBLAS_CORETYPE: it meets CPUs newer than itself with kernels two to three times too slow; set by the user, even
/// to nothing, it is left alone. OPENBLAS_NUM_THREADS = 1: we have no use for its threads, which are there before main
/// and so would get signals that ours block, and which under a limit of address space (ulimit -v) try for ever to get
/// their memory. Starting again takes as long as loading a program's libraries: only for those that need it, before all
/// else.
void prepare_blas(char** argv);

}  // namespace trame::workflows
