// SPDX-License-Identifier: Apache-2.0
// What other layouts of data sets are made of: JPEG, tables of numpy, models of COLMAP.
#include "data/jpeg_bytes.hpp"
#include "data/layouts.hpp"
#include "fuzz/seeds.hpp"
#include "fuzz/targets.hpp"
#include "splinevox/core/atomic_file.hpp"
#include "splinevox/data/image_read.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox::fuzz {
namespace {

using test::ColmapLens;
using test::TempFolder;
const ColmapLens kLens{"OPENCV", 4, {11, 12, 5.5, 4.25, -0.12, 0.03, 0.002, -0.003}};
constexpr int kFew = 3;

std::string text_of(const std::filesystem::path& path) { return read_file(path.string()); }

/// The folder `name` of this process with a data set that `write` makes once; then the file in it gets the bytes and all is read.
template <class Write>
int load_with(const std::string& name, const std::string& file, const Write& write, const std::uint8_t* data, std::size_t size) {
  const std::filesystem::path set = std::filesystem::path(folder()) / name;
  if (!std::filesystem::exists(set)) write(set);
  put(name + "/" + file, data, size);
  return verdict([&] { load_dataset(set.string()); });
}

}  // namespace

int jpeg(const std::uint8_t* data, std::size_t size) {
  const std::string path = put("picture.jpg", data, size);
  return verdict([&] { read_jpeg(path); });
}

std::vector<std::string> jpeg_seeds() {
  return {test::jpeg_bytes(), test::jpeg_bytes({20, 11, 1}), test::jpeg_bytes({33, 17, 3, 70, true}), test::jpeg_bytes({16, 8, 4})};
}

int npy(const std::uint8_t* data, std::size_t size) {
  return load_with("llff", "poses_bounds.npy", [](const std::filesystem::path& p) { test::write_llff(p, test::true_cameras({}, kFew)); }, data, size);
}

std::vector<std::string> npy_seeds() {
  const test::Bytes wide = test::npy_bytes(kFew, 17, test::llff_rows(test::true_cameras({}, kFew), 4)), single = test::npy_bytes(kFew, 17, test::llff_rows(test::true_cameras({}, kFew), 4), "<f4");
  return {{wide.begin(), wide.end()}, {single.begin(), single.end()}};
}

int colmap_text(const std::uint8_t* data, std::size_t size) {
  return load_with("colmap_text", "sparse/0/images.txt", [](const std::filesystem::path& p) { test::write_colmap_text(p, test::true_cameras({}, kFew), kLens); }, data, size);
}

std::vector<std::string> colmap_text_seeds() {
  const TempFolder set;
  test::write_colmap_text(set.path(), test::true_cameras({}, kFew), kLens);
  return {text_of(set.path() / "sparse/0/images.txt")};
}

int colmap_binary(const std::uint8_t* data, std::size_t size) {
  return load_with("colmap_binary", "sparse/0/images.bin", [](const std::filesystem::path& p) { test::write_colmap_binary(p, test::true_cameras({}, kFew), kLens); }, data, size);
}

std::vector<std::string> colmap_binary_seeds() {
  const TempFolder set;
  test::write_colmap_binary(set.path(), test::true_cameras({}, kFew), kLens);
  return {text_of(set.path() / "sparse/0/images.bin")};
}

}  // namespace splinevox::fuzz
