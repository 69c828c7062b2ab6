#pragma once
/// \file
/// The one place that says how many threads compute.

#include <string>

namespace trame::micro {

/// For as long as it lives, parallel loops have `n` threads (0: as many as the caller has), and BLAS, which is called
/// from inside of them, has one. Then all is as it was before.
class Threads {
 public:
  explicit Threads(int n);
  ~Threads();
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;
  [[nodiscard]] int n() const { return n_; }

 private:
  int before_, blas_before_, n_;
};

/// The kernel that OpenBLAS runs, for a log.
[[nodiscard]] std::string blas_kernel();

}  // namespace trame::micro
