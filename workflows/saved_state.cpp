#include "workflows/saved_state.h"

#include <fmt/format.h>

#include <charconv>

#include "micro/core/error.h"

namespace trame::workflows {

Index find_state(const micro::SnapshotReader& states, const std::string& option, const std::string& text) {
  if (states.n_increments() == 0) throw InputError("the state file holds no increment yet");
  Index number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error == std::errc() && end == text.data() + text.size()) {
    if (number >= 0 && number < states.n_increments()) return number;
    throw InputError(fmt::format("{} {}: allowed are 0 … {}", option, text, states.n_increments() - 1));
  }
  if (text == "last") return states.n_increments() - 1;
  for (Index i = states.n_increments() - 1; i >= 0; --i)
    if (states.read(i).stage == text) return i;
  throw InputError(fmt::format("{} {}: neither a number nor the name of a stage nor \"last\"; strain_post --list shows them", option, text));
}

}  // namespace trame::workflows
