// What errors say is UTF-8 in one line, whatever a file calls itself.
#include "model/text.h"

#include <gtest/gtest.h>

#include "omma/error.h"

namespace omma::test {
namespace {

using namespace std::string_literals;

TEST(ReadableText, LeavesWhatIsReadable) {
  for (const std::string& text : {""s, "plain, \"quoted\" \\ ~"s, "Käfer · 蜂 · 🐝"s})
    EXPECT_EQ(readable_text(text), text);
}

TEST(ReadableText, EscapesControlCharacters) {
  EXPECT_EQ(readable_text("a\nb\tc\r\x1b[31m\x7f"), "a\\nb\\tc\\x0d\\x1b[31m\\x7f");
  EXPECT_EQ(readable_text("\0x"s), "\\x00x");
  EXPECT_EQ(readable_text("\u0085\u009b"), "\\xc2\\x85\\xc2\\x9b");  // C1: next line, CSI
  EXPECT_EQ(readable_text("\u00a0"), "\u00a0");                      // the first that is none
}

TEST(ReadableText, EscapesBytesThatAreNoUtf8) {
  EXPECT_EQ(readable_text("K\xe4ger.png"), "K\\xe4ger.png");    // Latin-1
  EXPECT_EQ(readable_text("\xc3"), "\\xc3");                    // cut off
  EXPECT_EQ(readable_text("\xc0\xaf"), "\\xc0\\xaf");           // overlong
  EXPECT_EQ(readable_text("\xed\xa0\x80"), "\\xed\\xa0\\x80");  // a surrogate
  EXPECT_EQ(readable_text("\xf5\x80\x80\x80"), "\\xf5\\x80\\x80\\x80");
}

TEST(Error, IsReadable) {
  EXPECT_STREQ(Error("K\xe4ger\n.png: is broken").what(), "K\\xe4ger\\n.png: is broken");
}

}  // namespace
}  // namespace omma::test
