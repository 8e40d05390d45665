// SPDX-License-Identifier: Apache-2.0
// What a run or an export leaves: model, checkpoint, training state, manifest.
#include <cstring>

#include "core/hash.hpp"
#include "fuzz/seeds.hpp"
#include "fuzz/targets.hpp"
#include "io/checkpoint.hpp"
#include "io/manifest.hpp"
#include "io/vdb/vdb_scan.hpp"
#include "splinevox/io/inspect.hpp"
#include "splinevox/io/model_vdb.hpp"
#include "support/blob_model.hpp"
#include "train/archive.hpp"

namespace splinevox::fuzz {
namespace {

/// A training state in small: what the trainer archives are values of these types.
struct State {
  Channels values;
  BitGrid grid;
  AlignedVector<float> moments;
  std::vector<BitGrid> grids;
  void archive(Archive& a) { a(values, grid, moments, grids); }
};

std::vector<char> state_bytes() {
  const VoxelModel model = test::blob_model(8);
  State state{model.radiance.raw, BitGrid(model.box, 12), {}, {}};
  state.values.values.resize(state.values.topology->rows() * std::size_t(state.values.width));
  state.moments.assign(40, 0.5f);
  state.grids.assign(3, state.grid);
  Archive out;
  state.archive(out);
  return joined(out.pieces());
}

}  // namespace

int model_vdb(const std::uint8_t* data, std::size_t size) {
  const std::string path = put("model.vdb", data, size);
  return verdict([&] { load_model(path); });
}

std::vector<std::string> model_seeds() {
  std::vector<std::string> out;
  test::BlobMotion moving;
  moving.rigidity = true;
  moving.light = 0.5f;
  for (const bool moves : {false, true}) {
    const std::string file = made_by([&](const std::string& p) {
      save_model(p, test::blob_model(8, moves ? moving : test::BlobMotion{.moves = false}, 1));
    });
    out.push_back(file.substr(
        0, file.size() - kVdbSealBytes));  // as another program writes it: nothing vouches for the bytes
    if (moves) out.push_back(file);
  }
  return out;
}

/// Seals a file anew: the seal has no key.
void mend_vdb(std::string& file) {
  constexpr std::string_view kMagic = "SPVXSEAL";
  if (file.size() > kVdbSealBytes && file.substr(file.size() - kVdbSealBytes, kMagic.size()) == kMagic)
    file.resize(file.size() - kVdbSealBytes);
  file += vdb_seal(file.size(), hash64(file));
}

int checkpoint(const std::uint8_t* data, std::size_t size) {
  const std::string path = put("checkpoint.bin", data, size);
  return verdict([&] { read_checkpoint(path); });
}

void mend_checkpoint(std::string& file) {
  if (file.size() < 8) return;
  const std::uint64_t hash = hash64(std::string_view(file).substr(0, file.size() - 8));
  std::memcpy(file.data() + file.size() - 8, &hash, 8);
}

std::vector<std::string> checkpoint_seeds() {
  const CheckpointHeader header{1, 2, 3, 400, "trainer"};
  return {made_by([&](const std::string& p) { write_checkpoint(p, header, std::vector<char>(500, 'x')); }),
          made_by([&](const std::string& p) { write_checkpoint(p, header, {}); })};
}

int training_state(const std::uint8_t* data, std::size_t size) {
  return verdict([&] {
    const std::vector<char> bytes(data, data + size);
    Archive in(bytes);
    State state;
    state.archive(in);
  });
}

std::vector<std::string> state_seeds() {
  const std::vector<char> bytes = state_bytes();
  return {std::string(bytes.begin(), bytes.end())};
}

int manifest(const std::uint8_t* data, std::size_t size) {
  put(kManifestName, data, size);
  return verdict([] { read_manifest(folder(), kManifestName); });
}

std::vector<std::string> manifest_seeds() {
  const Manifest m{"export",
                   {{"fps", "24"}, {"model", "xxh64:0123456789abcdef"}},
                   {{"frame_0001.vdb", {1234, 99}, {{"time", 0.5}, {"frame", 1}}}, {"a/b.json", {0, 7}, {}}}};
  return {made_by([&](const std::string& p) { write_manifest(folder(), m, p.substr(p.rfind('/') + 1)); })};
}

}  // namespace splinevox::fuzz
