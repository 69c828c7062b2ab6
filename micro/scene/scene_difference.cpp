#include "micro/scene/scene_difference.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <sstream>

#include "micro/core/text.h"

namespace trame::micro {

namespace {

std::string text_of(const toml::node* node) {
  if (!node) return "not given";
  if (const auto* number = node->as_floating_point()) return fmt::format("{}", number->get());
  std::ostringstream text;
  node->visit([&](const auto& value) { text << value; });
  return text.str();
}

std::string differing(const std::string& key, const toml::node* there, const toml::node* here);

std::string in_tables(const std::string& key, const toml::table& there, const toml::table& here) {
  const auto of = [&](const toml::table& keys) {
    for (const auto& [name, node] : keys) {
      const std::string inside = fmt::format("{}.{}", key, name.str());
      if (std::string found = differing(inside, there.get(name), here.get(name)); !found.empty()) return found;
    }
    return std::string();
  };
  std::string found = of(there);
  return found.empty() ? of(here) : found;
}

std::string in_arrays(const std::string& key, const toml::array& there, const toml::array& here) {
  for (std::size_t i = 0; i < std::max(there.size(), here.size()); ++i)
    if (std::string found = differing(fmt::format("{}[{}]", key, i + 1), there.get(i), here.get(i)); !found.empty())
      return found;
  return {};
}

/// Empty where they are the same.
std::string differing(const std::string& key, const toml::node* there, const toml::node* here) {
  if (!there && !here) return {};
  if (there && here && there->is_table() && here->is_table())
    return in_tables(key, *there->as_table(), *here->as_table());
  if (there && here && there->is_array_of_tables() && here->is_array_of_tables())
    return in_arrays(key, *there->as_array(), *here->as_array());
  const std::string theirs = text_of(there), ours = text_of(here);
  if (there && here && there->type() == here->type() && theirs == ours) return {};
  return fmt::format("{} is {} there and {} here", printable(key), printable(shortened(theirs)),
                     printable(shortened(ours)));
}

}  // namespace

std::string scene_difference(const std::string& there, const std::string& here,
                             const std::vector<std::string_view>& tables) {
  try {
    const toml::table theirs = toml::parse(there), ours = toml::parse(here);
    for (const std::string_view table : tables)
      if (std::string found = differing(std::string(table), theirs.get(table), ours.get(table)); !found.empty())
        return found;
  } catch (const toml::parse_error&) {  // of a text that is no scene
  }
  return {};
}

}  // namespace trame::micro
