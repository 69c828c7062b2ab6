#pragma once
/// \file
/// A TOML value that knows where it stands, so that every complaint names file, key, value and what is allowed.

#include <toml++/toml.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "micro/core/name_table.h"
#include "micro/core/types.h"

namespace trame::micro {

/// What a number means: its unit inside, and how to speak of it to the user. `largest` bounds its magnitude, and
/// `smallest` what must be positive, so that products and squares of them stay numbers: far beyond any fabric.
struct Measure {
  std::string_view si_unit;
  std::string_view noun;
  std::string_view example;  ///< empty for plain numbers
  double smallest = 1e-12, largest = 1e9;
};
inline constexpr Measure plain_number{"1", "a number", ""};
inline constexpr Measure ratio{"1", "a number or a text such as \"2 %\"", ""};
inline constexpr Measure length{"m", "a length", "19 um", 1e-12, 1e6};
inline constexpr Measure angle{"rad", "an angle", "45 deg", 1e-12, 1e6};
inline constexpr Measure pressure{"Pa", "a modulus", "3 GPa", 1e-6, 1e60};
inline constexpr Measure mass_density{"kg m-3", "a density", "1.14 g/cm3", 1e-6, 1e9};
inline constexpr Measure linear_density{"kg m-1", "a linear density", "78 dtex", 1e-21, 1e9};
inline constexpr Measure per_length{"m-1", "a number per length", "37 per cm", 1e-6, 1e12};
inline constexpr Measure force{"N", "a force", "2 mN", 1e-21, 1e15};
inline constexpr Measure force_per_length{"N m-1", "a force per length", "50 N/m", 1e-15, 1e15};
inline constexpr Measure acceleration{"m s-2", "an acceleration", "9.81 m/s2", 1e-15, 1e15};
inline constexpr Measure moment{"N m", "a moment", "0.1 N mm", 1e-21, 1e15};

/// An interval of numbers, each end open or closed.
struct Range {
  std::optional<double> low, high;
  bool low_open = false, high_open = false;

  [[nodiscard]] bool contains(double x) const;
  [[nodiscard]] std::string text() const;  ///< "at least 1", "greater than -1 and less than 0.5"; empty without ends
};
[[nodiscard]] inline Range any() { return {}; }
[[nodiscard]] inline Range above(double low) { return {low, {}, true, false}; }
[[nodiscard]] inline Range at_least(double low) { return {low, {}, false, false}; }
[[nodiscard]] inline Range between(double low, double high) { return {low, high, false, false}; }
[[nodiscard]] inline Range inside(double low, double high) { return {low, high, true, true}; }
[[nodiscard]] inline Range above_up_to(double low, double high) { return {low, high, true, false}; }

/// What is allowed, as it stands in messages ("must be …") and in the schema.
[[nodiscard]] std::string allowed_quantity(const Measure& measure, const Range& range);
[[nodiscard]] std::string allowed_integer(const Range& range);
/// "a", "b" or "c", in quotes; only some of more than twelve.
[[nodiscard]] std::string allowed_names(const std::vector<std::string>& names);

/// The candidate that `name` may be a slip of, if any is near enough.
[[nodiscard]] std::optional<std::string> nearest_name(const std::string& name,
                                                      const std::vector<std::string>& candidates);
/// "; did you mean "x"?" or nothing.
[[nodiscard]] std::string suggestion(const std::string& name, const std::vector<std::string>& candidates);

class SceneValue {
 public:
  /// The root of a scene, which must outlive this object and its children.
  SceneValue(const toml::table& root, std::string file)
      : node_(&root), file_(std::move(file)), noted_(std::make_shared<Noted>()) {}

  /// Path to the value, items of lists counted from 1: stage[1].drive[2].force.
  [[nodiscard]] const std::string& key() const { return key_; }
  [[nodiscard]] const std::string& own_name() const { return own_name_; }  ///< in the table that holds it

  /// Throws InputError "file: key = value: complaint (line n)".
  [[noreturn]] void fail(std::string_view complaint) const;
  /// Notes the same, so that all mistakes of a kind can be told at once: see `fail_for_noted`.
  void note(const std::string& complaint) const;
  /// Throws what was noted in the whole scene, in the order of its lines, and then `also`; if there is anything.
  void fail_for_noted(const std::string& also = "") const;
  /// The same for a key that this table should have.
  [[noreturn]] void fail_missing(std::string_view child, std::string_view allowed) const;

  /// All of these fail with what is allowed where the value is not of the kind.
  [[nodiscard]] double quantity(const Measure& measure, const Range& range) const;
  [[nodiscard]] Index integer(const Range& range) const;
  [[nodiscard]] bool boolean() const;
  [[nodiscard]] std::string text() const;  ///< not empty, one line, no control characters
  /// Lines of a text of several, without blanks around them and without empty ones; at least one.
  [[nodiscard]] std::vector<std::string> lines(std::string_view complaint) const;
  [[nodiscard]] std::string name() const;  ///< a text without wildcards, at most max_name_bytes long
  /// Its own name in the table that holds it, where that is a name for people: [material.NAME].
  [[nodiscard]] std::string table_name() const;
  [[nodiscard]] Vec3 vector(const Measure& measure) const;
  [[nodiscard]] Index one_of(const NameTable& names, std::string_view what = "") const;  ///< which of them

  [[nodiscard]] std::vector<SceneValue> items(std::string_view allowed) const;  ///< of a list with at least one
  [[nodiscard]] std::vector<SceneValue> tables() const;                         ///< of a list of tables
  [[nodiscard]] std::vector<SceneValue> children() const;                       ///< of a table
  [[nodiscard]] std::optional<SceneValue> find(std::string_view child) const;   ///< in a table
  [[nodiscard]] bool is_list() const { return node_->is_array(); }
  [[nodiscard]] bool is_boolean() const { return node_->is_boolean(); }
  void must_be_table() const;

 private:
  using Noted = std::multimap<std::size_t, std::string>;  // by line

  SceneValue(const toml::node& node, const SceneValue& parent, std::string key, std::string own_name)
      : node_(&node), file_(parent.file_), key_(std::move(key)), own_name_(std::move(own_name)), noted_(parent.noted_) {
  }
  [[nodiscard]] std::string path_to(std::string_view child) const;
  [[nodiscard]] std::string shown() const;
  [[nodiscard]] std::string where() const;
  void check_magnitude(double value, const Measure& measure, const Range& range) const;
  void check_name_length(const std::string& name) const;

  const toml::node* node_;
  std::string file_, key_, own_name_;
  std::shared_ptr<Noted> noted_;  // of the whole scene
};

}  // namespace trame::micro
