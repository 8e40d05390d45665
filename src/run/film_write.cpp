// SPDX-License-Identifier: Apache-2.0
#include "run/film_write.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include "core/handle.hpp"
#include "core/own_folder.hpp"
#include "core/spawn.hpp"
#include "core/system.hpp"
#include "data/pictures/film_read.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::run {
namespace {

/// Whether the boxes that an mp4 file consists of are all there, to the last byte.
bool is_complete(int file) {
  struct stat info {};
  if (::fstat(file, &info) != 0) return false;
  const auto size = std::uint64_t(info.st_size);
  bool index = false, pictures = false;
  std::uint64_t at = 0;
  while (at < size) {
    std::array<unsigned char, 16> head{};  // size (4), name (4), and after a size of 1 the true size (8)
    if (retried([&] { return ::pread(file, head.data(), head.size(), off_t(at)); }) < 8) return false;
    const auto number = [&](std::size_t first, std::size_t bytes) {
      std::uint64_t value = 0;
      for (std::size_t i = first; i < first + bytes; ++i) value = value << 8 | head[i];
      return value;
    };
    const std::string_view name(reinterpret_cast<const char*>(head.data()) + 4, 4);
    const std::uint64_t box = number(0, 4) == 1 ? number(8, 8) : number(0, 4);
    if (box < 8 || box > size - at) return false;
    index |= name == "moov";
    pictures |= name == "mdat";
    at += box;
  }
  return index && pictures;
}

/// As draft_name makes it of a film: ".rgb.mp4.0123456789abcdef.tmp".
bool is_film_draft(std::string_view name) {
  constexpr std::string_view kFilm = ".mp4.", kDraft = ".tmp", kHex = "0123456789abcdef";
  constexpr std::size_t kDigits = 16, kEnd = kFilm.size() + kDigits + kDraft.size();
  if (name.size() < kEnd + 2 || name.front() != '.') return false;
  const std::string_view end = name.substr(name.size() - kEnd);
  return end.starts_with(kFilm) && end.ends_with(kDraft) &&
         end.substr(kFilm.size(), kDigits).find_first_not_of(kHex) == end.npos;
}

}  // namespace

Film::Film(const std::string& path, int width, int height, double fps)
    : path_(path), draft_(draft_name(path)), width_(width), height_(height) {
  if (std::filesystem::is_symlink(path))
    fail_output({path, "could not be written", "a file, or a name that is free",
                 "a link, and it is not followed", "remove the link, or choose another folder for --out"});
  int ends[2];
  if (!make_pipe(ends)) fail_output({path, "no pipe to ffmpeg", "", std::strerror(errno), ""});
  if (!Handle(draft_, O_CREAT | O_EXCL | O_WRONLY | O_NOFOLLOW).ok()) {  // ours before ffmpeg opens it
    const int why = errno;
    ::close(ends[0]);
    ::close(ends[1]);
    fail_output({path, "could not be written", "room and permission", std::strerror(why), ""});
  }
  // yuv420p wants even sides; libx264 at 18 is visually lossless. Without a matrix ffmpeg takes that of
  // BT.601, and without tags players take large pictures for BT.709.
  const std::vector<std::string> words = {"ffmpeg",
                                          "-y",
                                          "-loglevel",
                                          "error",
                                          "-f",
                                          "rawvideo",
                                          "-pix_fmt",
                                          "rgb24",
                                          "-s",
                                          fmt::format("{}x{}", width, height),
                                          "-r",
                                          fmt::format("{}", fps),
                                          "-i",
                                          "-",
                                          "-an",
                                          "-vf",
                                          "pad=ceil(iw/2)*2:ceil(ih/2)*2,"
                                          "scale=out_color_matrix=bt709:out_range=tv",
                                          "-c:v",
                                          "libx264",
                                          "-crf",
                                          "18",
                                          "-pix_fmt",
                                          "yuv420p",
                                          "-colorspace",
                                          "bt709",
                                          "-color_primaries",
                                          "bt709",
                                          "-color_trc",
                                          "iec61966-2-1",
                                          "-color_range",
                                          "tv",
                                          "-movflags",
                                          "+faststart",
                                          "-f",
                                          "mp4",
                                          "file:" + draft_};
  process_ = spawn({.program = words.front(), .words = words, .input = ends[0], .own_group = true});
  const int error = errno;
  ::close(ends[0]);
  pipe_ = ends[1];
  if (process_ > 0) return;
  ::close(pipe_);
  ::unlink(draft_.c_str());
  fail({"--format mp4", "ffmpeg cannot be started", "the program ffmpeg", std::strerror(error),
        "apt-get install ffmpeg, or --format png"});
}

Film::~Film() {
  if (pipe_ >= 0) ::close(pipe_);
  if (process_ <= 0) return;
  ended_well(process_);
  ::unlink(draft_.c_str());  // ffmpeg takes the end of the pictures for the end of the film
}

void Film::add(const Image& picture) {
  std::vector<unsigned char> bytes(picture.data.size());
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = (unsigned char)(std::lround(255 * std::clamp(picture.data[i], 0.0f, 1.0f)));
  if (picture.width != width_ || picture.height != height_ || picture.channels != 3)
    fail_output({path_, "the pictures of a film have one size", fmt::format("{}x{}", width_, height_),
                 fmt::format("{}x{}", picture.width, picture.height), "--format png"});
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = ::write(pipe_, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) fail_output({path_, "ffmpeg ended early", "", std::strerror(errno), "its message is above"});
    done += std::size_t(n);
  }
  ++frames_;
}

void Film::finish() {
  ::close(pipe_);
  pipe_ = -1;
  const bool content = ended_well(std::exchange(process_, -1));
  try {
    if (!content) fail_output({path_, "ffmpeg could not write the film", "", "", "its message is above"});
    check_draft();
    if (::rename(draft_.c_str(), path_.c_str()) != 0)
      fail_output({path_, "could not be written", "", std::strerror(errno), ""});
  } catch (const Error&) {
    ::unlink(draft_.c_str());
    throw;
  }
}

/// ffmpeg may call it a success when the disk is full.
void Film::check_draft() const {
  const auto broken = [&](const std::string& got) {
    fail_output({path_, "the film is not whole", fmt::format("{} pictures", frames_), got,
                 "free space on this disk, or choose another output folder"});
  };
  Handle file(draft_, O_RDONLY | O_NOFOLLOW);
  if (!file.ok() || retried([&] { return ::fsync(file.get()); }) != 0) broken(std::strerror(errno));
  if (!is_complete(file.get())) broken("a file that ends early");
  std::size_t found = 0;
  try {
    found = data::film_facts(draft_, path_).times.size();
  } catch (const Error& e) {
    broken(e.problem.what);
  }
  if (found != frames_) broken(fmt::format("{}", found));
}

void remove_film_drafts(const std::string& folder) {
  std::error_code ignored;
  for (const std::string& name : names_in_folder(folder)) {
    const std::filesystem::path path = std::filesystem::path(folder) / name;
    if (is_film_draft(name) &&
        std::filesystem::is_regular_file(std::filesystem::symlink_status(path, ignored)))
      std::filesystem::remove(path, ignored);
  }
}

}  // namespace splinevox::run
