#include "micro/scene/value.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <sstream>
#include <utility>

#include "micro/core/error.h"
#include "micro/core/quantity.h"
#include "micro/core/text.h"

namespace trame::micro {

bool Range::contains(double x) const {
  if (!std::isfinite(x)) return false;
  if (low && (x < *low || (low_open && x == *low))) return false;
  return !(high && (x > *high || (high_open && x == *high)));
}

std::string Range::text() const {
  const std::string from = low ? fmt::format("{} {}", low_open ? "greater than" : "at least", *low) : "";
  const std::string to = high ? fmt::format("{} {}", high_open ? "less than" : "at most", *high) : "";
  return from + (low && high ? " and " : "") + to;
}

namespace {

/// "a length" and "greater than 0", "an integer" and "of at least 1".
std::string with_range(std::string_view noun, const Range& range) {
  const std::string limits = range.text();
  if (limits.empty()) return std::string(noun);
  return fmt::format("{} {}{}", noun, range.low && !range.low_open ? "of " : "", limits);
}

}  // namespace

std::string allowed_quantity(const Measure& measure, const Range& range) {
  const std::string allowed = with_range(measure.noun, range);
  return measure.example.empty() ? allowed : fmt::format("{} with its unit, such as \"{}\"", allowed, measure.example);
}

std::string allowed_integer(const Range& range) { return with_range("an integer", range); }

std::string allowed_names(const std::vector<std::string>& names) {
  constexpr std::size_t most = 12;
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names.size() > most && i == most / 2) {
      text += fmt::format(", ... ({} in all)", names.size());
      i = names.size() - 1;
    }
    text += fmt::format("{}\"{}\"", i == 0 ? "" : (i + 1 == names.size() ? " or " : ", "), names[i]);
  }
  return text;
}

namespace {

/// Levenshtein distance: the number of letters to insert, delete or replace.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = std::exchange(row[j + 1], std::min({row[j + 1] + 1, row[j] + 1, replaced}));
    }
  }
  return row.back();
}

}  // namespace

