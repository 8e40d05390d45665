// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "cli/tree.hpp"

using namespace splinevox::cli;

namespace {

/// The program's command line, declared anew: CLI11 keeps what it parsed.
struct Declared {
  CLI::App app{"what it is", "splinevox"};
  Declared() {
    app.set_help_flag("-h,--help", "this page");
    app.require_subcommand(1);
    declare_verbs(app);
  }
};

/// The words of one program of a shell's line: up to a pipe or a redirection.
std::vector<std::string> words_of(const std::string& line) {
  std::vector<std::string> words;
  std::istringstream in(line);
  for (std::string word; in >> word && word != "|" && word != ">";) words.push_back(word);
  return words;
}

void check_parses(const Example& example) {
  CAPTURE(example.words);
  std::vector<std::string> words = words_of(example.words);
  REQUIRE(words.size() >= 2);
  CHECK(words.front() == "splinevox");
  CHECK_FALSE(example.purpose.empty());
  Declared declared;
  std::vector<std::string> reversed(words.rbegin(), words.rend() - 1);  // CLI11 takes the last word first
  CHECK_NOTHROW(declared.app.parse(reversed));
}

/// An example is to be copied, so it stays one line in a narrow terminal too.
void check_columns(const std::string& page, std::size_t width) {
  std::istringstream in(page);
  for (std::string line; std::getline(in, line);) {
    CAPTURE(line);
    CHECK(line.size() <= (line.rfind("  splinevox ", 0) == 0 ? std::max<std::size_t>(width, 80) : width));
    CHECK((line.empty() || line.back() != ' '));
  }
}

}  // namespace

TEST_SUITE("cli/help") {
  TEST_CASE("no line of help is wider than it may be, and no word is split") {
    const Declared declared;
    for (const int width : {60, 80, 100}) {
      CAPTURE(width);
      check_columns(help_page(declared.app, width), std::size_t(width));
      for (const VerbEntry& v : describe(declared.app)) {
        CAPTURE(v.name);
        const std::string page = help_page(v, width);
        check_columns(page, std::size_t(width));
        std::istringstream in(page);
        std::multiset<std::string> printed;
        for (std::string word; in >> word;) printed.insert(word);
        for (const OptionEntry& o : v.options) {
          std::istringstream text(o.text);
          for (std::string word; text >> word;) CHECK_MESSAGE(printed.count(word) > 0, word);
        }
      }
    }
  }

  TEST_CASE("every verb has two examples or more, and they parse") {
    const Declared declared;
    for (const VerbEntry& v : describe(declared.app)) {
      CAPTURE(v.name);
      CHECK(v.examples.size() >= 2);
      for (const Example& e : v.examples) {
        CHECK(words_of(e.words)[1] == v.name);
        check_parses(e);
        CHECK(help_page(v, 80).find(e.words) != std::string::npos);
      }
    }
    for (const Example& e : order_of_use()) check_parses(e);
  }

  TEST_CASE("a word that is no option does not parse, so the check of examples can fail") {
    Declared declared;
    CHECK_THROWS_AS(declared.app.parse(std::vector<std::string>{"--no-such", "run", "eval"}),
                    CLI::ParseError);
  }

  TEST_CASE("names of values are whole, and what a value may be stands behind the text") {
    const Declared declared;
    std::string pages;
    for (const VerbEntry& v : describe(declared.app)) {
      std::istringstream in(help_page(v, 80));  // lines may end anywhere
      for (std::string word; in >> word;) pages += word + " ";
    }
    for (const char* part : {"--time-curve T:S,...", "--basis NAME[:K]", "(INT in [0 - 4096]; default: 0)",
                             "one of test, val, train", "-h, --help"})
      CHECK_MESSAGE(pages.find(part) != std::string::npos, part);
  }

  TEST_CASE("every option stands below a heading of its own verb, and the manual has all examples") {
    const Declared declared;
    const std::string manual = man_page(declared.app, "0");
    for (const VerbEntry& v : describe(declared.app)) {
      CAPTURE(v.name);
      CHECK_FALSE(v.group.empty());
      for (const OptionEntry& o : v.options)
        if (!o.positional()) CHECK_MESSAGE(o.group != "Options", o.names.back());
      for (const Example& e : v.examples) CHECK(manual.find(e.purpose.substr(0, 12)) != std::string::npos);
    }
  }
}
