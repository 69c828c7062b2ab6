#include "tests/fuzz/nodes_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return trame::test::read_as_nodes(data, size, ".vtp");
}
