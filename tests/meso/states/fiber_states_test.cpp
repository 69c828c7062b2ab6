/// What `analyse` asks of states, whatever they are read from.

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>

#include "tests/support/analyse.h"
#include "tests/support/lattice_yarns.h"

namespace trame::meso {
namespace {

using micro::test::input_error;
using micro::test::LatticeYarns;
using test::analyse;

/// States made on the fly; notes how much memory is in use at each reading.
class MadeStates : public FiberStates {
 public:
  explicit MadeStates(const LatticeYarns& yarns) : fibers(yarns.configuration()) { header_.mesh = yarns.mesh(); }

  [[nodiscard]] std::string name() const override { return "a.h5"; }
  [[nodiscard]] const micro::SnapshotHeader& header() const override { return header_; }
  [[nodiscard]] Index n_increments() const override { return 60; }
  [[nodiscard]] micro::Increment read(Index i) const override {
    const struct mallinfo2 info = mallinfo2();
    bytes_in_use.push_back(info.uordblks + info.hblkhd);
    micro::Increment increment;
    increment.fibers = micro::test::mapped(fibers, Vec3(1 + 0.001 * i, 1, 1).asDiagonal());
    return increment;
  }
  [[nodiscard]] micro::FiberMesh& mesh() { return header_.mesh; }

  micro::FiberConfiguration fibers;
  mutable std::vector<std::size_t> bytes_in_use;

 private:
  micro::SnapshotHeader header_;
};

TEST(FiberStates, MemoryDoesNotGrowWithTheirNumber) {
  const MadeStates states({.n_yarns = 1, .n_rows = 6, .n_columns = 10, .n_elements = 30});
  const std::size_t state_bytes = states.fibers.r.size() * 4 * sizeof(Vec3);
  Index n_states = 0;
  (void)analyse(states, {.n_threads = 1, .on_state = [&](const auto&) { ++n_states; }});
  ASSERT_EQ(n_states, 60);
  // Reference, A and the first two B come before everything that stays has been allocated.
  ASSERT_EQ(states.bytes_in_use.size(), 62u);
  const auto [least, most] = std::minmax_element(states.bytes_in_use.begin() + 4, states.bytes_in_use.end());
  if (*most == 0) GTEST_SKIP() << "this allocator does not tell how much is in use";
  EXPECT_LT(*most - *least, state_bytes) << "one state more is held at one time than at another";
}

TEST(FiberStates, ArcLengthsThatDoNotGrowAreAnError) {
  MadeStates states({});
  states.mesh().arc_length[13] = states.mesh().arc_length[12];
  EXPECT_NE(input_error([&] {
              (void)analyse(states, {.to = {1}});
            }).find("a.h5: yarn warp/1: the arc length of fiber 1 does not grow from node to node"),
            std::string::npos);
  states.mesh().arc_length[13] = std::nan("");
  EXPECT_NE(input_error([&] { (void)analyse(states, {.to = {1}}); }), "");
}

TEST(FiberStates, ArcLengthsBeginWithZero) {
  MadeStates states({});
  states.mesh().arc_length[11] = -1e300;  // the first node of fiber 1
  EXPECT_NE(input_error([&] {
              (void)analyse(states, {.to = {1}});
            }).find("a.h5: yarn warp/1: the arc length of fiber 1 does not begin with 0"),
            std::string::npos);
}

TEST(FiberStates, FibersInOneAnotherAreAnError) {
  MadeStates states({});
  const Index n = states.header().mesh.n_nodes(0);
  for (std::size_t i = n; i < states.fibers.r.size(); ++i) states.fibers.r[i] = states.fibers.r[i % n];
  EXPECT_NE(input_error([&] {
              (void)analyse(states, {.to = {1}});
            }).find("a.h5: yarn warp/1: its fibers lie in one another in the reference state"),
            std::string::npos);
}

TEST(FiberStates, AllNodesInOnePointAreAnError) {
  MadeStates states({});
  for (Vec3& r : states.fibers.r) r = Vec3::Zero();
  EXPECT_NE(input_error([&] { (void)analyse(states, {.to = {1}}); }), "");
}

}  // namespace
}  // namespace trame::meso
