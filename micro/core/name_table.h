#pragma once
/// \file
/// Names of a scene's things in their order, looked up at once however many there are.

#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "micro/core/types.h"
#include "micro/core/wildcard.h"

namespace trame {

class NameTable {
 public:
  NameTable() = default;
  /// Of equal names the first counts.
  explicit NameTable(const std::vector<std::string>& names) {
    for (const std::string& name : names) add(name);
  }

  /// Whether `name` was new.
  bool add(const std::string& name) {
    names_.push_back(name);
    return index_.emplace(name, static_cast<Index>(names_.size()) - 1).second;
  }

  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  [[nodiscard]] std::optional<Index> find(const std::string& name) const {
    const auto entry = index_.find(name);
    return entry == index_.end() ? std::nullopt : std::optional(entry->second);
  }
  /// Indices of the names that fit a pattern with wildcards, ascending.
  [[nodiscard]] std::vector<Index> fitting(const std::string& pattern) const {
    std::vector<Index> result;
    if (pattern.find_first_of("*?") == pattern.npos) {
      if (const auto only = find(pattern)) result.push_back(*only);
      return result;
    }
    for (std::size_t i = 0; i < names_.size(); ++i)
      if (matches(pattern, names_[i])) result.push_back(static_cast<Index>(i));
    return result;
  }

 private:
  std::vector<std::string> names_;
  std::unordered_map<std::string, Index> index_;
};

}  // namespace trame
