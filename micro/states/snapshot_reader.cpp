#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string_view>

#include "micro/states/hdf5.h"
#include "micro/states/snapshot.h"
#include "micro/states/snapshot_layout.h"

namespace trame::micro {
namespace {

using hdf5::Dims;
using hdf5::Element;
using hdf5::Handle;
using hdf5::StateFile;

/// Reads whole datasets, or entry `i` of growing ones, after checking shape and type.
struct Fetcher {
  const StateFile& states;
  hsize_t i = 0;
  layout::ContactRows contacts = {};

  Handle open(const std::string& path) const {
    std::string why;
    Handle set = hdf5::open_dataset(states.file, path, why);
    if (!set.valid()) states.fail(fmt::format("dataset {} {}", path, why));
    return set;
  }
  void check_class(hid_t set, const std::string& path, H5T_class_t wanted) const {
    const Handle type(H5Dget_type(set));
    states.require(H5Tget_class(type) == wanted,
                   fmt::format("dataset {} has another type than layout version {} says", path, layout::version));
  }
  void read(hid_t set, const std::string& path, hid_t type, const Dims& start, const Dims& count, void* values) const {
    check_class(set, path, H5Tget_class(type));
    const Handle space = hdf5::select(set, start, count), memory = hdf5::space_of(count);
    states.require(space.valid() && H5Dread(set, type, memory, space, H5P_DEFAULT, values) >= 0,
                   fmt::format("dataset {} is damaged", path));
  }
  /// Reads rows [start, start + count) of a dataset whose size must be at least `wanted` along the first dimension and
  /// equal to it along the others.
  template <class T>
  std::vector<T> rows(const std::string& path, const Dims& wanted, const Dims& start, const Dims& count) const {
    using Scalar = typename Element<T>::Scalar;
    const Handle set = open(path);
    const Dims size = hdf5::extent(set);
    const bool fits = size.size() == wanted.size() && size[0] >= wanted[0] &&
                      std::equal(size.begin() + 1, size.end(), wanted.begin() + 1);
    states.require(fits,
                   fmt::format("dataset {} has size {}, expected {}", path, hdf5::text(size), hdf5::text(wanted)));
    double n = 1;
    for (hsize_t c : count) n *= double(c);
    const bool starts_within = start[0] <= size[0] && count[0] <= size[0] - start[0];
    states.require(starts_within && hdf5::can_be_stored(set, n),
                   fmt::format("dataset {} claims {:g} entries, more than are stored", path, n));
    std::vector<Scalar> flat(static_cast<std::size_t>(n));
    read(set, path, hdf5::memory_type<Scalar>(), start, count, flat.data());
    std::vector<T> values;
    hdf5::unpack<T>(flat, values);
    return values;
  }
  /// A whole one-dimensional dataset.
  template <class T>
  std::vector<T> array(const std::string& path) const {
    const Dims size = hdf5::extent(open(path));
    states.require(size.size() == 1,
                   fmt::format("dataset {} has size {}, expected one dimension", path, hdf5::text(size)));
    return size[0] == 0 ? std::vector<T>() : rows<T>(path, size, {0}, size);
  }
  std::vector<std::string> texts(const std::string& path) const {
    const Handle set = open(path), type = hdf5::string_type();
    check_class(set, path, H5T_STRING);
    const Dims size = hdf5::extent(set);
    states.require(size.size() == 1,
                   fmt::format("dataset {} has size {}, expected one dimension", path, hdf5::text(size)));
    states.require(hdf5::can_be_stored(set, double(size[0])),
                   fmt::format("dataset {} claims {} entries, more than are stored", path, size[0]));
    std::vector<char*> pointers(size[0]);
    states.require(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data()) >= 0,
                   fmt::format("dataset {} is damaged", path));
    std::vector<std::string> values;
    for (const char* pointer : pointers) values.emplace_back(pointer ? pointer : "");
    const Handle space = hdf5::space_of(size);
    H5Dvlen_reclaim(type, space, H5P_DEFAULT, pointers.data());
    return values;
  }
  std::string single_text(const std::string& path) const {
    const std::vector<std::string> values = texts(path);
    states.require(values.size() == 1, fmt::format("dataset {} has {} entries, expected 1", path, values.size()));
    return values[0];
  }

