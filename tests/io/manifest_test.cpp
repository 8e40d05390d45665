// SPDX-License-Identifier: Apache-2.0
#include "io/manifest.hpp"

#include <doctest/doctest.h>

#include "core/atomic_file.hpp"
#include "data/expect_error.hpp"
#include "io/scratch.hpp"
#include "io/vdb/vdb_file.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/inspect.hpp"

using namespace splinevox;
using test::FileSizeLimit, test::Scratch, test::slurp, test::spit, test::refusal;

namespace {

/// A folder with a text, a VDB and a manifest of both.
void fill(const Scratch& scratch) {
  spit(scratch.path("metrics.json"), "{\"psnr\": 31}");
  VdbFile file;
  file.grids.push_back({});
  file.grids[0].name = "density";
  write_vdb(scratch.path("frame.vdb"), file);
  Manifest manifest{"run", {{"seed", "1"}}, {}};
  for (const char* name : {"metrics.json", "frame.vdb"})
    manifest.files.push_back(manifest_entry(scratch.folder(), name));
  manifest.files[0].figures["frame"] = 0.1;
  write_manifest(scratch.folder(), manifest);
}

std::string refused_manifest(const Scratch& scratch) {
  return refusal([&] { read_manifest(scratch.folder()); });
}

void replace(std::string& text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  text.replace(at, from.size(), to);
}

}  // namespace

