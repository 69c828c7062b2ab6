#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <map>
#include <stdexcept>

#include "micro/core/whole_file.h"
#include "micro/states/hdf5.h"
#include "micro/states/snapshot.h"
#include "micro/states/snapshot_layout.h"

namespace trame::micro {
namespace {

using hdf5::Dims;
using hdf5::Element;
using hdf5::Handle;
using hdf5::StateFile;

// ---- written once -------------------------------------------------------------------------------------------------

void set_attribute(hid_t object, const char* key, const std::string& value) {
  const Handle type = hdf5::string_type(), space(H5Screate(H5S_SCALAR));
  const Handle attribute(H5Acreate2(object, key, type, space, H5P_DEFAULT, H5P_DEFAULT));
  const char* text = value.c_str();
  if (H5Awrite(attribute, type, &text) < 0) throw WriteError(fmt::format("attribute {} cannot be written", key));
}

void set_attribute(hid_t object, const char* key, Index value) {
  const Handle space(H5Screate(H5S_SCALAR));
  const Handle attribute(H5Acreate2(object, key, H5T_STD_I32LE, space, H5P_DEFAULT, H5P_DEFAULT));
  H5Awrite(attribute, H5T_NATIVE_INT32, &value);
}

Handle link_properties() {
  Handle properties(H5Pcreate(H5P_LINK_CREATE));
  H5Pset_create_intermediate_group(properties, 1);
  return properties;
}

template <class T>
void write_array(const StateFile& states, const std::string& path, const char* unit, const std::vector<T>& values) {
  using Scalar = typename Element<T>::Scalar;
  const Handle space = hdf5::space_of({values.size()});
  const Handle set(H5Dcreate2(states.file, path.c_str(), hdf5::file_type<Scalar>(), space, link_properties(),
                              H5P_DEFAULT, H5P_DEFAULT));
  if (!set.valid() ||
      H5Dwrite(set, hdf5::memory_type<Scalar>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, hdf5::pack(values).data()) < 0)
    states.fail_to_write("cannot write " + path);
  set_attribute(set, "unit", unit);
}

void write_texts(const StateFile& states, const std::string& path, const std::vector<std::string>& values) {
  const Handle type = hdf5::string_type(), space = hdf5::space_of({values.size()});
  const Handle set(H5Dcreate2(states.file, path.c_str(), type, space, link_properties(), H5P_DEFAULT, H5P_DEFAULT));
  std::vector<const char*> texts;
  for (const std::string& value : values) texts.push_back(value.c_str());
  if (!set.valid() || H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, texts.data()) < 0)
    states.fail_to_write("cannot write " + path);
}

void write_header(const StateFile& states, const SnapshotHeader& header) {
  set_attribute(states.file, "layout", layout::name);
  set_attribute(states.file, "layout_version", layout::version);
  set_attribute(states.file, "version", header.version);
  write_texts(states, "scene/name", {header.scene_name});
  write_texts(states, "scene/text", {header.scene_text});
  write_texts(states, "bodies/name", header.body_names);
  const FiberMesh& mesh = header.mesh;
  write_array(states, "mesh/first_node", "1", mesh.first_node);
  write_array(states, "mesh/radius", "m", mesh.radius);
  write_array(states, "mesh/axial_stiffness", "N", mesh.axial_stiffness);
  write_array(states, "mesh/yarn_of_fiber", "1", mesh.yarn_of_fiber);
  write_array(states, "mesh/arc_length", "m", mesh.arc_length);
  std::vector<std::string> names;
  std::vector<std::uint8_t> families;
  std::vector<Index> first_fibers, n_fibers;
  for (const Yarn& yarn : mesh.yarns) {
    names.push_back(yarn.name);
    families.push_back(static_cast<std::uint8_t>(yarn.family));
    first_fibers.push_back(yarn.first_fiber);
    n_fibers.push_back(yarn.n_fibers);
  }
  write_texts(states, "yarns/name", names);
  write_array(states, "yarns/family", "1", families);
  write_array(states, "yarns/first_fiber", "1", first_fibers);
  write_array(states, "yarns/n_fibers", "1", n_fibers);
}

// ---- grows with the run -------------------------------------------------------------------------------------------

constexpr hsize_t max_chunk_rows = 65536;
constexpr hsize_t contact_chunk_rows = 16384;
constexpr hsize_t page_size = 4096;
constexpr hsize_t scalar_chunk_rows = 256;
constexpr hsize_t continuation_chunk_bytes = 65536;

hsize_t chunk_rows(hsize_t rows) {
  const hsize_t n_chunks = (rows + max_chunk_rows - 1) / max_chunk_rows;
  return (rows + n_chunks - 1) / n_chunks;
}

/// Creates the growing datasets, all empty, and the count of increments.
struct Creator {
  const StateFile& states;