  template <class T>
  void fixed(const std::string& path, const char*, std::vector<T>& values, std::size_t n_rows) const {
    values.clear();
    if (n_rows == 0) return;
    Dims wanted = {i + 1, n_rows}, start = {i, 0}, count = {1, n_rows};
    for (hsize_t n : Element<T>::dims()) wanted.push_back(n), start.push_back(0), count.push_back(n);
    values = rows<T>(path, wanted, start, count);
  }
  template <class T>
  void later_fixed(const std::string& path, const char* unit, std::vector<T>& values, std::size_t n_rows) const {
    values.clear();
    if (H5Lexists(states.file, path.c_str(), H5P_DEFAULT) > 0) fixed(path, unit, values, n_rows);
  }
  template <class T>
  void ragged(const std::string& path, const char*, std::vector<T>& values, bool) const {
    values.clear();
    if (contacts.count == 0) return;
    Dims wanted = {contacts.first + contacts.count}, start = {contacts.first}, count = {contacts.count};
    for (hsize_t n : Element<T>::dims()) wanted.push_back(n), start.push_back(0), count.push_back(n);
    values = rows<T>(path, wanted, start, count);
  }
  template <class T>
  void later_ragged(const std::string& path, const char* unit, std::vector<T>& values, bool single) const {
    values.clear();
    if (H5Lexists(states.file, path.c_str(), H5P_DEFAULT) > 0) ragged(path, unit, values, single);
  }
  template <class T>
  void scalar(const std::string& path, const char*, T& value) const {
    value = rows<T>(path, {i + 1}, {i}, {1})[0];
  }
  template <class T>
  void later_scalar(const std::string& path, const char* unit, T& value) const {
    if (H5Lexists(states.file, path.c_str(), H5P_DEFAULT) > 0) scalar(path, unit, value);
  }
  void label(const std::string& path, std::string& value) const {
    const Handle set = open(path);
    const Dims size = hdf5::extent(set);
    states.require(size.size() == 1 && size[0] > i,
                   fmt::format("dataset {} has size {}, expected ({}) or more", path, hdf5::text(size), i + 1));
    std::array<char, layout::max_stage_bytes + 1> text{};
    read(set, path, hdf5::string_type(layout::max_stage_bytes), {i}, {1}, text.data());
    value = text.data();
  }
};

/// Opens a file for reading. A file whose writer still runs, or was killed, is marked so in its superblock (version 3:
/// byte 11, bit 0) and needs the mode for concurrent reading; any other file is opened in the mode that checks its
/// length.
Handle open_for_reading(const StateFile& states, const std::filesystem::path& path) {
  states.require(std::filesystem::exists(path), "no such file");
  states.require(std::filesystem::is_regular_file(path), "not a file");
  std::array<char, 12> start{};
  std::ifstream stream(path, std::ios::binary);
  states.require(bool(stream), "cannot be read");
  stream.read(start.data(), start.size());
  states.require(std::string_view(start.data(), 8) == "\x89HDF\r\n\x1a\n", "not an HDF5 file, so not a state file");
  const bool marked = start[8] == 3 && (start[11] & 1) != 0;
  const Handle access = hdf5::file_access();
  // A writer may be at work on what is read: try again, but not for ever (the waiting time doubles each time from 1
  // ns).
  if (marked) H5Pset_metadata_read_attempts(access, 25);
  Handle file(H5Fopen(path.c_str(), marked ? H5F_ACC_RDONLY | H5F_ACC_SWMR_READ : H5F_ACC_RDONLY, access));
  states.require(file.valid(), marked ? "its run was interrupted before the first state was complete, or it is in use"
                                      : "truncated or damaged HDF5 file, or in use by another program");
  return file;
}

template <class T>
bool read_attribute(hid_t file, const char* key, hid_t type, H5T_class_t wanted, T& value) {
  const Handle attribute(H5Aopen(file, key, H5P_DEFAULT));
  if (!attribute.valid()) return false;
  const Handle actual(H5Aget_type(attribute)), space(H5Aget_space(attribute));
  if (H5Tget_class(actual) != wanted || H5Sget_simple_extent_npoints(space) != 1) return false;
  if (wanted == H5T_STRING && H5Tis_variable_str(actual) <= 0) return false;
  return H5Aread(attribute, type, &value) >= 0;
}

std::string text_attribute(hid_t file, const char* key) {
  char* value = nullptr;
  if (!read_attribute(file, key, hdf5::string_type(), H5T_STRING, value) || value == nullptr) return "";
  std::string text(value);
  H5free_memory(value);
  return text;
}

void check_layout(const StateFile& states) {
  states.require(text_attribute(states.file, "layout") == layout::name,
                 fmt::format("an HDF5 file, but not a state file: its attribute layout is not \"{}\"", layout::name));
  Index version = 0;
  states.require(read_attribute(states.file, "layout_version", H5T_NATIVE_INT32, H5T_INTEGER, version),
                 "attribute layout_version is missing");
  states.require(version >= layout::oldest_version && version <= layout::version,
                 fmt::format("layout_version {}; this program reads versions {} to {}", version, layout::oldest_version,
                             layout::version));
}

void check_mesh(const StateFile& states, const FiberMesh& mesh) {
  const auto same_length = [&](const auto& values, std::size_t n, const char* path) {
    states.require(values.size() == n, fmt::format("dataset {} has {} entries, expected {}", path, values.size(), n));
  };
  states.require(!mesh.first_node.empty() && mesh.first_node[0] == 0, "dataset mesh/first_node must start with 0");
  for (std::size_t f = 0; f + 1 < mesh.first_node.size(); ++f) {
    const Index n = mesh.first_node[f + 1] - mesh.first_node[f];
    states.require(mesh.first_node[f + 1] > mesh.first_node[f] && n >= 3 && n % 2 == 1,
                   fmt::format("dataset mesh/first_node gives fiber {} {} nodes; it needs an odd number ≥ 3", f, n));
  }
  const std::size_t n_fibers = mesh.first_node.size() - 1;
  same_length(mesh.radius, n_fibers, "mesh/radius");
  same_length(mesh.axial_stiffness, n_fibers, "mesh/axial_stiffness");
  same_length(mesh.yarn_of_fiber, n_fibers, "mesh/yarn_of_fiber");
  same_length(mesh.arc_length, static_cast<std::size_t>(mesh.n_nodes()), "mesh/arc_length");
  for (const Index yarn : mesh.yarn_of_fiber)
    states.require(yarn >= 0 && std::size_t(yarn) < mesh.yarns.size(),
                   fmt::format("dataset mesh/yarn_of_fiber holds {}, allowed 0 … {}", yarn, mesh.yarns.size() - 1));
  for (const Yarn& yarn : mesh.yarns)
    states.require(yarn.first_fiber >= 0 && yarn.n_fibers >= 0 && yarn.family <= YarnFamily::free &&
                       std::int64_t(yarn.first_fiber) + yarn.n_fibers <= std::int64_t(n_fibers),
                   fmt::format("yarn {} does not fit into {} fibers, or is of an unknown family", yarn.name, n_fibers));
}

SnapshotHeader read_header(const StateFile& states) {
  const Fetcher fetch{states};
  SnapshotHeader header;
  header.version = text_attribute(states.file, "version");
  header.scene_name = fetch.single_text("scene/name");
  header.scene_text = fetch.single_text("scene/text");
  header.body_names = fetch.texts("bodies/name");
  FiberMesh& mesh = header.mesh;
  mesh.first_node = fetch.array<Index>("mesh/first_node");
  mesh.radius = fetch.array<double>("mesh/radius");
  mesh.axial_stiffness = fetch.array<double>("mesh/axial_stiffness");
  mesh.yarn_of_fiber = fetch.array<Index>("mesh/yarn_of_fiber");
  mesh.arc_length = fetch.array<double>("mesh/arc_length");
  const std::vector<std::string> names = fetch.texts("yarns/name");
  const auto families = fetch.array<std::uint8_t>("yarns/family");
  const auto first_fibers = fetch.array<Index>("yarns/first_fiber"), n_fibers = fetch.array<Index>("yarns/n_fibers");
  states.require(
      families.size() == names.size() && first_fibers.size() == names.size() && n_fibers.size() == names.size(),
      "datasets in yarns/ differ in length");
  for (std::size_t y = 0; y < names.size(); ++y)
    mesh.yarns.push_back({names[y], static_cast<YarnFamily>(families[y]), first_fibers[y], n_fibers[y]});
  check_mesh(states, mesh);
  return header;
}

}  // namespace

