#include "workflows/strains/fiber_nodes.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <string_view>
#include <tuple>

#include "meso/strain/strain.h"
#include "micro/core/error.h"
#include "micro/core/quantity.h"
#include "micro/core/text.h"
#include "micro/fiber/lagrange.h"
#include "workflows/program/file_probe.h"

namespace trame::workflows {
namespace {

/// Indices of the fibers, yarn by yarn, in file order within a yarn.
std::vector<std::size_t> fibers_by_yarn(const FiberList& list) {
  std::vector<std::size_t> order(list.n_fibers());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return list.yarn[a] < list.yarn[b]; });
  return order;
}

std::vector<Vec3> slopes(const micro::FiberMesh& mesh, const std::vector<Vec3>& r) {
  std::vector<Vec3> result(r.size());
  for (Index f = 0; f < mesh.n_fibers(); ++f) {
    const Index first = mesh.first_node[f], n_nodes = mesh.n_nodes(f), n = std::min(n_nodes, 3);
    for (Index k = 0; k < n_nodes; ++k) {
      const Index begin = first + std::clamp(k - 1, 0, n_nodes - n);
      result[first + k] =
          micro::lagrange_shape(&mesh.arc_length[begin], mesh.arc_length[first + k], n).derivative(r, begin);
    }
  }
  return result;
}

}  // namespace

void check_start(const std::string& where, const std::vector<Index>& start) {
  if (start.size() < 2 || start[0] != 0)
    throw InputError(fmt::format("{}: must begin with 0 and have an entry more than there are fibers", where));
  for (std::size_t f = 0; f + 1 < start.size(); ++f)
    if (start[f + 1] < 0 || start[f + 1] - start[f] < 2)
      throw InputError(fmt::format("{}: fiber {} from node {} to before node {}; a fiber needs at least 2 nodes", where,
                                   f, start[f], start[f + 1]));
}

void check_finite(const std::string& where, const std::vector<Vec3>& values) {
  for (std::size_t n = 0; n < values.size(); ++n)
    if (!values[n].allFinite())
      throw InputError(fmt::format("{} holds values that are not finite, at node {}", where, n));
}

void check_positions(const std::string& where, const std::vector<Vec3>& positions) {
  constexpr double largest = 1e9;  // m
  check_finite(where, positions);
  for (std::size_t n = 0; n < positions.size(); ++n)
    if (const double x = positions[n].cwiseAbs().maxCoeff(); x > largest)
      throw InputError(fmt::format("{} holds {:g} m, at node {}; must be at most {:g} m", where, x, n, largest));
}

void check_yarn_name(const std::string& where, const std::string& name) {
  if (name.empty() || name.size() > max_name_bytes || !is_plain(name))
    throw InputError(
        fmt::format("{} holds \"{}\"; a yarn's name is a text of one line, of 1 to {} bytes and without "
                    "control characters",
                    where, printable(name.substr(0, max_name_bytes)), max_name_bytes));
}

void make_yarns(const std::vector<std::string>& label_of_fiber, FiberList& list) {
  using Label = std::tuple<bool, std::int64_t, std::string>;  // is text, number, text
  const auto parsed = [](const std::string& text) -> Label {
    std::int64_t number = 0;
    const auto [rest, status] = std::from_chars(text.data(), text.data() + text.size(), number);
    const bool is_number = status == std::errc() && rest == text.data() + text.size();
    return is_number ? Label{false, number, ""} : Label{true, 0, text};
  };
  std::map<Label, Index> yarns;
  for (const std::string& text : label_of_fiber) yarns[parsed(text)] = 0;
  for (auto& [label, index] : yarns) {
    index = static_cast<Index>(list.yarns.size());
    const auto& [is_text, number, text] = label;
    list.yarns.push_back({is_text ? text : fmt::format("yarn/{}", number), micro::YarnFamily::free, 0, 0});
  }
  for (const std::string& text : label_of_fiber) list.yarn.push_back(yarns[parsed(text)]);
}

