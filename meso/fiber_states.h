#pragma once
/// \file
/// States of fibers to analyse, whatever wrote them: a run, another code, tomography.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "micro/states/snapshot.h"

namespace trame::meso {

/// States of the same fibers, read one by one: none is kept here.
class FiberStates {
 public:
  FiberStates() = default;
  virtual ~FiberStates() = default;
  FiberStates(const FiberStates&) = delete;
  FiberStates& operator=(const FiberStates&) = delete;

  /// What messages call these states: their file.
  [[nodiscard]] virtual std::string name() const = 0;
  /// Always has the mesh. Where it has no version, no run of this program made the states, and nothing is known of
  /// contacts and bodies.
  [[nodiscard]] virtual const micro::SnapshotHeader& header() const = 0;
  [[nodiscard]] virtual Index n_increments() const = 0;
  /// How states from elsewhere were understood where that is not plain from the file, for a user to check.
  [[nodiscard]] virtual std::vector<std::string> remarks() const { return {}; }
  /// State i, 0 ≤ i < n_increments(); 0 is the reference. Positions are complete and finite. Throws InputError.
  [[nodiscard]] virtual micro::Increment read(Index i) const = 0;
};

/// The states of a run.
class RunStates : public FiberStates {
 public:
  /// Throws InputError for a file that is not a state file.
  explicit RunStates(const std::filesystem::path& file)
      : name_(file.string()), reader_(std::make_shared<const micro::SnapshotReader>(file)) {}
  /// Looks at a reader that somebody else keeps open: a pointer that owns nothing.
  explicit RunStates(const micro::SnapshotReader& reader)
      : name_(reader.header().scene_name), reader_(std::shared_ptr<void>(), &reader) {}

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] const micro::SnapshotHeader& header() const override { return reader_->header(); }
  [[nodiscard]] Index n_increments() const override { return reader_->n_increments(); }
  [[nodiscard]] micro::Increment read(Index i) const override { return reader_->read(i); }

 private:
  std::string name_;
  std::shared_ptr<const micro::SnapshotReader> reader_;
};

}  // namespace trame::meso
