// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include "python/convert.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/posed_pictures.hpp"

namespace splinevox::python {
namespace {

using Matrix = std::array<double, 16>;

std::string at(const char* argument, std::size_t i) {
  return std::string(argument) + "[" + std::to_string(i) + "]";
}

/// Copies height x width x (3 or 4) values as RGBA; `opaque` is the alpha of those without one.
template <class From, class To, class Change>
void copy_rgba(const py::array_t<From, py::array::c_style | py::array::forcecast>& a, To opaque, To* out,
               const Change& change) {
  const From* from = a.data();
  const bool alpha = a.shape(2) == 4;
  for (py::ssize_t i = 0; i < a.shape(0) * a.shape(1); ++i) {
    for (int c = 0; c < 3; ++c) *out++ = change(*from++);
    *out++ = alpha ? change(*from++) : opaque;
  }
}

Picture whole_picture(const py::array& a, int bytes) {
  Image16 image{int(a.shape(1)), int(a.shape(0)), {}};
  image.rgba.resize(4 * image.pixels());
  if (bytes == 1)
    copy_rgba<std::uint8_t>(a, std::uint16_t(65535), image.rgba.data(),
                            [](std::uint8_t v) { return std::uint16_t(257 * v); });
  else
    copy_rgba<std::uint16_t>(a, std::uint16_t(65535), image.rgba.data(), [](std::uint16_t v) { return v; });
  return image;
}

/// Floats within [0, 1] are rounded to 16 bits, as a PNG has them; others are kept as OpenEXR's are. Whole
/// numbers up to 255 are no light: they are bytes that were not divided. Neither are others that are bright
/// on the mean, as bytes are that were resized.
Picture real_picture(const py::array& a, const std::string& where) {
  Image image(int(a.shape(1)), int(a.shape(0)), 4);
  copy_rgba<float>(a, 1.0f, image.data.data(), [](float v) { return v; });
  constexpr float kByte = 255, kBright = 16;
  float most = 0;
  double colours = 0;
  bool whole_numbers = true;
  for (const float v : image.data) {
    whole_numbers = whole_numbers && v == std::floor(v);
    if (!(v >= 0 && std::isfinite(v)))
      fail({where, "a value is below 0 or not finite", "display values, 1 = 1", std::to_string(v), ""});
    most = std::max(most, v);
  }
  if (whole_numbers && most > kBright && most <= kByte)
    fail({where, "the floats are whole numbers up to " + std::to_string(int(most)), "display values, 1 = 1",
          "", "divide by 255, or hand the bytes over as uint8"});
  for (std::size_t i = 0; i < image.data.size(); ++i) colours += i % 4 < 3 ? double(image.data[i]) : 0.0;
  if (const double mean = colours / (3.0 * double(image.pixels())); mean > kBright)
    fail({where, "the floats are " + std::to_string(mean) + " on the mean", "display values, 1 = 1", "",
          "divide by the largest value of their range, such as 255"});
  if (most > 1) return Picture(image);
  Image16 whole{image.width, image.height, {}};
  for (const float v : image.data) whole.rgba.push_back(std::uint16_t(std::lround(v * 65535)));
  return whole;
}

Picture picture_of(const py::handle& item, const std::string& where) {
  const py::array a = py::array::ensure(item);
  if (!a || a.ndim() != 3 || (a.shape(2) != 3 && a.shape(2) != 4) || a.shape(0) < 1 || a.shape(1) < 1 ||
      a.shape(0) > 65536 || a.shape(1) > 65536)
    fail({where, "this is not a picture", "an array of shape (height, width, 3 or 4)",
          a ? std::string(py::str(a.attr("shape"))) : std::string(py::str(py::type::of(item))), ""});
  const char kind = a.dtype().kind();
  const auto bytes = a.dtype().itemsize();
  if (kind == 'u' && bytes <= 2) return whole_picture(a, int(bytes));
  if (kind == 'f') return real_picture(a, where);
  fail_values(where, a);
}

Matrix pose_of(const Doubles& poses, std::size_t i) {
  Matrix m{};
  m[15] = 1;
  std::copy_n(poses.data() + i * std::size_t(poses.shape(1) * 4), poses.shape(1) * 4, m.begin());
  return m;
}

/// fx, fy, cx and cy of a camera matrix.
std::array<double, 4> lens_of(const Doubles& k, std::size_t i) {
  const double* m = k.data() + (k.ndim() == 3 ? 9 * i : 0);
  if (m[1] != 0 || m[3] != 0 || m[6] != 0 || m[7] != 0 || m[8] != 1)
    fail({at("intrinsics", i), "this is not the matrix of a pinhole camera",
          "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]], pixels", "",
          "undistort pictures of bent or skewed lenses"});
  return {m[0], m[4], m[2], m[5]};
}

PixelMask mask_of(const py::handle& item, const std::string& where) {
  if (item.is_none()) return {};
  const auto a = py::array_t<bool, py::array::c_style | py::array::forcecast>::ensure(item);
  if (!a || a.ndim() != 2)
    fail({where, "this is not a mask", "a bool array of shape (height, width), or None",
          a ? std::string(py::str(a.attr("shape"))) : "something else", ""});
  PixelMask mask(int(a.shape(1)), int(a.shape(0)));
  for (std::size_t p = 0; p < mask.pixels(); ++p)
    if (a.data()[p]) mask.set(p);
  return mask.count() > 0 ? mask : PixelMask();
}

void check_count(const char* argument, std::size_t got, std::size_t wanted) {
  if (got != wanted)
    fail({argument, "there is not one for each picture", std::to_string(wanted), std::to_string(got), ""});
}

/// "0007" among thousands.
std::string number_name(std::size_t i, std::size_t of) {
  const std::string text = std::to_string(i), last = std::to_string(of - 1);
  return std::string(std::max<std::size_t>(4, last.size()) - text.size(), '0') + text;
}

}  // namespace

std::shared_ptr<Dataset> dataset_of_arrays(const py::sequence& images, const Doubles& poses, const Doubles& k,
                                           const std::vector<double>& times,
                                           const std::optional<std::vector<std::string>>& splits,
                                           const std::optional<std::vector<std::string>>& names,
                                           const std::optional<std::vector<std::string>>& cameras,
                                           const std::optional<py::sequence>& ignored,
                                           const std::optional<Corners>& box, const std::string& name) {
  const std::size_t n = images.size();
  if (n == 0) fail({"images", "there are none", "one picture or more", "0", ""});
  if (poses.ndim() != 3 || (poses.shape(1) != 3 && poses.shape(1) != 4) || poses.shape(2) != 4)
    fail({"camera_to_world", "these are not matrices", "an array of shape (n, 4, 4) or (n, 3, 4)",
          py::str(poses.attr("shape")), ""});
  const bool each = k.ndim() == 3;
  if ((k.ndim() != 2 && !each) || k.shape(k.ndim() - 1) != 3 || k.shape(k.ndim() - 2) != 3)
    fail({"intrinsics", "these are not camera matrices", "an array of shape (3, 3) or (n, 3, 3)",
          py::str(k.attr("shape")), ""});
  check_count("camera_to_world", std::size_t(poses.shape(0)), n);
  if (each) check_count("intrinsics", std::size_t(k.shape(0)), n);
  check_count("times", times.size(), n);
  if (splits) check_count("splits", splits->size(), n);
  if (names) check_count("names", names->size(), n);
  if (cameras) check_count("cameras", cameras->size(), n);
  if (ignored) check_count("ignored", ignored->size(), n);

  std::vector<PosedSplit> parts;
  if (!splits) parts.push_back({"", {}});
  for (const char* part : {"train", "val", "test"})
    if (splits && std::find(splits->begin(), splits->end(), part) != splits->end())
      parts.push_back({part, {}});
  for (std::size_t i = 0; i < n; ++i) {
    const std::string split = splits ? (*splits)[i] : "";
    const auto part =
        std::find_if(parts.begin(), parts.end(), [&](const PosedSplit& p) { return p.name == split; });
    if (part == parts.end())
      fail({at("splits", i), "there is no such split", "train, val or test", split, ""});
    const auto [fx, fy, cx, cy] = lens_of(k, i);
    part->pictures.push_back({names ? (*names)[i] : number_name(i, n), picture_of(images[i], at("images", i)),
                              pose_of(poses, i), fx, fy, cx, cy, times[i], cameras ? (*cameras)[i] : "",
                              ignored ? mask_of((*ignored)[i], at("ignored", i)) : PixelMask()});
  }
  std::optional<Box> bounds;
  if (box) {
    const auto& [lo, hi] = *box;
    bounds = Box{{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}};
    for (int c = 0; c < 3; ++c)
      if (!(lo[std::size_t(c)] < hi[std::size_t(c)]))
        fail({"box", "its corners are not in order", "((x, y, z), (X, Y, Z)) with x < X, y < Y, z < Z",
              std::to_string(lo[std::size_t(c)]) + ", " + std::to_string(hi[std::size_t(c)]), ""});
  }
  auto data = std::make_shared<Dataset>();
  released([&] { *data = dataset_of(std::move(parts), name, bounds); });
  return data;
}

}  // namespace splinevox::python
