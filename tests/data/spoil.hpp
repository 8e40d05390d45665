// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>

#include "data/expect_error.hpp"
#include "splinevox/data/scene.hpp"
#include "support/tiny_dataset.hpp"

/// Data sets whose files are spoiled, one thing at a time.
namespace splinevox::test {

namespace fs = std::filesystem;

inline std::string text_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {(std::istreambuf_iterator<char>(in)), {}};
}

/// A folder in one layout, for tests to spoil one file at a time.
class Set {
 public:
  explicit Set(const std::function<void(const fs::path&)>& write) { write(folder_.path()); }
  const fs::path& path() const { return folder_.path(); }
  /// The first `from` in a file becomes `to`; the message must hold all parts. The file is then as it was.
  void refuse(const std::string& file, const std::string& from, const std::string& to,
              const std::vector<std::string>& parts) const {
    const std::string good = text_of(path() / file);
    const std::size_t at = good.find(from);
    CAPTURE(file);
    CAPTURE(from);
    REQUIRE(at != std::string::npos);
    replace(file, std::string(good).replace(at, from.size(), to), parts);
  }
  void replace(const std::string& file, const std::string& bad, const std::vector<std::string>& parts) const {
    const std::string good = text_of(path() / file);
    write_text(path() / file, bad);
    expect_error([&] { load_dataset(folder_.str(), {.rules = {.missing = "refuse"}}); }, parts);
    write_text(path() / file, good);
  }
  void expect(const std::vector<std::string>& parts) const {
    expect_error([&] { load_dataset(folder_.str(), {.rules = {.missing = "refuse"}}); }, parts);
  }
  /// Whatever bytes are damaged, there is an input error or a data set.
  void damage(const std::string& file, int trials) const {
    const std::string good = text_of(path() / file);
    std::mt19937 random(7);
    int refused = 0;
    for (int trial = 0; trial < trials; ++trial) {
      std::string bad = good.substr(0, trial % 3 == 0 ? random() % good.size() : good.size());
      for (unsigned k = 0; k < 1 + trial % 3u && !bad.empty(); ++k)
        bad[random() % bad.size()] = char(random());
      write_text(path() / file, bad);
      try {
        load_dataset(folder_.str());
      } catch (const Error& error) {
        CHECK(error.fault == Fault::input);
        ++refused;
      }
    }
    CHECK(refused > trials / 4);
    write_text(path() / file, good);
  }

 private:
  TempFolder folder_;
};

}  // namespace splinevox::test
