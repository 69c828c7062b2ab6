// Text from outside on its way to people.

#include "micro/core/text.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace trame {
namespace {

TEST(Text, PlainIsWhatAnyFileAndScreenCanHold) {
  for (const char* text : {"", "warp/1/start", "a, \"b\" <c> & 'd'", "Gewebe × µ „Garn“", "織物"})
    EXPECT_TRUE(is_plain(text));
  const std::vector<std::string> steering = {"a\nb",         "\t",        std::string("\0", 1),
                                             "\x7f",         "\xc2\x85",  "\xe2\x80\xa8",
                                             "\xe2\x80\xae", "Tr\xe4ger", "\xed\xa0\x80"};
  for (const std::string& text : steering) EXPECT_FALSE(is_plain(text)) << printable(text);
}

TEST(Text, PrintableShowsWhatSteersATerminal) {
  EXPECT_EQ(printable("\x1b[2J\tdone\r\n"), "\\x1b[2J\\tdone\\x0d\\n");
  EXPECT_EQ(printable("Tr\xe4ger µ"), "Tr\\xe4ger µ");
  EXPECT_EQ(printable("\xe2\x80\xae"), "\\u202e");
  EXPECT_EQ(printable(std::string("a\0b", 3)), "a\\x00b");
  EXPECT_TRUE(is_plain(printable("\xff\xfe\xe2\x80")));
}

TEST(Text, MadePlainKeepsWhatIsPlain) {
  EXPECT_EQ(made_plain("Träger 2 × 2"), "Träger 2 × 2");
  EXPECT_EQ(made_plain("Tr\xe4ger"), "Tr\xef\xbf\xbdger");
  EXPECT_TRUE(is_plain(made_plain("\xff\n\xe4\xe2\x80\xae")));
}

}  // namespace
}  // namespace trame
