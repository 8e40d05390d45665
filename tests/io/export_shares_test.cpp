// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <filesystem>

#include "io/manifest.hpp"
#include "io/scratch.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "splinevox/io/inspect.hpp"
#include "support/blob_model.hpp"

using namespace splinevox;
using test::blob_model, test::Scratch, test::slurp;

namespace {

ExportOptions options_for(Share share) {
  ExportOptions o;
  o.last = 7;
  o.mesh = true;
  o.share = share;
  return o;
}

/// Bytes of every file that the manifest of a whole export lists are those of another folder.
void check_same(const Scratch& a, const Scratch& b) {
  CHECK(slurp(a.path(kManifestName)) == slurp(b.path(kManifestName)));
  for (const ManifestFile& file : read_manifest(a.folder()).files) {
    CAPTURE(file.name);
    CHECK(slurp(a.path(file.name)) == slurp(b.path(file.name)));
  }
}

}  // namespace

TEST_SUITE("io/export_shares") {
  TEST_CASE("shares of the frames, and then the whole, leave what one export leaves") {
    const VoxelModel model = blob_model(24, {.twist = 0.5f});
    const Scratch one, several;
    export_vdb(model, one.folder(), options_for({}));
    int frames = 0;
    for (const int index : {2, 0, 1}) {
      const ExportResult share = export_vdb(model, several.folder(), options_for({index, 3}));
      CHECK(share.finished);
      for (const ExportedFrame& frame : share.frames) CHECK((frame.frame - 1) % 3 == index);
      frames += int(share.frames.size());
    }
    CHECK(frames == 7);
    CHECK_FALSE(std::filesystem::exists(several.path(kManifestName)));
    CHECK(partial_manifests(several.folder()).size() == 3);
    CHECK_THROWS_WITH_AS(verify(several.folder()), doctest::Contains("not finished"), Error);
    const ExportResult whole = export_vdb(model, several.folder(), options_for({}));
    CHECK(whole.finished);
    for (const ExportedFrame& frame : whole.frames) CHECK(frame.kept);
    CHECK(partial_manifests(several.folder()).empty());
    check_same(one, several);
  }

  TEST_CASE("what a share left out, or left broken, the whole makes good") {
    const VoxelModel model = blob_model(24, {.twist = 0.5f});
    const Scratch one, several;
    export_vdb(model, one.folder(), options_for({}));
    export_vdb(model, several.folder(), options_for({0, 2}));
    export_vdb(model, several.folder(), options_for({1, 2}),
               [](const ExportedFrame&, int done, int) { return done < 1; });
    test::spit(several.path("frame_0003.vdb"), "half a frame");
    int kept = 0;
    for (const ExportedFrame& frame : export_vdb(model, several.folder(), options_for({})).frames)
      kept += frame.kept;
    CHECK(kept >= 4);  // frames 1, 5 and 7, and at least one of 2, 4, 6
    CHECK(kept < 7);
    check_same(one, several);
  }

  TEST_CASE("a share that holds no frame is finished at once, and an impossible one is refused") {
    const VoxelModel model = blob_model(16, {.moves = false});
    const Scratch scratch;
    const ExportResult none = export_vdb(model, scratch.folder(), options_for({8, 9}));
    CHECK(none.finished);
    CHECK(none.frames.empty());
    CHECK_THROWS_WITH_AS(export_vdb(model, scratch.folder(), options_for({3, 3})),
                         doctest::Contains("--share"), Error);
  }
}
