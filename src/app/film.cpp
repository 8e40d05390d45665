// SPDX-License-Identifier: Apache-2.0
#include "app/film.hpp"

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

namespace splinevox::app {

Film::Film(const std::string& path, int width, int height, double fps) : path_(path), width_(width), height_(height) {
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
                                          "file:" + path};
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
    : path_(other.path_), process_(other.process_), pipe_(other.pipe_), width_(other.width_), height_(other.height_) {
  other.process_ = -1;
  other.pipe_ = -1;
}

Film::~Film() {
  if (pipe_ >= 0) ::close(pipe_);
  if (process_ > 0) ::waitpid(process_, nullptr, 0);
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
  int status = 0;
  ::waitpid(process_, &status, 0);
  process_ = -1;
  if (status != 0) fail_output({path_, "ffmpeg could not write the film", "", "", "its message is above"});
}

}  // namespace splinevox::app
