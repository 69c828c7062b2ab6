#pragma once
/// \file
/// Numbers of a good HDF5 file replaced by any others, which no checksum gives away.

#include <hdf5.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace trame::test {

/// The paths of all datasets of a file.
inline std::vector<std::string> datasets_of(hid_t file) {
  std::vector<std::string> paths;
  const auto visit = [](hid_t, const char* name, const H5O_info_t* info, void* list) -> herr_t {
    if (info->type == H5O_TYPE_DATASET) static_cast<std::vector<std::string>*>(list)->emplace_back(name);
    return 0;
  };
  H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_INC, visit, &paths, H5O_INFO_BASIC);
  return paths;
}

/// Puts a number of eight bytes in the place of one of a dataset.
inline void put_number(hid_t file, const std::string& dataset, std::uint32_t at, const std::uint8_t* bytes) {
  const hid_t set = H5Dopen2(file, dataset.c_str(), H5P_DEFAULT), type = H5Dget_type(set), space = H5Dget_space(set);
  const hssize_t n = H5Sget_simple_extent_npoints(space);
  const H5T_class_t kind = H5Tget_class(type);
  if (n > 0 && (kind == H5T_FLOAT || kind == H5T_INTEGER)) {
    std::vector<std::uint64_t> values(static_cast<std::size_t>(n));  // doubles or integers
    const hid_t memory = kind == H5T_FLOAT ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64;
    H5Dread(set, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    std::memcpy(&values[at % values.size()], bytes, 8);
    H5Dwrite(set, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  }
  H5Sclose(space), H5Tclose(type), H5Dclose(set);
}

/// Patches of eleven bytes: which dataset, where in it (two bytes), which number.
inline void put_numbers(hid_t file, const std::vector<std::string>& datasets, const std::uint8_t* data,
                        std::size_t size) {
  constexpr std::size_t patch = 11;
  for (; size >= patch; data += patch, size -= patch)
    put_number(file, datasets[data[0] % datasets.size()], data[1] + 256U * data[2], data + 3);
}

}  // namespace trame::test
