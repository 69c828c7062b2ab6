#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include "micro/core/text.h"
#include "micro/states/hdf5.h"
#include "workflows/strains/fiber_nodes.h"

namespace trame::workflows {
namespace {

namespace hdf5 = micro::hdf5;
using hdf5::Dims;
using hdf5::Handle;

constexpr Index layout_version = 1;
constexpr std::size_t max_texts = 1'000'000, max_text_bytes = 1024;

Handle open_file(const std::filesystem::path& file) {
  return Handle(H5Fopen(file.c_str(), H5F_ACC_RDONLY, hdf5::file_access()));
}

/// Datasets of one file, checked for type and size before anything is allocated for them.
class Datasets {
 public:
  explicit Datasets(const std::filesystem::path& path) : name_(path.string()), file_(open_file(path)) {
    if (!file_.valid()) throw InputError(name_ + ": truncated or damaged HDF5 file, or in use by another program");
  }

  [[nodiscard]] hid_t file() const { return file_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::string where(const std::string& path) const { return fmt::format("{}: dataset {}", name_, path); }
  /// Fails for a link to another file: to leave out what it names would be to misread the file.
  [[nodiscard]] bool has(const std::string& path) const {
    require(!hdf5::leads_outside(file_, path), path, "is a link to another file, which is not followed");
    return exists(path);
  }
  [[nodiscard]] bool exists(const std::string& path) const {
    for (std::size_t slash = path.find('/'); slash != std::string::npos; slash = path.find('/', slash + 1))
      if (H5Lexists(file_, path.substr(0, slash).c_str(), H5P_DEFAULT) <= 0) return false;
    return H5Lexists(file_, path.c_str(), H5P_DEFAULT) > 0;
  }

  [[nodiscard]] bool is_text(const std::string& path) const {
    const Handle set = open(path), type(H5Dget_type(set));
    return H5Tget_class(type) == H5T_STRING;
  }
  /// Names of what is in a group.
  [[nodiscard]] std::vector<std::string> members(const std::string& group) const {
    constexpr hsize_t most = 100;
    std::vector<std::string> names;
    const Handle opened(exists(group) ? H5Gopen2(file_, group.c_str(), H5P_DEFAULT) : H5I_INVALID_HID);
    H5G_info_t info{};
    if (!opened.valid() || H5Gget_info(opened, &info) < 0) return names;
    for (hsize_t i = 0; i < std::min(info.nlinks, most); ++i) {
      std::array<char, 256> name{};
      if (H5Lget_name_by_idx(opened, ".", H5_INDEX_NAME, H5_ITER_INC, i, name.data(), name.size(), H5P_DEFAULT) > 0)
        names.emplace_back(name.data());
    }
    return names;
  }
  /// The attribute `unit` of a dataset, else of the file; empty where there is none.
  [[nodiscard]] std::string unit_of(const std::string& path) const {
    const Handle set = open(path);
    for (const hid_t object : {hid_t(set), hid_t(file_)}) {
      if (H5Aexists(object, "unit") <= 0) continue;
      const Handle attribute(H5Aopen(object, "unit", H5P_DEFAULT)), type(H5Aget_type(attribute)),
          space(H5Aget_space(attribute));
      const bool single = H5Tget_class(type) == H5T_STRING && H5Sget_simple_extent_npoints(space) == 1;
      if (!single || H5Tget_size(type) > max_text_bytes)
        throw InputError(fmt::format("{}: its attribute unit must be a single text", where(path)));
      if (H5Tis_variable_str(type) > 0) {
        char* text = nullptr;
        if (H5Aread(attribute, type, &text) < 0 || text == nullptr) return {};
        std::string unit(text);
        H5free_memory(text);
        return unit;
      }
      std::string unit(H5Tget_size(type) + 1, '\0');
      if (H5Aread(attribute, type, unit.data()) < 0) return {};
      return unit.c_str();
    }
    return {};
  }

  /// Number of entries of a dataset of one dimension.
  [[nodiscard]] std::size_t length(const std::string& path) const {
    const Dims size = hdf5::extent(open(path));
    require(size.size() == 1, path, fmt::format("has size {}, expected one dimension", hdf5::text(size)));
    require(size[0] <= max_file_nodes, path, fmt::format("has {} entries, allowed are {}", size[0], max_file_nodes));
    return static_cast<std::size_t>(size[0]);
  }

  /// A dataset of exactly `n` entries.
  template <class T>
  [[nodiscard]] std::vector<T> numbers(const std::string& path, std::size_t n) const {
    using Scalar = typename hdf5::Element<T>::Scalar;
    Dims wanted = hdf5::Element<T>::dims();
    wanted.insert(wanted.begin(), n);
    const Handle set = open(path);
    const Dims size = hdf5::extent(set);
    require(size == wanted, path, fmt::format("has size {}, expected {}", hdf5::text(size), hdf5::text(wanted)));
    require(hdf5::can_be_stored(set, double(n) * hdf5::Element<T>::n_scalars), path,
            fmt::format("claims {} entries, more than are stored", n));
    std::vector<Scalar> flat(n * hdf5::Element<T>::n_scalars);
    read(set, path, flat.data());
    std::vector<T> values;
    hdf5::unpack<T>(flat, values);
    return values;
  }

  [[nodiscard]] double number(const std::string& path) const {
    const Handle set = open(path);
    require(n_values(set) == 1, path, "must be a single number");
    double value = 0;
    read(set, path, &value);
    return value;
  }

  /// Texts of fixed or variable length, also a single one.
  [[nodiscard]] std::vector<std::string> texts(const std::string& path) const {
    const Handle set = open(path), type(H5Dget_type(set));
    const hssize_t n = n_values(set);
    require(H5Tget_class(type) == H5T_STRING, path, "must hold text");
    require(n >= 0 && std::size_t(n) <= max_texts, path, fmt::format("has {} entries, allowed are {}", n, max_texts));
    return H5Tis_variable_str(type) > 0 ? variable_texts(set, type, n, path) : fixed_texts(set, type, n, path);
  }

 private:
  void require(bool ok, const std::string& path, const std::string& what) const {
    if (!ok) throw InputError(fmt::format("{} {}", where(path), what));
  }
  [[nodiscard]] Handle open(const std::string& path) const {
    std::string why = "is missing";
    Handle set = exists(path) ? hdf5::open_dataset(file_, path, why) : Handle();
    require(set.valid(), path, why);
    return set;
  }
  [[nodiscard]] static hssize_t n_values(hid_t set) {
    const Handle space(H5Dget_space(set));
    return H5Sget_simple_extent_npoints(space);
  }
  template <class Scalar>
  void read(hid_t set, const std::string& path, Scalar* values) const {
    const Handle type(H5Dget_type(set));
    const H5T_class_t kind = H5Tget_class(type);
    const bool real = std::is_same_v<Scalar, double> && kind == H5T_FLOAT;
    require(real || kind == H5T_INTEGER, path,
            std::is_same_v<Scalar, double> ? "must hold numbers" : "must hold integers");
    read_as(set, path, hdf5::memory_type<Scalar>(), values);
  }
  void read_as(hid_t set, const std::string& path, hid_t type, void* values) const {
    require(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0, path, "is damaged");
  }
  [[nodiscard]] std::vector<std::string> fixed_texts(hid_t set, hid_t type, std::size_t n,
                                                     const std::string& path) const {
    const std::size_t size = H5Tget_size(type);
    require(size <= max_text_bytes, path, fmt::format("has texts of {} bytes, allowed are {}", size, max_text_bytes));
    std::vector<char> flat(n * size);
    read_as(set, path, type, flat.data());
    std::vector<std::string> values;
    for (auto text = flat.begin(); text != flat.end(); text += static_cast<std::ptrdiff_t>(size))
      values.emplace_back(text, std::find(text, text + static_cast<std::ptrdiff_t>(size), '\0'));
    return values;
  }
  [[nodiscard]] std::vector<std::string> variable_texts(hid_t set, hid_t type, std::size_t n,
                                                        const std::string& path) const {
    std::vector<char*> pointers(n);
    read_as(set, path, type, pointers.data());
    std::vector<std::string> values;
    for (const char* pointer : pointers) values.emplace_back(pointer ? pointer : "");
    const Handle space(H5Dget_space(set));
    H5Dvlen_reclaim(type, space, H5P_DEFAULT, pointers.data());
    return values;
  }

  std::string name_;
  Handle file_;
};

void check_version(const Datasets& sets) {
  if (H5Aexists(sets.file(), "layout_version") <= 0) return;
  const Handle attribute(H5Aopen(sets.file(), "layout_version", H5P_DEFAULT));
  const Handle type(H5Aget_type(attribute)), space(H5Aget_space(attribute));
  const bool single = H5Tget_class(type) == H5T_INTEGER && H5Sget_simple_extent_npoints(space) == 1;
  Index version = 0;
  if (!single || H5Aread(attribute, H5T_NATIVE_INT32, &version) < 0)
    throw InputError(sets.name() + ": attribute layout_version must be a single integer");
  if (version != layout_version)
    throw InputError(fmt::format("{}: layout_version {} of fiber nodes; this program reads version {} only",
                                 sets.name(), version, layout_version));
}

micro::Yarn make_yarn(const Datasets& sets, std::string name, Index family) {
  check_yarn_name(sets.where("yarns/name"), name);
  if (family < 0 || family > 2)
    throw InputError(
        fmt::format("{} holds {}, allowed: 0 (warp), 1 (weft), 2 (neither)", sets.where("yarns/family"), family));
  return {std::move(name), static_cast<micro::YarnFamily>(family), 0, 0};
}

std::vector<micro::Yarn> read_yarns(const Datasets& sets, const std::vector<Index>& yarn_of_fiber) {
  const auto [smallest, largest] = std::minmax_element(yarn_of_fiber.begin(), yarn_of_fiber.end());
  std::vector<std::string> names;
  if (sets.has("yarns/name")) names = sets.texts("yarns/name");
  const std::size_t n_most = names.empty() ? yarn_of_fiber.size() : names.size();
  if (*smallest < 0 || std::size_t(*largest) >= n_most)
    throw InputError(
        fmt::format("{} holds {} … {}, allowed: 0 … {}", sets.where("fibers/yarn"), *smallest, *largest, n_most - 1));
  for (Index y = static_cast<Index>(names.size()); y <= *largest; ++y) names.push_back(fmt::format("yarn/{}", y));
  std::vector<Index> families(names.size(), static_cast<Index>(micro::YarnFamily::free));
  if (sets.has("yarns/family")) families = sets.numbers<Index>("yarns/family", names.size());
  std::vector<micro::Yarn> yarns;
  for (std::size_t y = 0; y < names.size(); ++y) yarns.push_back(make_yarn(sets, names[y], families[y]));
  return yarns;
}

/// The dataset fibers/yarn, else one in fibers/ that is called alike; empty where there is none.
std::string label_of_yarns(const Datasets& sets) {
  if (sets.has("fibers/yarn")) return "fibers/yarn";
  for (const std::string& name : sets.members("fibers"))
    if (names_yarns(name)) return "fibers/" + name;
  return {};
}

/// What the user should know of the datasets that say which fiber is whose.
std::string remark_on_yarns(const Datasets& sets) {
  const std::string label = label_of_yarns(sets);
  if (label == "fibers/yarn") return {};
  if (!label.empty()) return fmt::format("yarns are taken from the dataset {}", printable(label));
  std::string others;
  for (const std::string& name : sets.members("fibers"))
    if (name != "start" && name != "radius")
      others += fmt::format("{}fibers/{}", others.empty() ? "" : ", ", printable(name));
  if (others.empty()) return {};
  return fmt::format("no dataset fibers/yarn, so all fibers are one yarn; there are {}", others);
}

FiberList read_fibers(const Datasets& sets) {
  if (!sets.has("fibers/start"))
    throw InputError(fmt::format(
        "{}: neither a state file (no attribute layout) nor fiber nodes (no dataset fibers/start)", sets.name()));
  FiberList list;
  list.start = sets.numbers<Index>("fibers/start", sets.length("fibers/start"));
  check_start(sets.where("fibers/start"), list.start);
  const std::size_t n_fibers = list.start.size() - 1;
  list.yarn.resize(n_fibers, 0);
  list.radius.resize(n_fibers, std::numeric_limits<double>::quiet_NaN());
  if (sets.has("fibers/radius")) list.radius = sets.numbers<double>("fibers/radius", n_fibers);
  const std::string label = label_of_yarns(sets);
  if (!label.empty() && sets.is_text(label)) {
    const std::vector<std::string> labels = sets.texts(label);
    if (labels.size() != n_fibers)
      throw InputError(fmt::format("{} has {} entries, expected {}", sets.where(label), labels.size(), n_fibers));
    for (const std::string& text : labels) check_yarn_name(sets.where(label), text);
    list.yarn.clear();
    make_yarns(labels, list);
    return list;
  }
  if (!label.empty()) list.yarn = sets.numbers<Index>(label, n_fibers);
  list.yarns = read_yarns(sets, list.yarn);
  return list;
}

/// Groups increments/0, increments/1, … without a gap.
Index count_increments(const Datasets& sets) {
  const auto fail = [&](const std::string& what) { throw InputError(sets.name() + ": group increments " + what); };
  const Handle group(sets.has("increments") ? H5Gopen2(sets.file(), "increments", H5P_DEFAULT) : H5I_INVALID_HID);
  H5G_info_t info{};
  if (!group.valid() || H5Gget_info(group, &info) < 0) fail("is missing");
  if (info.nlinks == 0 || info.nlinks > hsize_t(std::numeric_limits<Index>::max())) fail("is empty");
  for (hsize_t i = 0; i < info.nlinks; ++i)
    if (H5Lexists(group, std::to_string(i).c_str(), H5P_DEFAULT) <= 0)
      fail(fmt::format("has {} members, which must be called 0 … {}, but {} is not there", info.nlinks, info.nlinks - 1,
                       i));
  return static_cast<Index>(info.nlinks);
}

class Hdf5Nodes : public meso::FiberStates {
 public:
  explicit Hdf5Nodes(const std::filesystem::path& file) : sets_(file) {
    check_version(sets_);
    const FiberList list = read_fibers(sets_);
    n_nodes_ = static_cast<std::size_t>(list.start.back());
    n_increments_ = count_increments(sets_);
    const std::string first = "increments/0/position", unit = sets_.unit_of(first);
    if (!unit.empty()) metres_ = metres(sets_.where(first), unit);
    FiberList in_metres = list;
    for (double& r : in_metres.radius) r *= metres_;
    const std::vector<Vec3> reference = positions(0);
    order_.emplace(sets_.where(first), in_metres, reference);
    header_.mesh = order_->mesh();
    const std::string on_size = remark_on_size(reference,
                                               "an attribute \"unit\" of increments/0/position, such as "
                                               "\"um\",");
    for (const std::string& remark : {remark_on_yarns(sets_), order_->remark(), unit.empty() ? on_size : ""})
      if (!remark.empty()) remarks_.push_back(remark);
  }

