// Any bytes as a table of fiber nodes.

#include "tests/fuzz/nodes_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::filesystem::path file = trame::test::fuzzed_file(".csv");
  trame::test::write_bytes(file, data, size);
  trame::test::read_nodes(file);
  return 0;
}
