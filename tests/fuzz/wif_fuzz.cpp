// Any bytes as a weaving draft: a draft, or an InputError.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "micro/core/error.h"
#include "micro/scene/draft.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto draft =
        trame::micro::parse_draft(std::string_view(reinterpret_cast<const char*>(data), size), "fuzz.wif");
    (void)trame::micro::pattern_of(draft, 1, 2, 7, 5);
  } catch (const trame::InputError&) {  // what is meant
  }
  return 0;
}
