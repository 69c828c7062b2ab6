#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <string_view>

#include "micro/core/error.h"
#include "micro/core/text.h"
#include "workflows/strains/fiber_nodes.h"

namespace trame::workflows {
namespace {

namespace fs = std::filesystem;

/// Where in a file a message points.
struct Place {
  const fs::path& file;
  std::size_t line = 0;

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{}, line {}: {}", file.string(), line, what));
  }
};

constexpr std::size_t max_line_bytes = 10'000;

/// What separates the fields of a table, by its first line: commas, else semicolons, else tabs, else blanks.
char separator_of(const std::string& line) {
  for (const char c : {',', ';', '\t'})
    if (line.find(c) != line.npos) return c;
  return ' ';
}

/// A quoted field may hold separators, and a quote twice.
std::vector<std::string> fields_of(const std::string& line, char separator) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    const bool separates = !quoted && (c == separator || (separator == ' ' && c == '\t'));
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
      fields.back() += line[i++];
    else if (c == '"')
      quoted = !quoted;
    else if (!separates)
      fields.back() += c;
    else if (separator != ' ' || !fields.back().empty())
      fields.emplace_back();
  }
  for (std::string& field : fields) {
    const auto blank = [](unsigned char c) { return std::isspace(c) != 0; };
    field.erase(field.begin(), std::find_if_not(field.begin(), field.end(), blank));
    field.erase(std::find_if_not(field.rbegin(), field.rend(), blank).base(), field.end());
  }
  if (separator == ' ' && fields.back().empty()) fields.pop_back();
  return fields;
}

std::optional<double> number(const std::string& text) {
  double value = 0;
  const char* first = text.data() + (text.starts_with('+') ? 1 : 0);
  const auto [rest, status] = std::from_chars(first, text.data() + text.size(), value);
  if (status != std::errc() || rest != text.data() + text.size()) return std::nullopt;
  return value;
}

/// What a column holds.
enum class Column : std::uint8_t { x, y, z, fiber, yarn, radius, unknown };

/// ParaView writes "Points:0" for x.
Column column_of(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  if (name.size() == 8 && (name.starts_with("points:") || name.starts_with("points_")))
    name = std::string(1, static_cast<char>('x' + name.back() - '0'));
  if (name == "x" || name == "y" || name == "z") return static_cast<Column>(name[0] - 'x');
  if (names_fibers(name)) return Column::fiber;
  if (name == "radius") return Column::radius;
  return names_yarns(name) ? Column::yarn : Column::unknown;
}

/// The columns of a table without names, by their number.
std::vector<Column> unnamed_columns(const Place& place, std::size_t n) {
  using enum Column;
  if (n == 4) return {fiber, x, y, z};
  if (n == 5) return {yarn, fiber, x, y, z};
  place.fail(fmt::format("{} numbers; without column names a line holds fiber, x, y, z or yarn, fiber, x, y, z", n));
}

/// One table: its fibers in the order in which they begin, and what it calls them.
struct Table {
  FiberList list;
  std::vector<Vec3> positions;
  std::vector<std::string> fiber, yarn;  ///< n_fibers, labels
  std::vector<std::string> remarks;
};

/// Reads line by line.
class TableReader {
 public:
  explicit TableReader(const fs::path& file) : place_{file} {}

  Table read() {
    if (!fs::exists(place_.file)) throw InputError(place_.file.string() + ": no such file");
    if (!fs::is_regular_file(place_.file)) throw InputError(place_.file.string() + ": not a file");
    std::ifstream stream(place_.file, std::ios::binary);
    if (!stream) throw InputError(place_.file.string() + ": cannot be read");
    std::string line(max_line_bytes, '\0');
    while (stream.getline(line.data(), static_cast<std::streamsize>(line.size())) || stream.gcount() > 0) {
      ++place_.line;
      if (stream.fail() && !stream.eof()) place_.fail(fmt::format("longer than {} bytes", max_line_bytes));
      const std::size_t n_read = static_cast<std::size_t>(stream.gcount()) - (stream.eof() ? 0 : 1);
      take(line.substr(0, n_read));
    }
    finish();
    return std::move(table_);
  }

