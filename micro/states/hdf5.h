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
#include "micro/core/text.h"
#include "micro/core/types.h"

namespace trame::micro::hdf5 {

using Dims = std::vector<hsize_t>;

/// What holds for the library in all our programs, before anything is done with it.
inline void prepare_library() {
  static const bool done = [] {
    // Closing what it could not read or write of a file, the library would print a page about itself at the end, or
    // crash: what is open is closed by its owners.
    H5dont_atexit();
    H5open();
    // A file from elsewhere must not make us open others, which may be pipes that never end: links out of a file are
    // links of an unknown kind.
    H5Lunregister(H5L_TYPE_EXTERNAL);
    return true;
  }();
  (void)done;
}

/// Keeps the library from printing its error stack while alive: failures are reported by exceptions.
class Quiet {
 public:
  Quiet() {
    prepare_library();
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
  /// Gives the identifier up without closing it: of a file that could not be written, closing tries again and fails.
  void abandon() { id_ = H5I_INVALID_HID; }

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

/// Properties to open a file with. Locks of the library's own are off: file systems that have none (NFS, Lustre) would
/// refuse every file, and who writes where is for `FolderLock` to say.
inline Handle file_access() {
  Handle properties(H5Pcreate(H5P_FILE_ACCESS));
  H5Pset_file_locking(properties, false, true);
  return properties;
}

/// Whether the way to an object leads out of its file.
inline bool leads_outside(hid_t file, const std::string& path) {
  for (std::size_t slash = path.find('/', 1);; slash = path.find('/', slash + 1)) {
    H5L_info_t link{};
    const std::string part = path.substr(0, slash);
    if (H5Lexists(file, part.c_str(), H5P_DEFAULT) <= 0 || H5Lget_info(file, part.c_str(), &link, H5P_DEFAULT) < 0)
      return false;
    if (link.type != H5L_TYPE_HARD && link.type != H5L_TYPE_SOFT) return true;
    if (slash == std::string::npos) return false;
  }
}

/// What people call a filter. Numbers are those registered with the HDF Group; files do not always hold the name.
inline std::string name_of_filter(H5Z_filter_t filter, const std::string& stored) {
  constexpr std::pair<H5Z_filter_t, const char*> known[] = {{4, "szip"},     {32000, "lzf"},        {32001, "blosc"},
                                                            {32004, "lz4"},  {32008, "bitshuffle"}, {32013, "zfp"},
                                                            {32015, "zstd"}, {32026, "blosc2"}};
  for (const auto& [number, name] : known)
    if (number == filter) return name;
  return fmt::format("filter {} ({})", filter, stored.empty() ? "without a name" : printable(stored));
}

/// What speaks against the data of a dataset, before anything of them is read; empty where nothing does. Data that are
/// kept in other files could be any file of the machine.
inline std::string foreign_data(hid_t dataset) {
  const Handle creation(H5Dget_create_plist(dataset));
  if (!creation.valid()) return "is damaged";
  if (H5Pget_external_count(creation) != 0) return "keeps its data in another file, which is not followed";
  if (H5Pget_layout(creation) == H5D_VIRTUAL) return "is put together from other files, which is not followed";
  for (int i = 0; i < H5Pget_nfilters(creation); ++i) {
    unsigned flags = 0, config = 0;
    std::size_t n_values = 0;
    char name[64] = {};
    const H5Z_filter_t filter =
        H5Pget_filter2(creation, unsigned(i), &flags, &n_values, nullptr, sizeof name, name, &config);
    if (filter > 0 && H5Zfilter_avail(filter) <= 0)
      return fmt::format("is compressed with {}, which cannot be read here; gzip can", name_of_filter(filter, name));
  }
  return {};
}

/// Opens a dataset whose data are in its own file. Otherwise the handle is not valid, and `why` tells of it.
inline Handle open_dataset(hid_t file, const std::string& path, std::string& why) {
  if (leads_outside(file, path)) {
    why = "is a link to another file, which is not followed";
    return Handle();
  }
  Handle set(H5Dopen2(file, path.c_str(), H5P_DEFAULT));
  why = set.valid() ? foreign_data(set) : "is missing";
  return why.empty() ? std::move(set) : Handle();
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
  [[noreturn]] void fail_to_write(const std::string& what) const {
    throw WriteError(fmt::format("{}: {}; is the disk full?", name, what));
  }
  void require(bool ok, const std::string& what) const {
    if (!ok) fail(what);
  }
};

}  // namespace trame::micro::hdf5
