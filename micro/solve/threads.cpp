#include "micro/solve/threads.h"

#include <omp.h>

// The BLAS of Debian; its own header is not where others find it.
extern "C" void openblas_set_num_threads(int n_threads);
extern "C" int openblas_get_num_threads();
extern "C" char* openblas_get_corename();

namespace trame::micro {

Threads::Threads(int n)
    : before_(omp_get_max_threads()), blas_before_(openblas_get_num_threads()), n_(n > 0 ? n : before_) {
  omp_set_num_threads(n_);
  openblas_set_num_threads(1);
}

Threads::~Threads() {
  omp_set_num_threads(before_);
  openblas_set_num_threads(blas_before_);
}

std::string blas_kernel() { return openblas_get_corename(); }

}  // namespace trame::micro
