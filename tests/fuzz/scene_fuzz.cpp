// Any bytes as a scene: a scene, or an InputError.

#include <cstddef>
#include <cstdint>
#include <string>

#include "micro/core/error.h"
#include "micro/scene/scene.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    (void)trame::micro::parse_scene(std::string(reinterpret_cast<const char*>(data), size), "fuzz.toml");
  } catch (const trame::InputError&) {  // what is meant
  }
  return 0;
}