  [[nodiscard]] std::vector<std::string> remarks() const override { return remarks_; }

  [[nodiscard]] std::string name() const override { return sets_.name(); }
  [[nodiscard]] const micro::SnapshotHeader& header() const override { return header_; }
  [[nodiscard]] Index n_increments() const override { return n_increments_; }
  [[nodiscard]] micro::Increment read(Index i) const override {
    const hdf5::Quiet quiet;
    if (i < 0 || i >= n_increments_)
      throw InputError(fmt::format("{}: no increment {}: it holds {}, counted from 0", sets_.name(), i, n_increments_));
    micro::Increment increment;
    if (sets_.has(path(i, "stage"))) increment.stage = stage(i);
    if (sets_.has(path(i, "stage_time"))) increment.stage_time = sets_.number(path(i, "stage_time"));
    const bool has_tangents = sets_.has(path(i, "tangent"));
    increment.fibers = order_->configuration(positions(i), has_tangents ? vectors(i, "tangent") : std::vector<Vec3>());
    return increment;
  }

 private:
  [[nodiscard]] static std::string path(Index i, const char* what) { return fmt::format("increments/{}/{}", i, what); }
  [[nodiscard]] std::string stage(Index i) const {
    const std::vector<std::string> texts = sets_.texts(path(i, "stage"));
    if (texts.size() != 1) throw InputError(sets_.where(path(i, "stage")) + " must be a single text");
    return made_name(texts[0]);
  }
  [[nodiscard]] std::vector<Vec3> vectors(Index i, const char* what) const {
    std::vector<Vec3> values = sets_.numbers<Vec3>(path(i, what), n_nodes_);
    check_finite(sets_.where(path(i, what)), values);
    return values;
  }

  [[nodiscard]] std::vector<Vec3> positions(Index i) const {
    std::vector<Vec3> values = vectors(i, "position");
    for (Vec3& x : values) x *= metres_;
    check_positions(sets_.where(path(i, "position")), values);
    return values;
  }

  Datasets sets_;
  double metres_ = 1;  // a unit of the file
  std::vector<std::string> remarks_;
  std::size_t n_nodes_ = 0;
  Index n_increments_ = 0;
  std::optional<NodeOrder> order_;
  micro::SnapshotHeader header_;
};

}  // namespace

bool may_hold_hdf5_nodes(const std::filesystem::path& file) {
  const hdf5::Quiet quiet;
  if (!std::filesystem::is_regular_file(file)) return false;
  const Handle opened = open_file(file);
  return opened.valid() && H5Aexists(opened, "layout") <= 0;
}

std::unique_ptr<meso::FiberStates> open_hdf5_nodes(const std::filesystem::path& file) {
  const hdf5::Quiet quiet;
  return std::make_unique<Hdf5Nodes>(file);
}

}  // namespace trame::workflows
