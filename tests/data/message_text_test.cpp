// SPDX-License-Identifier: Apache-2.0
#include "data/message_text.hpp"

#include <doctest/doctest.h>

#include <cmath>

namespace {

using namespace splinevox::data;

TEST_SUITE("data/message_text") {
  TEST_CASE("text of a file stays on one line and is valid UTF-8") {
    CHECK(printable("a\nb\tc\x7f") == "a\\x0ab\\x09c\\x7f");
    CHECK(printable("grün €") == "grün €");
    CHECK(printable("a\xffz") == "a\\xffz");
    CHECK(printable("cut \xe2\x82") == "cut \\xe2\\x82");
    CHECK(printable("\xc0\x80") == "\\xc0\\x80");
    CHECK(printable("") == "");
    CHECK(in_quotes("a") == "'a'");
  }

  TEST_CASE("long text is cut, between characters") {
    CHECK(printable(std::string(120, 'x')) == std::string(120, 'x'));
    CHECK(printable(std::string(121, 'x')) == std::string(120, 'x') + "...");
    CHECK(printable(std::string(119, 'x') + "€uro") == std::string(119, 'x') + "€...");
  }

  TEST_CASE("numbers are short") {
    CHECK(number(0.5) == "0.5");
    CHECK(number(1e300) == "1e+300");
    CHECK(number(std::nan("")) == "nan");
    CHECK(number(1.0 / 3) == "0.333333333");
  }
}

}  // namespace
