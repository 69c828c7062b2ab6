#pragma once
/// \file
/// Whether a scene can fit into the machine, asked before anything is laid out.

#include "micro/scene/scene.h"

namespace trame::workflows {

/// Memory that this process may still take, bytes: what the machine, its control group and limits (ulimit -v) leave.
[[nodiscard]] double available_memory();

/// Throws InputError that names the table with most nodes where even the least that a run of `scene` takes is more than
/// `available` bytes.
void check_memory(const micro::Scene& scene, double available);

/// OpenBLAS takes a buffer for each thread that multiplies matrices, and tries for ever where a limit (ulimit -v)
/// leaves none. Under such a limit this makes it take them now. Throws InputError where they do not fit.
void take_blas_buffers(int n_threads);

}  // namespace trame::workflows