namespace {

/// A name as people write it in other places: "Yarn_ID" is "yarn".
std::string bare_word(const std::string& name) {
  std::string letters;
  for (const unsigned char c : name)
    if (std::isalnum(c) != 0) letters += static_cast<char>(std::tolower(c));
  for (const char* ending : {"id", "index", "name", "label", "number"})
    if (letters.ends_with(ending) && letters.size() > std::strlen(ending)) {
      letters.erase(letters.size() - std::strlen(ending));
      break;
    }
  return letters;
}

bool is_one_of(const std::string& word, std::initializer_list<const char*> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

}  // namespace

bool names_yarns(const std::string& name) {
  return is_one_of(bare_word(name), {"yarn", "yarns", "tow", "bundle", "yarnof", "yarnoffiber"});
}

bool names_fibers(const std::string& name) {
  return is_one_of(bare_word(name), {"fiber", "fibre", "fibers", "fibres", "filament"});
}

double metres(const std::string& where, const std::string& unit) {
  try {
    const double factor = parse_quantity("1 " + unit, "m");
    if (factor > 0) return factor;
  } catch (const InputError&) {  // told below
  }
  throw InputError(fmt::format("{}: unit \"{}\"; must be one of length, such as m, mm or um", where, printable(unit)));
}

std::string remark_on_size(const std::vector<Vec3>& positions, const std::string& how_to_give_a_unit) {
  constexpr double largest_fabric = 10;  // m
  Eigen::AlignedBox3d box;
  for (const Vec3& x : positions) box.extend(x);
  const double size = positions.empty() ? 0 : box.sizes().maxCoeff();
  if (!(size > largest_fabric)) return {};
  return fmt::format(
      "positions are taken as metres, so the fibers reach over {:.3g} m; {} says otherwise. Strains do not "
      "depend on it, areas and lengths do",
      size, how_to_give_a_unit);
}

namespace {

/// Which fibers of a yarn run against most of the others. `ends`: start and end of each.
std::vector<char> against_the_others(const std::vector<std::pair<Vec3, Vec3>>& ends) {
  std::vector<char> against;
  against.reserve(ends.size());
  const auto& [start, end] = ends.front();
  for (const auto& [a, b] : ends)
    against.push_back((a - start).norm() + (b - end).norm() > (b - start).norm() + (a - end).norm() ? 1 : 0);
  const auto n = std::count(against.begin(), against.end(), 1);
  if (2 * n > static_cast<std::ptrdiff_t>(ends.size()))
    for (char& turned : against) turned = turned == 0 ? 1 : 0;
  return against;
}

std::vector<char> fibers_to_turn(const FiberList& list, const std::vector<std::size_t>& order,
                                 const std::vector<Vec3>& reference) {
  std::vector<char> turned;
  for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
    std::vector<std::pair<Vec3, Vec3>> ends;
    for (; last < order.size() && list.yarn[order[last]] == list.yarn[order[first]]; ++last)
      ends.emplace_back(reference[list.start[order[last]]], reference[list.start[order[last] + 1] - 1]);
    const std::vector<char> of_yarn = against_the_others(ends);
    turned.insert(turned.end(), of_yarn.begin(), of_yarn.end());
  }
  return turned;
}

}  // namespace

NodeOrder::NodeOrder(const std::string& where, const FiberList& list, const std::vector<Vec3>& reference) {
  mesh_.yarns = list.yarns;
  for (micro::Yarn& yarn : mesh_.yarns) yarn.n_fibers = 0;
  const std::vector<std::size_t> order = fibers_by_yarn(list);
  turned_ = fibers_to_turn(list, order, reference);
  for (const std::size_t f : order) {
    const bool turned = turned_[mesh_.radius.size()] != 0;
    micro::Yarn& yarn = mesh_.yarns[list.yarn[f]];
    if (yarn.n_fibers++ == 0) yarn.first_fiber = mesh_.n_fibers();
    const Index n_nodes = list.start[f + 1] - list.start[f];
    mesh_.first_node.push_back(mesh_.first_node.back() + n_nodes);
    mesh_.radius.push_back(list.radius[f]);
    mesh_.axial_stiffness.push_back(std::numeric_limits<double>::quiet_NaN());
    mesh_.yarn_of_fiber.push_back(list.yarn[f]);
    double s = 0;
    for (Index k = 0; k < n_nodes; ++k) {
      const Index n = turned ? list.start[f + 1] - 1 - k : list.start[f] + k, before = turned ? n + 1 : n - 1;
      const double step = k == 0 ? 0 : (reference[n] - reference[before]).norm();
      if (k > 0 && !(s + step > s && std::isfinite(step)))
        throw InputError(fmt::format("{}: nodes {} and {} of fiber {} coincide, or are too far apart to tell", where,
                                     std::min(n, before) - list.start[f], std::max(n, before) - list.start[f], f));
      s += step;
      mesh_.arc_length.push_back(s);
      source_.push_back(n);
    }
  }
}

