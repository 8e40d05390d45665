// SPDX-License-Identifier: Apache-2.0
#include "run/film_write.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <vector>

#include "splinevox/core/error.hpp"

extern char** environ;

namespace splinevox::run {

Film::Film(const std::string& path, int width, int height, double fps)
    : path_(path), draft_(fmt::format("{}.{}.tmp", path, ::getpid())), width_(width), height_(height) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) fail_output({path, "no pipe to ffmpeg", "", std::strerror(errno), ""});
  // yuv420p wants even sides; libx264 at 18 is visually lossless
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
                                          "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                                          "-c:v",
                                          "libx264",
                                          "-crf",
                                          "18",
                                          "-pix_fmt",
                                          "yuv420p",
                                          "-movflags",
                                          "+faststart",
                                          "-f",
                                          "mp4",
                                          "file:" + draft_};
  std::vector<char*> arguments;
  for (const std::string& w : words) arguments.push_back(const_cast<char*>(w.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[0], STDIN_FILENO);
  const int error = ::posix_spawnp(&process_, "ffmpeg", &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[0]);
  pipe_ = ends[1];
  if (error == 0) return;
  process_ = -1;
  ::close(pipe_);
  fail({"--format mp4", "ffmpeg cannot be started", "the program ffmpeg", std::strerror(error),
        "apt-get install ffmpeg, or --format png"});
}

Film::Film(Film&& other) noexcept
    : path_(other.path_),
      draft_(other.draft_),
      process_(other.process_),
      pipe_(other.pipe_),
      width_(other.width_),
      height_(other.height_) {
  other.process_ = -1;
  other.pipe_ = -1;
}

Film::~Film() {
  if (pipe_ >= 0) ::close(pipe_);
  if (process_ <= 0) return;
  ::waitpid(process_, nullptr, 0);
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
}

void Film::finish() {
  ::close(pipe_);
  pipe_ = -1;
  int status = -1;
  while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  const int file = status == 0 ? ::open(draft_.c_str(), O_RDONLY | O_CLOEXEC) : -1;
  const bool whole = file >= 0 && ::fsync(file) == 0;
  if (file >= 0) ::close(file);
  if (whole && ::rename(draft_.c_str(), path_.c_str()) == 0) return;
  ::unlink(draft_.c_str());
  fail_output({path_, "ffmpeg could not write the film", "", "", "its message is above"});
}

}  // namespace splinevox::run
