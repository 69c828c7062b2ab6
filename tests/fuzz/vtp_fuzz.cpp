// Any bytes as polylines of VTK. As the programs do, a process apart reads them first, since it is VTK that stumbles
// over arrays of other sizes than it is told; what that survives is read here.

#include <vtkNew.h>
#include <vtkXMLPolyDataReader.h>

#include "tests/fuzz/nodes_fuzz.h"
#include "workflows/program/file_probe.h"

namespace {

void read_with_vtk(const std::filesystem::path& file) {
  const vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::filesystem::path file = trame::test::fuzzed_file(".vtp");
  trame::test::write_bytes(file, data, size);
  try {
    trame::workflows::probe(
        file.string(), [] { read_with_vtk(file); }, 5);
  } catch (const trame::InputError&) {  // VTK does not survive it
    return 0;
  }
  trame::test::read_nodes(file);
  return 0;
}