  void create(const std::string& path, hid_t type, Dims dims, const Dims& chunk, bool filtered, const char* unit) {
    Dims max = dims;
    max[0] = H5S_UNLIMITED;
    const Handle space(H5Screate_simple(int(dims.size()), dims.data(), max.data()));
    const Handle properties(H5Pcreate(H5P_DATASET_CREATE));
    H5Pset_chunk(properties, int(chunk.size()), chunk.data());
    if (filtered) {
      H5Pset_shuffle(properties);
      H5Pset_deflate(properties, 1);
      H5Pset_fletcher32(properties);  // damaged data are an error on reading, not wrong numbers
    }
    const Handle set(H5Dcreate2(states.file, path.c_str(), type, space, link_properties(), properties, H5P_DEFAULT));
    if (!set.valid()) states.fail_to_write("cannot create " + path);
    set_attribute(set, "unit", unit);
  }
  template <class T>
  void fixed(const std::string& path, const char* unit, const std::vector<T>&, std::size_t rows) {
    if (rows == 0) return;
    Dims dims = {0, rows}, chunk = {1, chunk_rows(rows)};
    for (hsize_t n : Element<T>::dims()) dims.push_back(n), chunk.push_back(n);
    create(path, hdf5::file_type<typename Element<T>::Scalar>(), dims, chunk, true, unit);
  }
  template <class T>
  void later_fixed(const std::string& path, const char* unit, const std::vector<T>& values, std::size_t rows) {
    fixed(path, unit, values, rows);
  }
  template <class T>
  void ragged(const std::string& path, const char* unit, const std::vector<T>&, bool single) {
    Dims dims = {0}, chunk = {contact_chunk_rows};
    for (hsize_t n : Element<T>::dims()) dims.push_back(n), chunk.push_back(n);
    create(path, hdf5::file_type<typename Element<T>::Scalar>(single), dims, chunk, true, unit);
  }
  template <class T>
  void later_ragged(const std::string& path, const char* unit, const std::vector<T>& values, bool single) {
    ragged(path, unit, values, single);
  }
  template <class T>
  void scalar(const std::string& path, const char* unit, const T&) {
    create(path, hdf5::file_type<T>(), {0}, {scalar_chunk_rows}, false, unit);
  }
  template <class T>
  void later_scalar(const std::string& path, const char* unit, const T& value) {
    scalar(path, unit, value);
  }
  void label(const std::string& path, const std::string&) {
    create(path, hdf5::string_type(layout::max_stage_bytes), {0}, {page_size / layout::max_stage_bytes}, false, "1");
  }
  void continuations() {
    for (const std::uint64_t n : {0, 1})
      create(layout::continuation_path(n), H5T_STD_U8LE, {0}, {continuation_chunk_bytes}, false, "1");
  }
  void count() {
    const Handle properties(H5Pcreate(H5P_DATASET_CREATE)), space(H5Screate(H5S_SCALAR));
    H5Pset_alloc_time(properties, H5D_ALLOC_TIME_EARLY);
    const Handle set(
        H5Dcreate2(states.file, "n_increments", H5T_STD_U64LE, space, H5P_DEFAULT, properties, H5P_DEFAULT));
    const std::uint64_t zero = 0;
    if (H5Dwrite(set, H5T_NATIVE_UINT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, &zero) < 0)
      states.fail_to_write("cannot be written to");
  }
};

/// Writes entry `i` of every growing dataset; contact elements go to rows `first_contact …` of theirs.
struct Appender {
  const StateFile& states;
  std::map<std::string, Handle>& open_sets;
  hsize_t i;
  hsize_t first_contact;

