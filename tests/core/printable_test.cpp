// SPDX-License-Identifier: Apache-2.0
#include "core/printable.hpp"

#include <doctest/doctest.h>

#include "splinevox/core/error.hpp"

using namespace splinevox;

TEST_SUITE("core/printable") {
  TEST_CASE("nothing that a terminal obeys gets through, and everything that it shows does") {
    CHECK(all_printable("\x1b[2Jgone") == "\\x1b[2Jgone");
    CHECK(all_printable("a\nb\r\x07\x7f") == "a\\x0ab\\x0d\\x07\\x7f");
    CHECK(all_printable("\xc2\x9b"
                        "31m") == "\\u009b31m");  // CSI in one character
    CHECK(all_printable("a\xe2\x80\xae"
                        "gnp.exe") == "a\\u202egnp.exe");
    for (const char* sign : {"\xe2\x80\x8e", "\xe2\x80\x8f", "\xe2\x80\xaa", "\xe2\x80\xab", "\xe2\x80\xac",
                             "\xe2\x80\xad", "\xe2\x81\xa6", "\xe2\x81\xa7", "\xe2\x81\xa8", "\xe2\x81\xa9",
                             "\xe2\x80\xa8", "\xe2\x80\xa9", "\xd8\x9c"})
      CHECK(all_printable(sign).starts_with("\\u"));
    const char* harmless[] = {"plain", "Größe 5 µm", "漢字.png", "שלום", "frame (1).png", "back\\slash"};
    for (const char* text : harmless) CHECK(all_printable(text) == text);
    CHECK(all_printable("a\xff") == "a\\xff");
  }

  TEST_CASE("of any text, what comes out is one line without controls, and comes out the same again") {
    std::uint32_t state = 1;
    for (int i = 0; i < 2000; ++i) {
      std::string text;
      for (int k = 0; k < 12; ++k) {
        state = state * 1664525u + 1013904223u;
        text += char(state >> 24);
      }
      const std::string shown = all_printable(text);
      for (const char c : shown) CHECK((static_cast<unsigned char>(c) >= 0x20 && c != 0x7f));
      CHECK(all_printable(shown) == shown);
    }
  }

  TEST_CASE("a message keeps its lines, whatever its texts hold") {
    const Error error({"dir/\x1b[31m\nname", "is\nwrong", "a\nb", "\xe2\x80\xae", "try\tthis"}, Fault::input);
    CHECK(std::string(error.what()) ==
          "dir/\\x1b[31m\\x0aname: is\\x0awrong\n  expected: a\\x0ab\n  got:      \\u202e\n  try:      "
          "try\\x09this");
    CHECK(error.problem.what == "is\nwrong");
  }
}
