#include "workflows/program/saved_state.h"

#include <fmt/format.h>

#include <charconv>

#include "micro/core/error.h"

namespace trame::workflows {

Index find_state(const meso::FiberStates& states, const std::string& option, const std::string& text) {
  if (states.n_increments() == 0) throw InputError(fmt::format("{}: holds no increment yet", states.name()));
  const Index last = states.n_increments() - 1;
  Index number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (end == text.data() + text.size() && !text.empty()) {
    if (error == std::errc() && number >= 0 && number <= last) return number;
    throw InputError(fmt::format("{} {}: allowed are 0 … {}", option, text, last));
  }
  if (text == "last") return last;
  for (Index i = last; i >= 0; --i)
    if (states.read(i).stage == text) return i;
  throw InputError(fmt::format(
      "{} {}: neither a number nor the name of a stage nor \"last\"; strain_post --list shows them", option, text));
}

}  // namespace trame::workflows