  void write(const std::string& path, hid_t type, const Dims& start, const Dims& count, const void* values) {
    Handle& set = open_sets[path];
    if (!set.valid()) set = Handle(H5Dopen2(states.file, path.c_str(), H5P_DEFAULT));
    Dims size = hdf5::extent(set);
    size[0] = std::max(size[0], start[0] + count[0]);
    const bool grown = H5Dset_extent(set, size.data()) >= 0;
    const Handle space = hdf5::select(set, start, count), memory = hdf5::space_of(count);
    if (!grown || !space.valid() || H5Dwrite(set, type, memory, space, H5P_DEFAULT, values) < 0)
      states.fail_to_write(fmt::format("cannot write {} of increment {}", path, i));
  }
  template <class T>
  void fixed(const std::string& path, const char*, const std::vector<T>& values, std::size_t rows) {
    if (values.size() != rows)
      throw std::invalid_argument(fmt::format("{} values for {} in {}", values.size(), rows, path));
    if (rows == 0) return;
    Dims start = {i, 0}, count = {1, rows};
    for (hsize_t n : Element<T>::dims()) start.push_back(0), count.push_back(n);
    write(path, hdf5::memory_type<typename Element<T>::Scalar>(), start, count, hdf5::pack(values).data());
  }
  /// Zeros where it is of an older file.
  template <class T>
  void later_fixed(const std::string& path, const char* unit, const std::vector<T>& values, std::size_t rows) {
    fixed(path, unit, values.empty() ? std::vector<T>(rows, T::Zero()) : values, rows);
  }
  template <class T>
  void ragged(const std::string& path, const char*, const std::vector<T>& values, bool) {
    if (values.empty()) return;
    Dims start = {first_contact}, count = {values.size()};
    for (hsize_t n : Element<T>::dims()) start.push_back(0), count.push_back(n);
    write(path, hdf5::memory_type<typename Element<T>::Scalar>(), start, count, hdf5::pack(values).data());
  }
  template <class T>
  void later_ragged(const std::string& path, const char* unit, const std::vector<T>& values, bool single) {
    ragged(path, unit, values, single);
  }
  template <class T>
  void scalar(const std::string& path, const char*, const T& value) {
    write(path, hdf5::memory_type<T>(), {i}, {1}, &value);
  }
  template <class T>
  void later_scalar(const std::string& path, const char* unit, const T& value) {
    scalar(path, unit, value);
  }
  void label(const std::string& path, const std::string& value) {
    states.require(value.size() <= layout::max_stage_bytes,
                   fmt::format("{} \"{}\" is longer than {} bytes", path, value, layout::max_stage_bytes));
    std::array<char, layout::max_stage_bytes> text{};
    std::copy(value.begin(), value.end(), text.begin());
    write(path, hdf5::string_type(layout::max_stage_bytes), {i}, {1}, text.data());
  }
};

/// The head of a continuation, and the continuation.
std::string with_head(std::uint64_t n_increments, const std::string& continuation) {
  const layout::ContinuationHead head{n_increments, continuation.size(), layout::checksum(continuation)};
  return std::string(reinterpret_cast<const char*>(&head), sizeof head) + continuation;
}

/// What a piece of the library's bookkeeping, and the end of a chunk, take beyond the numbers themselves.
constexpr std::uint64_t overhead_bytes = 2 * page_size;
/// What closing the file may add to it.
constexpr std::uint64_t closing_bytes = 4 * page_size;

/// How much an increment may add to the file: its numbers, not compressed, and the bookkeeping.
struct Measurer {
  std::uint64_t bytes = 0;

  template <class T>
  void add(const std::vector<T>& values) {
    using Scalar = typename Element<T>::Scalar;
    bytes += values.size() * Element<T>::n_scalars * sizeof(Scalar) + overhead_bytes;
  }
  template <class T>
  void fixed(const std::string&, const char*, const std::vector<T>& values, std::size_t) {
    add(values);
  }
  template <class T>
  void later_fixed(const std::string&, const char*, const std::vector<T>&, std::size_t rows) {
    add(std::vector<T>(rows));
  }
  template <class T>
  void ragged(const std::string&, const char*, const std::vector<T>& values, bool) {
    add(values);
  }
  template <class T>
  void later_ragged(const std::string& path, const char* unit, const std::vector<T>& values, bool single) {
    ragged(path, unit, values, single);
  }
  template <class T>
  void scalar(const std::string&, const char*, const T&) {
    bytes += overhead_bytes;
  }
  template <class T>
  void later_scalar(const std::string& path, const char* unit, const T& value) {
    scalar(path, unit, value);
  }
  void label(const std::string&, const std::string&) { bytes += overhead_bytes; }
};

/// How much of the file is written before the first increment.
std::uint64_t header_bytes(const SnapshotHeader& header) {
  constexpr std::uint64_t bookkeeping = 24 * page_size;
  const FiberMesh& mesh = header.mesh;
  std::uint64_t bytes = bookkeeping + header.scene_text.size() + sizeof(double) * mesh.arc_length.size() +
                        (2 * sizeof(double) + 2 * sizeof(Index)) * mesh.first_node.size();
  for (const std::string& name : header.body_names) bytes += name.size() + 2 * sizeof(hsize_t);
  for (const Yarn& yarn : mesh.yarns) bytes += yarn.name.size() + sizeof yarn;
  return bytes;
}

/// Throws where the arrays of a record differ in length.
struct EqualLengths {
  std::size_t length;
  template <class T>
  void ragged(const std::string& path, const char*, const std::vector<T>& values, bool) const {
    if (values.size() != length)
      throw std::invalid_argument(fmt::format("{} values for {} contacts in {}", values.size(), length, path));
  }
  template <class T>
  void later_ragged(const std::string& path, const char* unit, const std::vector<T>& values, bool single) const {
    ragged(path, unit, values, single);
  }
};

/// Version 1.10 objects: what single-writer/multiple-reader access needs.
Handle access_properties() {
  Handle properties = hdf5::file_access();
  H5Pset_libver_bounds(properties, H5F_LIBVER_V110, H5F_LIBVER_V110);
  return properties;
}

}  // namespace

