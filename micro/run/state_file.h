#pragma once
/// \file
/// The states of a run while it runs.

#include <filesystem>

#include "micro/states/snapshot.h"

namespace trame::micro {

/// Under another name until the first state is in it that was not saved before, so that what it takes the place of
/// stays as it is until then; removed where that does not come.
class StateFile {
 public:
  StateFile(std::filesystem::path file, const SnapshotHeader& header);
  ~StateFile();
  StateFile(const StateFile&) = delete;
  StateFile& operator=(const StateFile&) = delete;

  /// A state that another file has.
  void repeat(const Increment& increment) { writer_.append(increment); }
  /// `continuation`: what the run goes on from there with.
  void append(const Increment& increment, const std::string& continuation);

 private:
  std::filesystem::path file_;
  SnapshotWriter writer_;
  bool in_place_ = false;
};

}  // namespace trame::micro