std::optional<std::string> nearest_name(const std::string& name, const std::vector<std::string>& candidates) {
  std::optional<std::string> nearest;
  std::size_t best = std::max<std::size_t>(2, name.size() / 3) + 1;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(name, candidate);
    if (distance < std::min(best, candidate.size())) {
      best = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

std::string suggestion(const std::string& name, const std::vector<std::string>& candidates) {
  const auto nearest = nearest_name(name, candidates);
  return nearest ? fmt::format("; did you mean \"{}\"?", *nearest) : "";
}

namespace {

/// A key as TOML writes it: bare, or in quotes.
std::string written_key(std::string_view key) {
  constexpr std::string_view bare = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
  if (!key.empty() && key.find_first_not_of(bare) == key.npos) return std::string(key);
  return fmt::format("\"{}\"", shortened(printable(key)));
}

}  // namespace

std::string SceneValue::path_to(std::string_view child) const {
  return key_.empty() ? written_key(child) : fmt::format("{}.{}", key_, written_key(child));
}

namespace {

/// A value as a user would write it. TOML++ itself prints 0.3 with 17 digits.
std::string written(const toml::node& node) {
  if (const auto* text = node.as_string()) return fmt::format("\"{}\"", printable(text->get()));
  if (const auto* number = node.as_floating_point()) {
    const std::string digits = fmt::format("{}", number->get());
    return digits.find_first_not_of("-0123456789") == digits.npos ? digits + ".0" : digits;
  }
  std::ostringstream stream;
  if (const auto* array = node.as_array()) {
    for (const toml::node& item : *array) stream << (stream.tellp() > 0 ? ", " : "") << written(item);
    return fmt::format("[{}]", stream.str());
  }
  node.visit([&](const auto& value) { stream << value; });
  return stream.str();
}

bool is_plain_number(const std::string& text) {
  double value = 0;
  const auto [rest, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  return status == std::errc() && rest == text.data() + text.size();
}

}  // namespace

std::string SceneValue::shown() const {
  if (node_->is_table() || node_->is_array_of_tables()) return "";
  return " = " + shortened(written(*node_));
}

std::string SceneValue::where() const { return key_.empty() ? "scene" : key_ + shown(); }

void SceneValue::fail(std::string_view complaint) const {
  throw InputError(fmt::format("{}: {}: {} (line {})", file_, where(), complaint, node_->source().begin.line));
}

void SceneValue::note(const std::string& complaint) const {
  const std::size_t line = node_->source().begin.line;
  noted_->emplace(line, fmt::format("{}: {}: {} (line {})", file_, where(), complaint, line));
}

void SceneValue::fail_for_noted(const std::string& also) const {
  constexpr std::size_t most = 30;
  std::string text;
  std::size_t n = 0;
  for (const auto& [line, complaint] : *noted_)
    if (n++ < most) text += (text.empty() ? "" : "\n") + complaint;
  if (n > most) text += fmt::format("\n{}: and {} more unknown keys", file_, n - most);
  if (!also.empty()) text += (text.empty() ? "" : "\n") + also;
  if (!text.empty()) throw InputError(text);
}

void SceneValue::fail_missing(std::string_view child, std::string_view allowed) const {
  throw InputError(
      fmt::format("{}: {}: missing; must be {} (line {})", file_, path_to(child), allowed, node_->source().begin.line));
}

double SceneValue::quantity(const Measure& measure, const Range& range) const {
  const std::string must_be = "must be " + allowed_quantity(measure, range);
  double value = 0;
  if (const auto* text = node_->as_string()) {
    if (measure.noun == plain_number.noun && is_plain_number(text->get()))
      fail(fmt::format("must be a plain number, not a text: without quotes; {}", must_be));
    try {
      value = parse_quantity(text->get(), measure.si_unit);
    } catch (const InputError& error) {
      fail(fmt::format("{}; {}", error.what(), must_be));
    }
  } else if (node_->is_number() && measure.si_unit == "1") {
    value = *node_->value<double>();
  } else {
    fail(must_be);
  }
  if (!range.contains(value)) fail(must_be);
  check_magnitude(value, measure, range);
  return value;
}

void SceneValue::check_magnitude(double value, const Measure& measure, const Range& range) const {
  const std::string unit = measure.example.empty() ? "" : fmt::format(" {}", measure.si_unit);
  if (std::abs(value) > measure.largest) fail(fmt::format("must be at most {:g}{}", measure.largest, unit));
  const bool is_positive = range.low && *range.low == 0 && value > 0;
  if (is_positive && value < measure.smallest)
    fail(fmt::format("must be at least {:g}{}{}", measure.smallest, unit, range.low_open ? "" : ", or 0"));
}

Index SceneValue::integer(const Range& range) const {
  const auto* value = node_->as_integer();
  const bool fits = value && std::in_range<Index>(value->get()) && range.contains(static_cast<double>(value->get()));
  if (!fits) fail("must be " + allowed_integer(range));
  return static_cast<Index>(value->get());
}

bool SceneValue::boolean() const {
  if (!node_->is_boolean()) fail("must be true or false");
  return node_->as_boolean()->get();
}

std::string SceneValue::text() const {
  if (!node_->is_string() || node_->as_string()->get().empty()) fail("must be a text in quotes");
  const std::string& text = node_->as_string()->get();
  if (!is_plain(text)) fail("must be a text of one line without control characters");
  if (text.size() > max_text_bytes) fail(fmt::format("must be a text of at most {} bytes", max_text_bytes));
  return text;
}

std::vector<std::string> SceneValue::lines(std::string_view complaint) const {
  if (!node_->is_string()) fail(complaint);
  std::vector<std::string> lines;
  std::istringstream stream(node_->as_string()->get());
  for (std::string line; std::getline(stream, line);) {
    constexpr const char* blank = " \t\r";
    const auto first = line.find_first_not_of(blank);
    if (first != line.npos) lines.push_back(line.substr(first, line.find_last_not_of(blank) - first + 1));
  }
  if (lines.empty()) fail(complaint);
  return lines;
}

std::string SceneValue::name() const {
  const std::string name = text();
  if (name.find_first_of("*?") != name.npos) fail("must be a name without the wildcards * and ?");
  check_name_length(name);
  return name;
}

std::string SceneValue::table_name() const {
  if (own_name_.empty()) fail("must have a name that is not empty");
  if (!is_plain(own_name_)) fail("must have a name of one line without control characters");
  check_name_length(own_name_);
  return own_name_;
}

void SceneValue::check_name_length(const std::string& name) const {
  if (name.size() > max_name_bytes) fail(fmt::format("must be a name of at most {} bytes", max_name_bytes));
}

Vec3 SceneValue::vector(const Measure& measure) const {
  const std::string allowed = fmt::format("a list of 3, each {}", allowed_quantity(measure, any()));
  const auto components = items(allowed);
  if (components.size() != 3) fail("must be " + allowed);
  Vec3 v;
  for (int i = 0; i < 3; ++i) v[i] = components[i].quantity(measure, any());
  return v;
}

Index SceneValue::one_of(const NameTable& table, std::string_view what) const {
  const std::vector<std::string>& names = table.names();
  const auto* name = node_->as_string();
  if (const auto found = name ? table.find(name->get()) : std::nullopt) return *found;
  const std::string start = what.empty() ? "must be " : fmt::format("must be the name of {}: ", what);
  if (!name) fail(start + allowed_names(names));
  if (names.empty()) fail(fmt::format("must be the name of {}, but the scene has none", what));
  fail(start + allowed_names(names) + suggestion(name->get(), names));
}

std::vector<SceneValue> SceneValue::items(std::string_view allowed) const {
  const auto* array = node_->as_array();
  if (!array || array->empty()) fail(fmt::format("must be {}", allowed));
  std::vector<SceneValue> values;
  for (std::size_t i = 0; i < array->size(); ++i)
    values.push_back(SceneValue(*array->get(i), *this, fmt::format("{}[{}]", key_, i + 1), own_name_));
  return values;
}

std::vector<SceneValue> SceneValue::tables() const {
  const std::string allowed = fmt::format("a list of tables, written [[{}]]", own_name_);
  std::vector<SceneValue> values = items(allowed);
  if (!node_->is_array_of_tables()) fail("must be " + allowed);
  return values;
}

void SceneValue::must_be_table() const {
  if (!node_->is_table()) fail(fmt::format("must be a table, written [{}]", key_));
}

std::vector<SceneValue> SceneValue::children() const {
  must_be_table();
  std::vector<SceneValue> values;
  for (const auto& [name, node] : *node_->as_table())
    values.push_back(SceneValue(node, *this, path_to(name.str()), std::string(name.str())));
  return values;
}

std::optional<SceneValue> SceneValue::find(std::string_view child) const {
  must_be_table();
  const toml::node* node = node_->as_table()->get(child);
  if (!node) return std::nullopt;
  return SceneValue(*node, *this, path_to(child), std::string(child));
}

}  // namespace trame::micro