struct SnapshotReader::Impl {
  StateFile states;
  SnapshotHeader header;
  Index n_increments = 0;

  [[nodiscard]] std::size_t n_nodes() const { return static_cast<std::size_t>(header.mesh.n_nodes()); }
  Fetcher at(Index i) const {
    states.require(i >= 0 && i < n_increments,
                   fmt::format("no increment {}: it holds {}, counted from 0", i, n_increments));
    return {states, static_cast<hsize_t>(i)};
  }
  /// Numbers of an increment that follow from others may be what they are; those of fibers, bodies and contacts are
  /// what everything is computed from.
  struct FiniteCheck {
    const StateFile& states;
    Index i;

    template <class T>
    void check(const std::string& path, const std::vector<T>& values) const {
      const auto is_finite = [](const T& value) {
        if constexpr (std::is_arithmetic_v<T>)
          return std::isfinite(double(value));
        else
          return value.allFinite();
      };
      states.require(std::all_of(values.begin(), values.end(), is_finite),
                     fmt::format("dataset {} of increment {} holds values that are not finite", path, i));
    }
    template <class T>
    void fixed(const std::string& path, const char*, const std::vector<T>& values, std::size_t) const {
      check(path, values);
    }
    template <class T>
    void later_fixed(const std::string& path, const char*, const std::vector<T>& values, std::size_t) const {
      check(path, values);
    }
    template <class T>
    void later_ragged(const std::string& path, const char*, const std::vector<T>& values, bool) const {
      check(path, values);
    }
    template <class T>
    void ragged(const std::string& path, const char*, const std::vector<T>& values, bool) const {
      check(path, values);
    }
  };
};