 private:
  void take(std::string line) {
    if (line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);
    if (line.find('\0') != line.npos) place_.fail("holds a zero byte; must be a table as text in UTF-8");
    if (const auto first = line.find_first_not_of(" \t\r"); first == line.npos) return;
    if (line.starts_with('#')) return take_comment(line);
    if (separator_ == 0) separator_ = separator_of(line);
    const std::vector<std::string> fields = fields_of(line, separator_);
    if (columns_.empty() && std::none_of(fields.begin(), fields.end(), [](const auto& f) { return number(f); }))
      return take_names(fields);
    if (columns_.empty()) columns_ = unnamed_columns(place_, fields.size());
    take_node(fields);
  }
  /// "# unit: um"
  void take_comment(const std::string& line) {
    const auto at = line.find("unit:");
    if (at == line.npos) return;
    std::string unit = line.substr(at + 5);
    unit.erase(0, unit.find_first_not_of(" \t"));
    unit.erase(unit.find_last_not_of(" \t\r") + 1);
    metres_ = metres(fmt::format("{}, line {}", place_.file.string(), place_.line), unit);
    has_unit_ = true;
  }
  void take_names(const std::vector<std::string>& names) {
    std::string others;
    for (const std::string& name : names) {
      const Column column = column_of(name);
      if (column != Column::unknown && std::find(columns_.begin(), columns_.end(), column) != columns_.end())
        place_.fail(fmt::format("a second column \"{}\"", printable(name)));
      columns_.push_back(column);
      if (column == Column::unknown) others += fmt::format("{}\"{}\"", others.empty() ? "" : ", ", printable(name));
    }
    for (const auto& [column, name] :
         {std::pair{Column::x, "x"}, {Column::y, "y"}, {Column::z, "z"}, {Column::fiber, "fiber"}})
      if (std::find(columns_.begin(), columns_.end(), column) == columns_.end())
        place_.fail(
            fmt::format("no column \"{}\"; a table of fiber nodes has the columns fiber, x, y, z and may have "
                        "yarn and radius, a unit in a line \"# unit: um\" before; other columns here: {}",
                        name, others.empty() ? "none" : others));
    if (!others.empty()) table_.remarks.push_back(fmt::format("columns that are not read: {}", others));
  }
  void take_node(const std::vector<std::string>& fields) {
    if (fields.size() != columns_.size())
      place_.fail(fmt::format("{} fields, expected {}", fields.size(), columns_.size()));
    Vec3 x = Vec3::Zero();
    std::string fiber, yarn = "0";
    double radius = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t c = 0; c < fields.size(); ++c) {
      if (columns_[c] == Column::fiber) fiber = label(fields[c]);
      if (columns_[c] == Column::yarn) yarn = label(fields[c]);
      if (columns_[c] == Column::radius) radius = value(fields[c]);
      if (columns_[c] <= Column::z) x[static_cast<int>(columns_[c])] = value(fields[c]);
    }
    if (table_.fiber.empty() || table_.fiber.back() != fiber || table_.yarn.back() != yarn)
      begin_fiber(fiber, yarn, radius);
    table_.positions.push_back(x);
    if (table_.positions.size() > max_file_nodes) place_.fail(fmt::format("more than {} nodes", max_file_nodes));
  }
  /// A fiber's number may begin again in each yarn.
  void begin_fiber(const std::string& fiber, const std::string& yarn, double radius) {
    if (!begun_.emplace(std::pair{yarn, fiber}, place_.line).second)
      place_.fail(
          fmt::format("fiber {} again, after another one: the nodes of a fiber are on lines one after the other",
                      printable(fiber)));
    table_.list.start.push_back(static_cast<Index>(table_.positions.size()));
    table_.list.radius.push_back(radius);
    table_.fiber.push_back(fiber);
    table_.yarn.push_back(yarn);
  }
  void finish() {
    if (table_.fiber.empty()) throw InputError(place_.file.string() + ": holds no fiber nodes");
    table_.list.start.push_back(static_cast<Index>(table_.positions.size()));
    make_yarns(table_.yarn, table_.list);
    for (Vec3& x : table_.positions) x *= metres_;
    for (double& r : table_.list.radius) r *= metres_;
    check_positions(place_.file.string(), table_.positions);
    check_start(place_.file.string(), table_.list.start);
    const std::string on_size = remark_on_size(table_.positions, "a line \"# unit: um\"");
    if (!has_unit_ && !on_size.empty()) table_.remarks.push_back(on_size);
  }
  [[nodiscard]] double value(const std::string& field) const {
    const std::optional<double> x = number(field);
    if (!x || !std::isfinite(*x)) place_.fail(fmt::format("\"{}\" is not a finite number", printable(field)));
    return *x;
  }
  /// 3 and 3.0 are the same label.
  [[nodiscard]] std::string label(const std::string& field) const {
    check_yarn_name(fmt::format("{}, line {}", place_.file.string(), place_.line), field);
    const std::optional<double> x = number(field);
    constexpr double largest = 1e15;
    return x && *x == std::floor(*x) && std::abs(*x) < largest ? fmt::format("{:.0f}", *x) : field;
  }

  Place place_;
  Table table_;
  std::vector<Column> columns_;
  std::map<std::pair<std::string, std::string>, std::size_t> begun_;
  char separator_ = 0;  // not known yet
  double metres_ = 1;
  bool has_unit_ = false;
};

class TableNodes : public meso::FiberStates {
 public:
  explicit TableNodes(const std::vector<fs::path>& files)
      : files_(files), first_(TableReader(files[0]).read()), order_(files[0].string(), first_.list, first_.positions) {
    first_.positions = {};
    header_.mesh = order_.mesh();
  }

  [[nodiscard]] std::string name() const override { return files_[0].string(); }
  [[nodiscard]] const micro::SnapshotHeader& header() const override { return header_; }
  [[nodiscard]] Index n_increments() const override { return static_cast<Index>(files_.size()); }
  [[nodiscard]] std::vector<std::string> remarks() const override {
    std::vector<std::string> all = first_.remarks;
    if (const std::string turned = order_.remark(); !turned.empty()) all.push_back(turned);
    return all;
  }
  [[nodiscard]] micro::Increment read(Index i) const override {
    if (i < 0 || i >= n_increments())
      throw InputError(fmt::format("no state {}: there are {} files, counted from 0", i, files_.size()));
    const Table table = TableReader(files_[i]).read();
    if (table.list.start != first_.list.start || table.yarn != first_.yarn)
      throw InputError(fmt::format("{}: its fibers differ from those of {} in number, nodes or yarns",
                                   files_[i].string(), files_[0].string()));
    micro::Increment increment;
    increment.stage = made_name(files_[i].stem().string());
    increment.fibers = order_.configuration(table.positions);
    return increment;
  }

 private:
  std::vector<fs::path> files_;
  Table first_;  ///< without positions
  NodeOrder order_;
  micro::SnapshotHeader header_;
};

}  // namespace

std::unique_ptr<meso::FiberStates> open_table_nodes(const std::vector<fs::path>& files) {
  return std::make_unique<TableNodes>(files);
}

}  // namespace trame::workflows
