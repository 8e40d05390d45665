// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>
#include <zlib.h>

#include "core/process.hpp"
#include "splinevox/data/image_io.hpp"
#include "support/tiny_dataset.hpp"

using namespace splinevox;
using namespace splinevox::test;

namespace {

constexpr std::size_t kEndOfHeader = 33;

void insert_chunk(Bytes& png, const std::string& name, const Bytes& content) {
  Bytes chunk;
  put_chunk(chunk, name.c_str(), content);
  png.insert(png.begin() + std::ptrdiff_t(kEndOfHeader), chunk.begin(), chunk.end());
}

Bytes read_all(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return Bytes{std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

TEST_SUITE("data/png_chunks") {
  TEST_CASE("texts and profiles of a PNG are not inflated, and change nothing") {
    const TempFolder folder;
    write_png(folder.path() / "a.png", {2, 1, 8, PngKind::rgba, {200, 100, 50, 128, 255, 1, 7, 0}});
    const Image16 plain = read_png(folder.path() / "a.png");
    const std::vector<Bytef> zeros(8'000'000 - 100, 0);
    Bytes packed(compressBound(zeros.size()));
    uLongf size = packed.size();
    REQUIRE(compress2(packed.data(), &size, zeros.data(), zeros.size(), 9) == Z_OK);
    packed.resize(size);
    CHECK(size < 10'000);
    struct Kind {
      std::string name, head;
    };
    for (const Kind& kind : {Kind{"zTXt", std::string("k\0\0", 3)}, Kind{"iCCP", std::string("k\0\0", 3)},
                             Kind{"iTXt", std::string("k\0\1\0\0\0", 6)}}) {
      CAPTURE(kind.name);
      Bytes png = read_all(folder.path() / "a.png"), content(kind.head.begin(), kind.head.end());
      content.insert(content.end(), packed.begin(), packed.end());
      for (int i = 0; i < (kind.name == "iCCP" ? 1 : 60); ++i) insert_chunk(png, kind.name, content);
      write_bytes(folder.path() / "b.png", png);
      const double before = peak_memory();
      CHECK(read_png(folder.path() / "b.png").rgba == plain.rgba);
      CHECK(peak_memory() - before < 50e6);
    }
  }
}
