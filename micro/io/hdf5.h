#pragma once
/// \file
/// The few HDF5 calls that the state file needs, with handles that close themselves and failures that become
/// InputError. Included by snapshot_*.cpp only.

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <concepts>
#include <filesystem>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "micro/core/error.h"
#include "micro/core/types.h"

namespace trame::micro::hdf5 {

using Dims = std::vector<hsize_t>;

/// Keeps the library from printing its error stack while alive: failures are reported by exceptions.
class Quiet {
 public:
  Quiet() {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Quiet() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

/// An HDF5 identifier, closed with its last owner.
class Handle {
 public:
  Handle() = default;
  explicit Handle(hid_t id) : id_(id) {}
  ~Handle() { close(); }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)) {}
  Handle& operator=(Handle&& other) noexcept {
    close();
    id_ = std::exchange(other.id_, H5I_INVALID_HID);
    return *this;
  }
  operator hid_t() const { return id_; }
  [[nodiscard]] bool valid() const { return id_ >= 0; }

 private:
  void close() {
    if (id_ >= 0) H5Idec_ref(id_);
  }
  hid_t id_ = H5I_INVALID_HID;
};

/// How an element type of our arrays looks in a file: scalars of one kind, and the dimensions of one element.
template <class T>
struct Element {
  using Scalar = T;
  static Dims dims() { return {}; }
  static constexpr std::size_t n_scalars = 1;
};
template <>
struct Element<Vec3> {
  using Scalar = double;
  static Dims dims() { return {3}; }
  static constexpr std::size_t n_scalars = 3;
};
template <>
struct Element<Mat3> {
  using Scalar = double;
  static Dims dims() { return {3, 3}; }
  static constexpr std::size_t n_scalars = 9;
};

template <class Scalar>
hid_t memory_type() {
  if constexpr (std::is_same_v<Scalar, double>) return H5T_NATIVE_DOUBLE;
  if constexpr (std::is_same_v<Scalar, Index>) return H5T_NATIVE_INT32;
  if constexpr (std::is_same_v<Scalar, std::uint8_t>) return H5T_NATIVE_UINT8;
  if constexpr (std::is_same_v<Scalar, std::uint64_t>) return H5T_NATIVE_UINT64;
}

/// Type in the file: little-endian, floating point as 32 bits where `single` is asked for.
template <class Scalar>
hid_t file_type(bool single = false) {
  if constexpr (std::is_same_v<Scalar, double>) return single ? H5T_IEEE_F32LE : H5T_IEEE_F64LE;
  if constexpr (std::is_same_v<Scalar, Index>) return H5T_STD_I32LE;
  if constexpr (std::is_same_v<Scalar, std::uint8_t>) return H5T_STD_U8LE;
  if constexpr (std::is_same_v<Scalar, std::uint64_t>) return H5T_STD_U64LE;
}

/// Scalars in the order of the file (C order: matrices row by row).
template <class T>
auto pack(const std::vector<T>& values) {
  std::vector<typename Element<T>::Scalar> flat;
  flat.reserve(values.size() * Element<T>::n_scalars);
  for (const T& value : values) {
    if constexpr (std::is_same_v<T, Mat3>) {
      for (int i = 0; i < 9; ++i) flat.push_back(value(i / 3, i % 3));
    } else if constexpr (std::is_same_v<T, Vec3>) {
      flat.insert(flat.end(), value.data(), value.data() + 3);
    } else {
      flat.push_back(value);
    }
  }
  return flat;
}

template <class T>
void unpack(const std::vector<typename Element<T>::Scalar>& flat, std::vector<T>& values) {
  values.resize(flat.size() / Element<T>::n_scalars);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto* scalars = flat.data() + i * Element<T>::n_scalars;
    if constexpr (std::is_same_v<T, Mat3>) {
      for (int k = 0; k < 9; ++k) values[i](k / 3, k % 3) = scalars[k];
    } else if constexpr (std::is_same_v<T, Vec3>) {
      values[i] = Vec3(scalars[0], scalars[1], scalars[2]);
    } else {
      values[i] = *scalars;
    }
  }
}

/// Variable-length UTF-8 string, for what is written once.
inline Handle string_type() {
  Handle type(H5Tcopy(H5T_C_S1));
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

/// UTF-8 string of at most `size` bytes, for what grows with the run.
inline Handle string_type(std::size_t size) {
  Handle type(H5Tcopy(H5T_C_S1));
  H5Tset_size(type, size);
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

inline Handle space_of(const Dims& dims) {
  return Handle(dims.empty() ? H5Screate(H5S_SCALAR) : H5Screate_simple(int(dims.size()), dims.data(), nullptr));
}

inline Dims extent(hid_t dataset) {
  const Handle space(H5Dget_space(dataset));
  const int rank = space.valid() ? H5Sget_simple_extent_ndims(space) : -1;
  Dims dims(std::max(rank, 0));
  if (rank > 0) H5Sget_simple_extent_dims(space, dims.data(), nullptr);
  return dims;
}

/// Whether a file is large enough to hold `n` entries of a dataset. Deflate shrinks nothing to less than a thousandth,
/// so more can only be claimed, and is not to be allocated.
inline bool can_be_stored(hid_t dataset, double n) {
  const Handle file(H5Iget_file_id(dataset)), type(H5Dget_type(dataset));
  hsize_t size = 0;
  return H5Fget_filesize(file, &size) >= 0 && n * double(H5Tget_size(type)) <= 1100.0 * double(size);
}

inline std::string text(const Dims& dims) { return fmt::format("({})", fmt::join(dims, " x ")); }

/// Selection of `count` entries from `start` in a dataset.
inline Handle select(hid_t dataset, const Dims& start, const Dims& count) {
  Handle space(H5Dget_space(dataset));
  if (H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) < 0) return Handle();
  return space;
}

/// An open state file under the name that messages give it.
struct StateFile {
  std::string name;
  Handle file;

  [[noreturn]] void fail(const std::string& what) const { throw InputError(fmt::format("{}: {}", name, what)); }
  void require(bool ok, const std::string& what) const {
    if (!ok) fail(what);
  }
};

}  // namespace trame::micro::hdf5
