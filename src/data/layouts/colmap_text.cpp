// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string_view>

#include "core/byte_order_mark.hpp"
#include "core/number_text.hpp"
#include "data/file_bytes.hpp"
#include "data/layouts/colmap_model.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;

/// The lines of a text file, with their numbers. Comments are left out, empty lines are not: of an image
/// without points the second is empty.
class Lines {
 public:
  explicit Lines(const fs::path& path)
      : file_(printable(path.string())),
        bytes_(read_bytes(path, file_, kLargestFile)),
        at_(byte_order_mark({reinterpret_cast<const char*>(bytes_.data()), bytes_.size()})) {}

  bool next() {
    do {
      if (at_ >= bytes_.size()) return false;
      const std::string_view rest(reinterpret_cast<const char*>(bytes_.data()) + at_, bytes_.size() - at_);
      line_ = rest.substr(0, rest.find('\n'));
      start_ = at_;
      at_ += line_.size() + 1;
      ++number_;
      if (!line_.empty() && line_.back() == '\r') line_.remove_suffix(1);
    } while (!line_.empty() && line_[0] == '#');
    rest_ = line_;
    return true;
  }
  bool blank() const { return line_.find_first_not_of(" \t") == std::string_view::npos; }
  std::string where() const { return file_ + ", line " + std::to_string(number_); }
  const std::string& file() const { return file_; }
  /// The next call of next() gives this line again.
  void again() {
    at_ = start_;
    --number_;
  }
  /// Whether the line holds the points of an image, x y id each, and not an image of its own, which ends in a
  /// picture's name.
  bool points() const {
    const std::size_t last = line_.find_last_not_of(" \t");
    if (last == std::string_view::npos) return true;
    const std::size_t gap = line_.find_last_of(" \t", last);
    const std::string_view word = line_.substr(gap + 1, last - gap);  // npos + 1 is 0
    if (!parse_number<double>(word)) return false;
    std::size_t words = 0;
    bool inside = false;
    for (const char c : line_) {
      const bool space = c == ' ' || c == '\t';
      words += !space && !inside ? 1 : 0;
      inside = !space;
    }
    return words % 3 == 0;
  }

  std::string_view word(const char* what) {
    const std::size_t begin = rest_.find_first_not_of(" \t");
    if (begin == std::string_view::npos) fail({where(), "the line is too short", what, "the line's end", ""});
    const std::size_t end = std::min(rest_.find_first_of(" \t", begin), rest_.size());
    const std::string_view word = rest_.substr(begin, end - begin);
    rest_.remove_prefix(end);
    return word;
  }
  template <class T>
  T number(const char* what) {
    const std::string_view text = word(what);
    const auto value = parse_number<T>(text);
    if (!value || !std::isfinite(double(*value)))
      fail({where(), "this is not a number", what, in_quotes(text), ""});
    return *value;
  }
  std::string remainder(const char* what) {
    const std::size_t begin = rest_.find_first_not_of(" \t");
    if (begin == std::string_view::npos) fail({where(), "the line is too short", what, "the line's end", ""});
    return std::string(rest_.substr(begin, rest_.find_last_not_of(" \t") + 1 - begin));
  }

 private:
  std::string file_;
  std::vector<std::uint8_t> bytes_;
  std::size_t at_ = 0, start_ = 0;  ///< of what follows, and of the line
  int number_ = 0;
  std::string_view line_, rest_;
};

void read_text_cameras(const fs::path& path, ColmapModel& model) {
  for (Lines lines(path); lines.next();) {
    if (lines.blank()) continue;
    const auto id = lines.number<std::int64_t>("a camera's number");
    const std::string name(lines.word("a camera model's name"));
    ColmapCamera camera;
    camera.kind = find_kind(name);
    if (!camera.kind)
      fail({lines.where(), "there is no such camera model", "a model of COLMAP's, such as OPENCV",
            in_quotes(name), ""});
    camera.width = lines.number<double>("the width");
    camera.height = lines.number<double>("the height");
    const int count = camera.kind->count();
    for (int i = 0; i < count; ++i)
      camera.params.push_back(lines.number<double>("a parameter of the camera"));
    if (!model.cameras.emplace(id, camera).second)
      fail({lines.where(), "this camera is there twice", "each number once", std::to_string(id), ""});
  }
}

void read_text_images(const fs::path& path, ColmapModel& model) {
  Lines lines(path);
  model.where = lines.file();
  while (lines.next()) {
    if (lines.blank()) continue;
    ColmapImage image;
    lines.number<std::int64_t>("an image's number");
    for (double& q : image.rotation) q = lines.number<double>("qw qx qy qz");
    for (int i = 0; i < 3; ++i) image.translation[i] = lines.number<double>("tx ty tz");
    image.camera = lines.number<std::int64_t>("a camera's number");
    image.name = lines.remainder("the picture's name");
    model.images.push_back(std::move(image));
    if (lines.next() && !lines.points()) lines.again();  // written by hand: no line of points
  }
}

void read_text_points(const fs::path& path, ColmapModel& model) {
  for (Lines lines(path); lines.next();) {
    if (lines.blank()) continue;
    lines.number<std::int64_t>("a point's number");
    Vec3d p;
    for (int i = 0; i < 3; ++i) p[i] = lines.number<double>("x y z");
    model.points.push_back(p);
  }
}

}  // namespace

ColmapModel read_colmap_text(const fs::path& folder) {
  ColmapModel model;
  read_text_cameras(folder / "cameras.txt", model);
  read_text_images(folder / "images.txt", model);
  std::error_code ignored;
  if (fs::exists(folder / "points3D.txt", ignored)) read_text_points(folder / "points3D.txt", model);
  return model;
}

}  // namespace splinevox::data
