#include "micro/core/archive.h"

#include <gtest/gtest.h>

#include <limits>

namespace trame {
namespace {

enum class Colour : std::uint8_t { red, blue };

struct Item {
  double x = 0;
  std::string name;
  void keep(Archive& archive) { archive(x, name); }
};

struct Everything {
  bool yes = false;
  Index n = 0;
  Colour colour = Colour::red;
  Vec3 v = Vec3::Zero();
  Mat3 m = Mat3::Zero();
  std::vector<double> numbers;
  std::vector<Item> items;
  std::optional<double> some, none = 1;

  void keep(Archive& archive) { archive(yes, n, colour, v, m, numbers, items, some, none); }
};

Everything everything() {
  Everything e{
      true, -7, Colour::blue, {1, -0.0, std::numeric_limits<double>::denorm_min()}, Mat3::Random(), {0.1, 0.2}, {},
      3.5,  {}};
  e.items = {{1.0 / 3, "ä"}, {2, ""}};
  return e;
}

std::string bytes_of(Everything e) {
  Archive archive;
  archive(e);
  return archive.bytes();
}

TEST(Archive, GivesBackEveryBit) {
  const std::string bytes = bytes_of(everything());
  Archive archive(bytes);
  Everything read;
  archive(read);
  EXPECT_TRUE(archive.at_end());
  EXPECT_EQ(bytes_of(read), bytes);
  EXPECT_EQ(read.items.at(0).name, "ä");
  EXPECT_FALSE(read.none);
}

TEST(Archive, RefusesWhatEndsEarlyOrIsLongerThanItsBytes) {
  const std::string bytes = bytes_of(everything());
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    Archive archive(bytes.substr(0, n));
    Everything read;
    EXPECT_THROW(archive(read), ArchiveError) << n;
  }
  Archive endless(std::string(16, '\xff'));
  std::vector<Item> items;
  EXPECT_THROW(endless(items), ArchiveError);
  Archive neither(std::string(1, '\2'));
  bool truth = false;
  EXPECT_THROW(neither(truth), ArchiveError);
}

}  // namespace
}  // namespace trame
