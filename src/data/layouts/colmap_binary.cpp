// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cmath>
#include <cstring>

#include "data/file_bytes.hpp"
#include "data/layouts/colmap_model.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;
static_assert(std::endian::native == std::endian::little);

/// Values one after the other, never past the end.
class Values {
 public:
  explicit Values(const fs::path& path)
      : file_(printable(path.string())), bytes_(read_bytes(path, file_, kLargestFile)) {}

  template <class T>
  T get() {
    need(sizeof(T));
    T value;
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  double finite(const char* what) {
    const double value = get<double>();
    if (!std::isfinite(value))
      fail({where(), std::string(what) + " is not finite", "a finite number", number(value), ""});
    return value;
  }
  /// How many things of at least `smallest` bytes follow: refused if the file is too short for them.
  std::uint64_t count(std::uint64_t smallest) {
    const auto n = get<std::uint64_t>();
    if (n > (bytes_.size() - at_) / smallest)
      fail({where(), "the file is shorter than the number of its entries asks for",
            "room for " + std::to_string(n), std::to_string(bytes_.size() - at_) + " bytes",
            "copy the file again"});
    return n;
  }
  void skip(std::uint64_t n) {
    need(n);
    at_ += n;
  }
  std::string text() {
    const auto* begin = bytes_.data() + at_;
    const void* end = at_ < bytes_.size() ? std::memchr(begin, 0, bytes_.size() - at_) : nullptr;
    if (!end) fail({where(), "a name has no end", "a zero byte", "the file's end", "copy the file again"});
    const std::string text(reinterpret_cast<const char*>(begin), static_cast<const char*>(end));
    at_ += text.size() + 1;
    return text;
  }
  void end() const {
    if (at_ < bytes_.size())
      fail({where(), "there is more in the file than its entries", "the file's end",
            std::to_string(bytes_.size() - at_) + " bytes more", "copy the file again"});
  }
  std::string where() const { return file_ + ", byte " + std::to_string(at_); }
  const std::string& file() const { return file_; }

 private:
  void need(std::uint64_t n) const {
    if (n > bytes_.size() - at_)
      fail({where(), "the file ends early", std::to_string(n) + " bytes more",
            std::to_string(bytes_.size() - at_), "copy the file again"});
  }
  std::string file_;
  std::vector<std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

void read_binary_cameras(const fs::path& path, ColmapModel& model) {
  Values in(path);
  for (std::uint64_t n = in.count(24); n > 0; --n) {
    const auto id = in.get<std::uint32_t>();
    const auto kind = in.get<std::int32_t>();
    ColmapCamera camera;
    camera.kind = find_kind(std::int64_t(kind));
    if (!camera.kind)
      fail({in.where(), "there is no such camera model", "0 to 17", std::to_string(kind), ""});
    camera.width = double(in.get<std::uint64_t>());
    camera.height = double(in.get<std::uint64_t>());
    const int count = camera.kind->count();
    for (int i = 0; i < count; ++i) camera.params.push_back(in.finite("a parameter of the camera"));
    if (!model.cameras.emplace(id, camera).second)
      fail({in.where(), "this camera is there twice", "each number once", std::to_string(id), ""});
  }
  in.end();
}

void read_binary_images(const fs::path& path, ColmapModel& model) {
  Values in(path);
  model.where = in.file();
  for (std::uint64_t n = in.count(73); n > 0; --n) {
    ColmapImage image;
    in.get<std::uint32_t>();
    for (double& q : image.rotation) q = in.finite("a rotation");
    for (int i = 0; i < 3; ++i) image.translation[i] = in.finite("a translation");
    image.camera = in.get<std::uint32_t>();
    image.name = in.text();
    in.skip(24 * in.count(24));
    model.images.push_back(std::move(image));
  }
  in.end();
}

void read_binary_points(const fs::path& path, ColmapModel& model) {
  Values in(path);
  for (std::uint64_t n = in.count(51); n > 0; --n) {
    in.get<std::uint64_t>();
    Vec3d p;
    for (int i = 0; i < 3; ++i) p[i] = in.finite("a point");
    in.skip(3);
    const double error = in.get<double>();
    const std::uint64_t seen = in.count(8);
    in.skip(8 * seen);
    model.points.push_back(p);
    model.observations += double(seen);
    model.error += double(seen) * error;
  }
  if (model.observations > 0) model.error /= model.observations;
  in.end();
}

}  // namespace

ColmapModel read_colmap_binary(const fs::path& folder) {
  ColmapModel model;
  read_binary_cameras(folder / "cameras.bin", model);
  read_binary_images(folder / "images.bin", model);
  std::error_code ignored;
  if (fs::exists(folder / "points3D.bin", ignored)) read_binary_points(folder / "points3D.bin", model);
  return model;
}

}  // namespace splinevox::data