SnapshotReader::SnapshotReader(const std::filesystem::path& file) : impl_(std::make_unique<Impl>()) {
  const hdf5::Quiet quiet;
  StateFile& states = impl_->states;
  states.name = file.string();
  states.file = open_for_reading(states, file);
  check_layout(states);
  impl_->header = read_header(states);
  const Fetcher fetch{states};
  const Handle set = fetch.open("n_increments");
  states.require(hdf5::extent(set).empty(), "dataset n_increments must be a single number");
  fetch.check_class(set, "n_increments", H5T_INTEGER);
  std::int64_t n = -1;
  const bool read = H5Dread(set, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, &n) >= 0;
  states.require(read && n >= 0 && n <= std::numeric_limits<Index>::max(), "dataset n_increments is damaged");
  impl_->n_increments = static_cast<Index>(n);
}

SnapshotReader::~SnapshotReader() = default;

const SnapshotHeader& SnapshotReader::header() const { return impl_->header; }
Index SnapshotReader::n_increments() const { return impl_->n_increments; }

std::optional<std::string> SnapshotReader::continuation() const {
  const hdf5::Quiet quiet;
  const auto n = static_cast<std::uint64_t>(impl_->n_increments);
  const std::string path = layout::continuation_path(n);
  if (H5Lexists(impl_->states.file, "continuation", H5P_DEFAULT) <= 0 ||
      H5Lexists(impl_->states.file, path.c_str(), H5P_DEFAULT) <= 0)
    return std::nullopt;
  const auto bytes = Fetcher{impl_->states}.array<std::uint8_t>(path);
  layout::ContinuationHead head;
  if (bytes.size() < sizeof head) return std::nullopt;
  std::memcpy(&head, bytes.data(), sizeof head);
  if (head.n_increments != n || head.n_bytes > bytes.size() - sizeof head) return std::nullopt;
  const auto begin = bytes.begin() + sizeof head;
  std::string continuation(begin, begin + static_cast<std::ptrdiff_t>(head.n_bytes));
  if (layout::checksum(continuation) != head.checksum) return std::nullopt;
  return continuation;
}

FiberConfiguration SnapshotReader::read_fibers(Index i) const {
  const hdf5::Quiet quiet;
  Fetcher fetch = impl_->at(i);
  FiberConfiguration fibers;
  layout::visit_fibers(fibers, impl_->n_nodes(), fetch);
  const Impl::FiniteCheck finite{impl_->states, i};
  layout::visit_fibers(fibers, impl_->n_nodes(), finite);
  return fibers;
}

Increment SnapshotReader::read(Index i) const {
  const hdf5::Quiet quiet;
  Fetcher fetch = impl_->at(i);
  layout::visit_contact_rows(fetch.contacts, fetch);
  Increment increment;
  layout::visit_increment(increment, impl_->n_nodes(), impl_->header.body_names.size(), fetch);
  const Impl::FiniteCheck finite{impl_->states, i};
  layout::visit_fibers(increment.fibers, impl_->n_nodes(), finite);
  layout::visit_bodies(increment.bodies, impl_->header.body_names.size(), finite);
  layout::visit_contacts(increment.contacts, finite);
  const Index n_fibers = impl_->header.mesh.n_fibers();
  for (const auto* fibers : {&increment.contacts.fiber_a, &increment.contacts.fiber_b})
    for (const Index f : *fibers)
      impl_->states.require(f >= 0 && f < n_fibers,
                            fmt::format("contacts of increment {} name fiber {}, allowed 0 … {}", i, f, n_fibers - 1));
  return increment;
}

}  // namespace trame::micro
