#pragma once
/// \file
/// Names with wildcards, as scenes use them to point at fibers and bodies.

#include <string_view>

namespace trame {

/// Whether `name` fits `pattern`, in which * stands for any characters, also none and also '/', and ? for exactly one.
[[nodiscard]] inline bool matches(std::string_view pattern, std::string_view name) {
  constexpr auto none = std::string_view::npos;
  std::size_t p = 0, n = 0, star = none, resume = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      resume = n;
    } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == name[n])) {
      ++p;
      ++n;
    } else if (star != none) {  // let the last * take one character more
      p = star + 1;
      n = ++resume;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == none;
}

}  // namespace trame
