// SPDX-License-Identifier: Apache-2.0
// What other layouts of data sets are made of: JPEG, tables of numpy, models of COLMAP, tracks and flow.
#include "core/atomic_file.hpp"
#include "data/jpeg_bytes.hpp"
#include "data/layouts.hpp"
#include "data/rig_layouts.hpp"
#include "data/tracks/flow_file.hpp"
#include "data/tracks/table_read.hpp"
#include "fuzz/seeds.hpp"
#include "fuzz/targets.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/data/scene.hpp"
#include "support/numpy_file.hpp"

namespace splinevox::fuzz {
namespace {

using test::ColmapLens;
using test::TempFolder;
const ColmapLens kLens{"OPENCV", 4, {11, 12, 5.5, 4.25, -0.12, 0.03, 0.002, -0.003}};
constexpr int kFew = 3;

/// A data set of one program's layout; `file` of it is what the fuzzer writes.
struct Layout {
  const char *name, *file;
  void (*write)(const std::filesystem::path& folder);
};

/// A data set of few cameras. @tparam More  addresses of what else the writer is told
template <auto Write, auto... More>
void few(const std::filesystem::path& folder) {
  Write(folder, test::true_cameras({}, kFew), *More...);
}

constexpr Layout kLlff{"llff", "poses_bounds.npy", few<test::write_llff>};
constexpr Layout kNrnerf{"nrnerf", "precomputed.json", few<test::write_nrnerf>};
constexpr Layout kNerfstudio{"nerfstudio", "transforms.json", few<test::write_nerfstudio>};
constexpr Layout kGibson{"gibson", "transform_train.json", few<test::write_gibson>};
constexpr Layout kNerfiesLists{"nerfies_lists", "dataset.json", few<test::write_nerfies>};
constexpr Layout kNerfiesCamera{"nerfies_camera", "camera/000_0000.json", few<test::write_nerfies>};
constexpr Layout kColmapText{"colmap_text", "sparse/0/images.txt", few<test::write_colmap_text, &kLens>};
constexpr Layout kColmapTextCameras{"colmap_text_cameras", "sparse/0/cameras.txt",
                                    few<test::write_colmap_text, &kLens>};
constexpr Layout kColmapTextPoints{"colmap_text_points", "sparse/0/points3D.txt",
                                   few<test::write_colmap_text, &kLens>};
constexpr Layout kColmapBinary{"colmap_binary", "sparse/0/images.bin",
                               few<test::write_colmap_binary, &kLens>};
constexpr Layout kColmapBinaryCameras{"colmap_binary_cameras", "sparse/0/cameras.bin",
                                      few<test::write_colmap_binary, &kLens>};
constexpr Layout kColmapBinaryPoints{"colmap_binary_points", "sparse/0/points3D.bin",
                                     few<test::write_colmap_binary, &kLens>};

constexpr int kRigMoments = 2;
constexpr Layout kGaussians{"gaussians", "train_meta.json", few<test::write_gaussians, &kRigMoments>};
constexpr Layout kEasymocapLenses{"easymocap_lenses", "intri.yml", few<test::write_easymocap, &kRigMoments>};
constexpr Layout kEasymocapPoses{"easymocap_poses", "extri.yml", few<test::write_easymocap, &kRigMoments>};

/// The folder of this process with the data set, written once; the file in it gets the bytes and all is read.
template <const Layout& L>
int read_with(const std::uint8_t* data, std::size_t size) {
  const std::filesystem::path set = std::filesystem::path(folder()) / L.name;
  if (!std::filesystem::exists(set)) L.write(set);
  put(std::string(L.name) + "/" + L.file, data, size);
  return verdict([&] { load_dataset(set.string()); });
}

template <const Layout& L>
std::vector<std::string> seeds_of() {
  const TempFolder set;
  L.write(set.path());
  return {read_file((set.path() / L.file).string())};
}

std::vector<std::string> npy_seeds() {
  std::vector<std::string> seeds = seeds_of<kLlff>();
  const test::Bytes single =
      test::npy_bytes(kFew, 17, test::llff_rows(test::true_cameras({}, kFew), 4), "<f4");
  seeds.emplace_back(single.begin(), single.end());
  return seeds;
}

constexpr int kHighFlow = 3, kWideFlow = 4;
const std::vector<float> kFlow(2 * kHighFlow * kWideFlow, 0.5f);

int flow(const std::uint8_t* data, std::size_t size) {
  const std::string path = put("flow", data, size);
  return verdict([&] { data::read_flow(path, path, data::FlowWay::forward); });
}

std::vector<std::string> flow_seeds() {
  const std::string table = test::numpy("<f4", "(3, 4, 2)", test::bytes_of(kFlow));
  const std::string sides = test::bytes_of(std::vector<std::int32_t>{kWideFlow, kHighFlow});
  return {"PIEH" + sides + test::bytes_of(kFlow), table, test::npz({{"flow.npy", table}}, true)};
}

/// Two points through three pictures.
int tracks(const std::uint8_t* data, std::size_t size) {
  const std::string path = put("tracks", data, size);
  return verdict([&] { data::read_track_table(path, path, {3}); });
}

std::vector<std::string> track_seeds() {
  const std::string table = test::numpy("<f4", "(2, 3, 2)", test::bytes_of(std::vector<float>(12, 0.5f)));
  const std::string seen = test::numpy("|b1", "(2, 3)", std::string(6, '\1'));
  return {table, test::npz({{"tracks.npy", table}, {"visible.npy", seen}}, true)};
}

template <const Layout& L>
constexpr Target target{L.name, read_with<L>, seeds_of<L>};

}  // namespace

int jpeg(const std::uint8_t* data, std::size_t size) {
  const std::string path = put("picture.jpg", data, size);
  return verdict([&] { read_jpeg(path); });
}

std::vector<std::string> jpeg_seeds() {
  return {test::jpeg_bytes(), test::jpeg_bytes({20, 11, 1}), test::jpeg_bytes({33, 17, 3, 70, true}),
          test::jpeg_bytes({16, 8, 4})};
}

std::vector<Target> layout_targets() {
  return {{"npy", read_with<kLlff>, npy_seeds},
          {"flow", flow, flow_seeds},
          {"tracks", tracks, track_seeds},
          target<kNrnerf>,
          target<kNerfstudio>,
          target<kGibson>,
          target<kNerfiesLists>,
          target<kNerfiesCamera>,
          target<kColmapText>,
          target<kColmapTextCameras>,
          target<kColmapTextPoints>,
          target<kColmapBinary>,
          target<kColmapBinaryCameras>,
          target<kColmapBinaryPoints>,
          target<kGaussians>,
          target<kEasymocapLenses>,
          target<kEasymocapPoses>};
}

}  // namespace splinevox::fuzz