struct SnapshotWriter::Impl {
  StateFile states;
  std::filesystem::path path;
  std::map<std::string, Handle> open_sets;
  Handle count_set;
  std::size_t n_nodes = 0, n_bodies = 0;
  std::uint64_t n_increments = 0, next_contact = 0;
  std::int64_t reserved = 0;  // at most, behind the end of the file

  ~Impl() { give_back(); }
  /// Of the file; negative where the library does not tell.
  [[nodiscard]] int descriptor() const {
    int* descriptor = nullptr;
    const bool told = H5Fget_vfd_handle(states.file, H5P_DEFAULT, reinterpret_cast<void**>(&descriptor)) >= 0;
    return told ? *descriptor : -1;
  }
  /// Hands what is written to the disk, not only to the system. Some file systems say only now that they are full.
  void sync() const {
    if (fdatasync(descriptor()) != 0 && (is_lack_of_space(errno) || errno == EIO))
      throw WriteError(fmt::format("{}: cannot be written to: {}", states.name, std::strerror(errno)));
  }

  [[nodiscard]] std::string what_is_saved() const {
    return n_increments == 0   ? "nothing is saved"
           : n_increments == 1 ? "the first state is whole in it"
                               : fmt::format("the first {} states are whole in it", n_increments);
  }
  /// Throws where the name no longer leads to what is written.
  void check_presence() const {
    struct stat written {
    }, named{};
    if (fstat(descriptor(), &written) != 0) return;
    if (stat(path.c_str(), &named) != 0 || named.st_ino != written.st_ino || named.st_dev != written.st_dev)
      throw LostError(fmt::format("{}: was removed or replaced while the run was writing it", states.name));
  }
  /// Throws where there is no room for `bytes` more, before the library meets that amid its bookkeeping.
  void check_room(std::uint64_t bytes) {
    const int file = descriptor();
    struct stat status {};
    if (fstat(file, &status) != 0) return;
    reserved = std::max(reserved, static_cast<std::int64_t>(bytes));
    const std::string lack = lack_of_room(file, status.st_size, static_cast<std::int64_t>(bytes));
    if (lack.empty()) return;
    give_back();
    throw WriteError(fmt::format("{}: cannot grow any further: {}; {}", states.name, lack, what_is_saved()));
  }
  /// What was set aside and not used, for the files that follow.
  void give_back() const {
    struct stat status {};
    if (reserved > 0 && states.file.valid() && fstat(descriptor(), &status) == 0)
      give_back_room(descriptor(), status.st_size, reserved);
  }
  /// After a failed write the library's picture of the file is not to be trusted: as that of a killed run, the file
  /// stays as it is, with all that was counted.
  void abandon() {
    give_back();
    for (auto& entry : open_sets) entry.second.abandon();
    count_set.abandon();
    states.file.abandon();
  }
  /// A file without a state is of no use.
  void remove_if_empty() const {
    std::error_code ignored;
    if (n_increments == 0) std::filesystem::remove(path, ignored);
  }
};

