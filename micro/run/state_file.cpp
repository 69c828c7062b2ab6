#include "micro/run/state_file.h"

#include <utility>

#include "micro/core/whole_file.h"

namespace trame::micro {

namespace {

/// Where an earlier run may have left one.
std::filesystem::path cleared(const std::filesystem::path& file) {
  std::error_code ignored;
  std::filesystem::remove(file, ignored);
  return file;
}

}  // namespace

StateFile::StateFile(std::filesystem::path file, const SnapshotHeader& header)
    : file_(std::move(file)), writer_(cleared(part_of(file_)), header) {}

StateFile::~StateFile() {
  if (!in_place_) (void)cleared(part_of(file_));
}

void StateFile::append(const Increment& increment, const std::string& continuation) {
  writer_.append(increment, continuation);
  if (!in_place_) writer_.rename(file_);
  in_place_ = true;
}

}  // namespace trame::micro