TEST_SUITE("io/manifest") {
  TEST_CASE("the hash is XXH64: published values") {
    const Scratch scratch;
    struct Row {
      const char* text;
      std::uint64_t hash;
    };
    for (const Row& row :
         {Row{"", 0xEF46DB3751D8E999ull}, Row{"a", 0xD24EC4F1A98C6E5Bull}, Row{"abc", 0x44BC2CF5AD770999ull},
          Row{"Nobody inspects the spammish repetition", 0xFBCEA83C8A378BF1ull}}) {
      CAPTURE(row.text);
      spit(scratch.path("f"), row.text);
      CHECK(digest_file(scratch.path("f")).hash == row.hash);
    }
  }

  TEST_CASE("a file hashed whole and in pieces has one hash") {
    const Scratch scratch;
    std::string text;
    for (int i = 0; i < 100; ++i) text += char(i * 7);
    const FileDigest whole = write_file(scratch.path("whole"), {text});
    for (std::size_t a = 0; a <= text.size(); a += 9)
      for (std::size_t b = a; b <= text.size(); b += 13) {
        const std::string_view view = text;
        CHECK(write_file(scratch.path("parts"), {view.substr(0, a), view.substr(a, b - a), view.substr(b)}) ==
              whole);
      }
    CHECK(slurp(scratch.path("parts")) == text);
  }

  TEST_CASE("written and read back, it says the same") {
    const Scratch scratch;
    fill(scratch);
    const Manifest back = read_manifest(scratch.folder());
    CHECK(back.kind == "run");
    CHECK(back.info == std::map<std::string, std::string>{{"seed", "1"}});
    REQUIRE(back.files.size() == 2);
    CHECK(back.files[0].figures.at("frame") == 0.1);
    CHECK(back.find("frame.vdb")->digest == digest_file(scratch.path("frame.vdb")));
    CHECK(back.find("nothing") == nullptr);
  }

  TEST_CASE("verify finds missing, shortened and altered files, each by name") {
    const Scratch scratch;
    fill(scratch);
    for (const FileCheck& check : verify(scratch.folder()))
      CHECK_MESSAGE(check.ok, check.file, check.problem);

    const std::string text = slurp(scratch.path("metrics.json")), vdb = slurp(scratch.path("frame.vdb"));
    spit(scratch.path("metrics.json"), "{\"psnr\": 91}");
    spit(scratch.path("frame.vdb"), vdb.substr(0, vdb.size() - 1));
    auto checks = verify(scratch.folder());
    REQUIRE(checks.size() == 2);
    CHECK(checks[0].file == "metrics.json");
    CHECK_FALSE(checks[0].ok);
    CHECK(checks[0].problem.find("has hash xxh64:") == 0);
    CHECK_FALSE(checks[1].ok);
    CHECK(checks[1].problem == "has " + std::to_string(vdb.size() - 1) + " bytes, the manifest says " +
                                   std::to_string(vdb.size()));

    spit(scratch.path("metrics.json"), text);
    std::filesystem::remove(scratch.path("frame.vdb"));
    checks = verify(scratch.folder());
    CHECK(checks[0].ok);
    CHECK(checks[1].problem == "could not be read: No such file or directory");
  }

  TEST_CASE("an empty list vouches for nothing, and a model that cannot be loaded is not whole") {
    const Scratch scratch;
    write_manifest(scratch.folder(), {"run", {}, {}});
    CHECK_THROWS_WITH_AS(verify(scratch.folder()), doctest::Contains("lists no files"), Error);
    VdbFile vdb;  // a sound file that is no model
    vdb.meta["creator"] = std::string("somebody");
    Manifest manifest{"run", {}, {}};
    manifest.files.push_back({"model.vdb", write_vdb(scratch.path("model.vdb"), vdb), {}});
    manifest.files.push_back({"motion.vdb", write_vdb(scratch.path("motion.vdb"), vdb), {}});
    write_manifest(scratch.folder(), manifest);
    const auto checks = verify(scratch.folder());
    CHECK_FALSE(checks[0].ok);
    CHECK(checks[0].problem.find("not a model") != std::string::npos);
    CHECK(checks[1].ok);
  }

  TEST_CASE("a listed file that is a link is not whole, whatever it leads to") {
    const Scratch scratch;
    fill(scratch);
    std::filesystem::rename(scratch.path("metrics.json"), scratch.path("elsewhere"));
    std::filesystem::create_symlink("elsewhere", scratch.path("metrics.json"));
    const auto checks = verify(scratch.folder());
    CHECK_FALSE(checks[0].ok);
    CHECK(checks[0].problem.find("link") != std::string::npos);
  }

  TEST_CASE("every flipped byte of a listed file is found") {
    const Scratch scratch;
    fill(scratch);
    const std::string vdb = slurp(scratch.path("frame.vdb"));
    for (std::size_t n = 0; n < vdb.size(); n += 3) {
      std::string flipped = vdb;
      flipped[n] = char(flipped[n] ^ 16);
      spit(scratch.path("frame.vdb"), flipped);
      CHECK_FALSE(verify(scratch.folder())[1].ok);
    }
  }

  TEST_CASE("a VDB whose bytes are listed but unreadable is reported") {
    const Scratch scratch;
    spit(scratch.path("bad.vdb"), "not a vdb at all");
    write_manifest(scratch.folder(), {"run", {}, {manifest_entry(scratch.folder(), "bad.vdb")}});
    const auto checks = verify(scratch.folder());
    REQUIRE(checks.size() == 1);
    CHECK(checks[0].problem == "is not a VDB file");
  }

  TEST_CASE("malformed manifests are refused, naming the field") {
    const Scratch scratch;
    fill(scratch);
    const std::string good = slurp(scratch.path(kManifestName));
    struct Row {
      const char *from, *to, *says;
    };
    for (const Row& row :
         {Row{"\"version\": 1", "\"version\": 2", "newer version"}, Row{"\"size\"", "\"sizes\"", "size"},
          Row{"xxh64:", "crc32:", "'hash' is malformed"},
          Row{"frame.vdb", "../frame.vdb", "leads out of the folder"},
          Row{"frame.vdb", "/etc/passwd", "leads out of the folder"}, Row{"{", "[", "malformed"},
          Row{"\"run\"", "7", "malformed"}, Row{"splinevox manifest", "other", "not a manifest"}}) {
      CAPTURE(row.to);
      std::string text = good;
      replace(text, row.from, row.to);
      spit(scratch.path(kManifestName), text);
      const std::string message = refused_manifest(scratch);
      CHECK(message.find(scratch.path(kManifestName)) == 0);
      CHECK(message.find(row.says) != std::string::npos);
    }
    for (std::size_t n = 0; n + 2 < good.size(); n += 5) {
      spit(scratch.path(kManifestName), good.substr(0, n));
      CHECK_THROWS_AS(read_manifest(scratch.folder()), Error);
    }
    spit(scratch.path(kManifestName), std::string(100000, '['));
    CHECK(refused_manifest(scratch).find("nested too deeply") != std::string::npos);
    std::filesystem::remove(scratch.path(kManifestName));
    CHECK_THROWS_AS(verify(scratch.folder()), Error);
  }

  TEST_CASE("a full disk leaves the old manifest") {
    const Scratch scratch;
    fill(scratch);
    const std::string good = slurp(scratch.path(kManifestName));
    {
      const FileSizeLimit limit(20);
      CHECK_THROWS_AS(write_manifest(scratch.folder(), {"export", {}, {}}), Error);
    }
    CHECK(slurp(scratch.path(kManifestName)) == good);
    CHECK(scratch.count() == 3);
  }
}
