#include "workflows/program/output_directory.h"

#include <gtest/gtest.h>

#include "micro/core/error.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"

namespace trame::workflows {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

TEST(OutputDirectory, IsCreatedWithItsParents) {
  const TemporaryFolder folder;
  const OutputDirectory out(folder / "results/plain", OutputDirectory::Earlier::refused);
  EXPECT_TRUE(fs::is_directory(folder / "results/plain"));
  EXPECT_EQ(out.states(), folder / "results/plain/states.h5");
}

TEST(OutputDirectory, MayExistWhereItIsEmpty) {
  const TemporaryFolder folder;
  EXPECT_NO_THROW(OutputDirectory(folder.path(), OutputDirectory::Earlier::refused));
}

TEST(OutputDirectory, IsRefusedWhereItHoldsAnything) {
  const TemporaryFolder folder;
  test::write_text(folder / "notes.txt", "mine");
  EXPECT_THROW(OutputDirectory(folder.path(), OutputDirectory::Earlier::refused), InputError);
  EXPECT_EQ(test::read_text(folder / "notes.txt"), "mine");
}

TEST(OutputDirectory, OverwritesOnlyWhatARunWrites) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "vtk");
  fs::create_directory(folder / "yarns");
  const auto ours = {"states.h5",        "summary.json",         "curves.csv",          "branches.csv",
                     "report.html",      "vtk/fibers.pvd",       "vtk/fibers_0012.vtp", "vtk/yarns_0001.vtu",
                     "vtk/surfaces.pvd", "vtk/surfaces_0003.vtp"};
  const auto theirs = {"notes.txt",           "states.h5.bak",   "vtk/view.pvsm",
                       "vtk/fibers_best.vtp", "yarns/states.h5", "fibers.pvd"};
  for (const char* file : ours) test::write_text(folder / file, "old");
  for (const char* file : theirs) test::write_text(folder / file, "mine");
  const OutputDirectory out(folder.path(), OutputDirectory::Earlier::removed);
  for (const char* file : ours) EXPECT_FALSE(fs::exists(folder / file)) << file;
  for (const char* file : theirs) EXPECT_EQ(test::read_text(folder / file), "mine") << file;
}

TEST(OutputDirectory, IsRefusedWhereItIsAFileOrBelowOne) {
  const TemporaryFolder folder;
  test::write_text(folder / "file", "mine");
  EXPECT_THROW(OutputDirectory(folder / "file", OutputDirectory::Earlier::removed), InputError);
  EXPECT_THROW(OutputDirectory(folder / "file/results", OutputDirectory::Earlier::removed), InputError);
  EXPECT_EQ(test::read_text(folder / "file"), "mine");
}

TEST(WholeFile, ReplacesTheOldOneAndLeavesNoOther) {
  const TemporaryFolder folder;
  write_whole_file(folder / "summary.json", "first, longer");
  write_whole_file(folder / "summary.json", "second");
  EXPECT_EQ(test::read_text(folder / "summary.json"), "second");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

TEST(WholeFile, SaysWhereItCannotBeWritten) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_whole_file(folder / "missing/summary.json", ""), std::runtime_error);
}

}  // namespace
}  // namespace trame::workflows