SnapshotWriter::SnapshotWriter(const std::filesystem::path& file, const SnapshotHeader& header)
    : impl_(std::make_unique<Impl>()) {
  const hdf5::Quiet quiet;
  StateFile& states = impl_->states;
  states.name = file.string();
  impl_->path = file;
  states.require(!std::filesystem::exists(file), "exists already; remove it or choose another name");
  const Handle creation(H5Pcreate(H5P_FILE_CREATE));
  // No piece of the library's bookkeeping crosses a page boundary, the only place where a killed write can end half
  // way.
  H5Pset_file_space_strategy(creation, H5F_FSPACE_STRATEGY_PAGE, 0, 1);
  H5Pset_file_space_page_size(creation, page_size);
  states.file = Handle(H5Fcreate(file.c_str(), H5F_ACC_EXCL, creation, access_properties()));
  states.require(states.file.valid(), "cannot be created; does its folder exist and may it be written to?");
  impl_->n_nodes = static_cast<std::size_t>(header.mesh.n_nodes());
  impl_->n_bodies = header.body_names.size();
  try {
    impl_->check_room(header_bytes(header));
    write_header(states, header);
    Creator creator{states};
    layout::visit_increment(static_cast<const Increment&>(Increment{}), impl_->n_nodes, impl_->n_bodies, creator);
    layout::visit_contact_rows(static_cast<const layout::ContactRows&>(layout::ContactRows{}), creator);
    creator.continuations();
    creator.count();
    // From here on the library orders its writes so that the file is readable at any moment: an interrupted run leaves
    // a file that is merely marked as open for writing.
    states.file = Handle();
    states.file = Handle(H5Fopen(file.c_str(), H5F_ACC_RDWR | H5F_ACC_SWMR_WRITE, access_properties()));
    if (!states.file.valid()) states.fail_to_write("cannot be reopened for writing");
    impl_->count_set = Handle(H5Dopen2(states.file, "n_increments", H5P_DEFAULT));
  } catch (const WriteError&) {
    impl_->abandon();
    impl_->remove_if_empty();
    throw;
  }
}

SnapshotWriter::~SnapshotWriter() = default;

void SnapshotWriter::rename(const std::filesystem::path& file) {
  std::error_code error;
  std::filesystem::rename(impl_->path, file, error);
  if (error) throw WriteError(fmt::format("{}: cannot be written: {}", file.string(), error.message()));
  impl_->path = file;
  impl_->states.name = file.string();
}

void SnapshotWriter::append(const Increment& increment, const std::string& continuation) {
  const hdf5::Quiet quiet;
  Impl& impl = *impl_;
  const layout::ContactRows rows{impl.next_contact, increment.contacts.fiber_a.size()};
  const EqualLengths equal_lengths{rows.count};
  layout::visit_contacts(increment.contacts, equal_lengths);
  if (!impl.states.file.valid()) throw WriteError(impl.states.name + ": an earlier increment could not be written");
  impl.check_presence();
  try {
    Measurer measurer;
    layout::visit_increment(increment, impl.n_nodes, impl.n_bodies, measurer);
    impl.check_room(measurer.bytes + continuation.size() + continuation_chunk_bytes + overhead_bytes + closing_bytes);
  } catch (const WriteError&) {
    impl.remove_if_empty();
    throw;
  }
  try {
    Appender appender{impl.states, impl.open_sets, impl.n_increments, rows.first};
    layout::visit_increment(increment, impl.n_nodes, impl.n_bodies, appender);
    layout::visit_contact_rows(rows, appender);
    if (!continuation.empty()) {
      const std::string bytes = with_head(impl.n_increments + 1, continuation);
      appender.write(layout::continuation_path(impl.n_increments + 1), H5T_NATIVE_UINT8, {0}, {bytes.size()},
                     bytes.data());
    }
    if (H5Fflush(impl.states.file, H5F_SCOPE_LOCAL) < 0) impl.states.fail_to_write("cannot be written to");
    impl.sync();
    // Whole chunks for each increment: what is on disk is never compressed anew.
    impl.next_contact += (rows.count + contact_chunk_rows - 1) / contact_chunk_rows * contact_chunk_rows;
    const std::uint64_t n = impl.n_increments + 1;
    if (H5Dwrite(impl.count_set, H5T_NATIVE_UINT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, &n) < 0 ||
        H5Dflush(impl.count_set) < 0)
      impl.states.fail_to_write("cannot be written to");
    impl.sync();
    impl.n_increments = n;
  } catch (const LostError&) {
    impl.abandon();
    throw;
  } catch (const WriteError& error) {
    impl.abandon();
    impl.remove_if_empty();
    throw WriteError(fmt::format("{}; {}", error.what(), impl.what_is_saved()));
  }
}

}  // namespace trame::micro
