#pragma once
/// \file
/// A key of a scene, declared once: the declaration reads it, checks it and describes it in the schema.

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "micro/core/name_table.h"
#include "micro/scene/value.h"

namespace trame::micro {

/// A key of the table that fills a T.
template <class T>
struct Key {
  std::string name;
  std::string allowed;  ///< kind, range and unit, in words
  std::string meaning;
  bool required = false;
  std::string fallback;  ///< what holds where the key is left out, in words
  std::function<void(const SceneValue&, T&)> read;

  /// Marks the key as one that the table must have.
  [[nodiscard]] Key needed() && {
    required = true;
    return std::move(*this);
  }
  /// Tells what holds without the key, where a default value does not.
  [[nodiscard]] Key otherwise(std::string text) && {
    fallback = std::move(text);
    return std::move(*this);
  }
};

/// How a value is read from TOML, told in words and shown as a default.
template <class V>
struct Kind {
  std::string allowed;
  std::function<V(const SceneValue&)> read;
  std::function<std::string(const V&)> show;
};

template <class V>
using NamedValues = std::vector<std::pair<std::string, V>>;

[[nodiscard]] inline Kind<double> quantity(const Measure& measure, const Range& range) {
  return {allowed_quantity(measure, range), [=](const SceneValue& value) { return value.quantity(measure, range); },
          [=](double x) {
            return measure.example.empty() ? fmt::format("{}", x) : fmt::format("{} {}", x, measure.si_unit);
          }};
}
[[nodiscard]] inline Kind<double> number(const Range& range) { return quantity(plain_number, range); }
[[nodiscard]] inline Kind<Index> integer(const Range& range) {
  return {allowed_integer(range), [=](const SceneValue& value) { return value.integer(range); },
          [](Index i) { return std::to_string(i); }};
}
[[nodiscard]] inline Kind<bool> boolean() {
  return {"true or false", [](const SceneValue& value) { return value.boolean(); },
          [](bool b) { return std::string(b ? "true" : "false"); }};
}
[[nodiscard]] inline Kind<std::string> free_text() {
  return {"a text", [](const SceneValue& value) { return value.text(); }, [](const std::string& s) { return s; }};
}
[[nodiscard]] inline Kind<std::string> new_name() {
  return {"a name", [](const SceneValue& value) { return value.name(); }, [](const std::string& s) { return s; }};
}
/// A name that a saved state can be called by, among the numbers of states and the word for the last one.
[[nodiscard]] inline Kind<std::string> stage_name() {
  const auto read = [](const SceneValue& value) {
    std::string name = value.name();
    if (name == "last" || name.find_first_not_of("-0123456789") == name.npos)
      value.fail("must be neither a number nor \"last\", which name saved states");
    return name;
  };
  return {"a name, neither a number nor \"last\"", read, [](const std::string& s) { return s; }};
}
[[nodiscard]] inline Kind<Vec3> vector(const Measure& measure) {
  return {fmt::format("a list of 3, each {}", allowed_quantity(measure, any())),
          [=](const SceneValue& value) { return value.vector(measure); },
          [=](const Vec3& v) { return fmt::format("[{}, {}, {}] in {}", v[0], v[1], v[2], measure.si_unit); }};
}
/// One of a few words.
template <class V>
[[nodiscard]] Kind<V> choice(const NamedValues<V>& values) {
  NameTable names;
  for (const auto& entry : values) names.add(entry.first);
  const auto read = [=](const SceneValue& value) { return values[value.one_of(names)].second; };
  const auto show = [=](const V& v) {
    const auto entry = std::find_if(values.begin(), values.end(), [&](const auto& e) { return e.second == v; });
    return entry == values.end() ? std::string() : fmt::format("\"{}\"", entry->first);
  };
  return {allowed_names(names.names()), read, show};
}
/// The name of something that the scene has; its index.
[[nodiscard]] inline Kind<Index> reference(const std::string& what, const NameTable& names) {
  const auto known = std::make_shared<const NameTable>(names);
  return {"the name of " + what, [=](const SceneValue& value) { return value.one_of(*known, what); },
          [](Index) { return std::string(); }};
}
/// The name of something that the scene has.
[[nodiscard]] inline Kind<std::string> existing_name(const std::string& what, const NameTable& names) {
  const auto known = std::make_shared<const NameTable>(names);
  return {"the name of " + what, [=](const SceneValue& value) { return known->names()[value.one_of(*known, what)]; },
          [](const std::string& s) { return s; }};
}
/// A name with wildcards that fits at least one of `names`.
[[nodiscard]] inline Kind<std::string> wildcard(const std::string& what, const NameTable& table) {
  const auto read = [what, known = std::make_shared<const NameTable>(table)](const SceneValue& value) {
    std::string pattern = value.text();
    const std::vector<std::string>& names = known->names();
    if (known->fitting(pattern).empty())
      value.fail(names.empty() ? fmt::format("must fit the name of {}, but the scene has none", what)
                               : fmt::format("must fit the name of {}{}{} {}", what, suggestion(pattern, names),
                                             nearest_name(pattern, names) ? " There are" : ":", allowed_names(names)));
    return pattern;
  };
  return {fmt::format("the name of {}, with * for any characters and ? for one", what), read,
          [](const std::string& s) { return s; }};
}
/// A list of one or more; with `or_single`, also one value without brackets.
template <class V>
[[nodiscard]] Kind<std::vector<V>> list(const Kind<V>& item, bool or_single = false) {
  const std::string allowed = or_single ? item.allowed + "; or a list of them" : "a list, each " + item.allowed;
  const auto read = [=](const SceneValue& value) {
    if (or_single && !value.is_list()) return std::vector<V>{item.read(value)};
    std::vector<V> values;
    for (const SceneValue& entry : value.items(allowed)) values.push_back(item.read(entry));
    return values;
  };
  return {allowed, read, [](const std::vector<V>&) { return std::string(); }};
}
/// A value that a later step reads, because what is allowed depends on other keys.
[[nodiscard]] inline Kind<SceneValue> unread(std::string allowed) {
  return {std::move(allowed), [](const SceneValue& value) { return value; }, {}};
}

namespace detail {
template <class V>
struct IsOptional : std::false_type {};
template <class V>
struct IsOptional<std::optional<V>> : std::true_type {};
}  // namespace detail

/// Declares a key. `field` is a pointer to a member of T, or a function from T& to a reference; the default is what a
/// new T holds.
template <class T, class V, class Field>
[[nodiscard]] Key<T> key(std::string name, Field field, Kind<V> kind, std::string meaning) {
  T fresh{};
  std::string fallback;
  using Stored = std::remove_cvref_t<decltype(std::invoke(field, fresh))>;
  if constexpr (!detail::IsOptional<Stored>::value) fallback = "default: " + kind.show(std::invoke(field, fresh));
  const auto read = [field, read_value = kind.read](const SceneValue& value, T& target) {
    std::invoke(field, target) = read_value(value);
  };
  return {std::move(name), std::move(kind.allowed), std::move(meaning), false, std::move(fallback), read};
}

/// Reads a table by its keys into a T. `also` are keys of the table that others read.
/// Fails for keys that are missing, and notes those that are unknown.
template <class T>
void read_table(const SceneValue& table, const std::vector<Key<T>>& keys, const std::vector<std::string>& also,
                T& target) {
  std::vector<std::string> known = also;
  for (const Key<T>& key : keys) known.push_back(key.name);
  for (const SceneValue& child : table.children())
    if (std::find(known.begin(), known.end(), child.own_name()) == known.end())
      child.note(
          fmt::format("unknown key{}; must be one of {}", suggestion(child.own_name(), known), allowed_names(known)));
  for (const Key<T>& key : keys) {
    if (const auto value = table.find(key.name))
      key.read(*value, target);
    else if (key.required)
      table.fail_missing(key.name, key.allowed);
  }
}

}  // namespace trame::micro