std::string NodeOrder::remark() const {
  const auto n = std::count(turned_.begin(), turned_.end(), 1);
  if (n == 0) return {};
  return fmt::format("{} of {} fibers ran against the others of their yarn and were turned", n, turned_.size());
}

micro::FiberConfiguration NodeOrder::configuration(const std::vector<Vec3>& positions,
                                                   const std::vector<Vec3>& tangents) const {
  micro::FiberConfiguration fibers;
  fibers.resize(source_.size());
  for (std::size_t n = 0; n < source_.size(); ++n) fibers.r[n] = positions[source_[n]];
  if (tangents.empty()) fibers.tangent = slopes(mesh_, fibers.r);
  for (std::size_t f = 0; f < turned_.size() && !tangents.empty(); ++f)
    for (Index n = mesh_.first_node[f]; n < mesh_.first_node[f + 1]; ++n)
      fibers.tangent[n] = turned_[f] != 0 ? Vec3(-tangents[source_[n]]) : tangents[source_[n]];
  for (std::size_t n = 0; n < source_.size(); ++n) {
    const Mat3 frame = meso::yarn_frame(fibers.tangent[n]);
    fibers.g1[n] = frame.row(1);
    fibers.g2[n] = frame.row(2);
  }
  return fibers;
}

namespace {

bool is_hdf5(const std::filesystem::path& file) {
  std::array<char, 8> start{};
  std::ifstream(file, std::ios::binary).read(start.data(), start.size());
  return std::string_view(start.data(), start.size()) == "\x89HDF\r\n\x1a\n";
}

/// In capitals or not.
bool ends_in(const std::filesystem::path& file, std::initializer_list<const char*> endings) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return is_one_of(ending, endings);
}

constexpr const char* formats =
    "the state file of a run (HDF5), or fiber nodes: one HDF5 file, or for each state a VTK PolyData file (.vtp) or a "
    "table (.csv, .txt)";

}  // namespace

std::unique_ptr<meso::FiberStates> open_states(const std::vector<std::filesystem::path>& files) {
  const auto all_end_in = [&](std::initializer_list<const char*> endings) {
    return !files.empty() && std::all_of(files.begin(), files.end(),
                                         [&](const std::filesystem::path& file) { return ends_in(file, endings); });
  };
  if (all_end_in({".vtp"})) return open_vtp_nodes(files);
  if (all_end_in({".csv", ".txt"})) return open_table_nodes(files);
  if (files.size() != 1)
    throw InputError(fmt::format("{}: several files must all be .vtp, or all .csv or .txt, one for each state",
                                 files.empty() ? "" : files[1].string()));
  if (may_hold_hdf5_nodes(files[0])) return open_hdf5_nodes(files[0]);
  if (std::filesystem::is_regular_file(files[0]) && !is_hdf5(files[0]))
    throw InputError(fmt::format("{}: not an HDF5 file; must be {}", files[0].string(), formats));
  return std::make_unique<meso::RunStates>(files[0]);
}

namespace {

/// Reads `file` in a process of its own.
void probe_file(const std::filesystem::path& file, const std::function<void()>& read) {
  try {
    probe(file, read);
  } catch (const InputError& error) {
    if (!ends_in(file, {".vtp"})) throw;
    throw InputError(fmt::format("{}; VTK crashes over arrays that have not one value a cell or point", error.what()));
  }
}

}  // namespace

void probe_states(const std::vector<std::filesystem::path>& files, const StateChoice& which) {
  if (files.empty()) return;
  try {
    probe_file(files[0], [&] {
      const auto states = open_states(files);
      (void)states->read(0);
      for (const Index i : which(*states)) {
        allow_seconds(seconds_to_read(files[files.size() == 1 ? 0 : i]));
        (void)states->read(i);
      }
    });
  } catch (const InputError&) {
    if (files.size() == 1) throw;
    // Each alone, so that it is the bad one that is named.
    for (const std::filesystem::path& file : files) probe_file(file, [&] { (void)open_states({file})->read(0); });
    throw;
  }
}

}  // namespace trame::workflows
