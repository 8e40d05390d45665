// SPDX-License-Identifier: Apache-2.0
#include "data/pictures/film_read.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <sstream>

#include "data/file_bytes.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

extern char** environ;

namespace splinevox::data {
namespace {

/// A program whose output is read here.
class Reader {
 public:
  Reader(const std::vector<std::string>& words, const std::string& where) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) fail({where, "no pipe to " + words[0], "", std::strerror(errno), ""});
    std::vector<char*> arguments;
    for (const std::string& w : words) arguments.push_back(const_cast<char*>(w.c_str()));
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    const int error =
        ::posix_spawnp(&process_, words[0].c_str(), &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    pipe_ = ends[0];
    if (error == 0) return;
    ::close(pipe_);
    fail({where, words[0] + " cannot be started, and films are read with it", "the program " + words[0],
          std::strerror(error), "apt-get install ffmpeg"});
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() { finish(); }

  /// Fills the buffer; false if the output ended before.
  bool read(char* to, std::size_t size) {
    while (size > 0) {
      const ssize_t n = ::read(pipe_, to, size);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return false;
      to += n;
      size -= std::size_t(n);
    }
    return true;
  }

  /// Ends the program; whether it ended well by itself.
  bool finish() {
    if (process_ <= 0) return true;
    ::close(pipe_);
    int status = 0;
    while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) continue;
    process_ = -1;
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
  }

 private:
  pid_t process_ = -1;
  int pipe_ = -1;
};

/// The number behind "key=" in lines of them; 0 if there is none.
int value_of(const std::string& lines, const std::string& key) {
  std::istringstream in(lines);
  for (std::string line; std::getline(in, line);)
    if (line.rfind(key + "=", 0) == 0) {
      int value = 0;
      std::from_chars(line.data() + key.size() + 1, line.data() + line.size(), value);
      return value;
    }
  return 0;
}

}  // namespace

FilmFacts film_facts(const std::filesystem::path& path, const std::string& where) {
  file_size_of(path, where);
  Reader probe(
      {"ffprobe", "-v", "error", "-select_streams", "v:0", "-count_packets", "-show_entries",
       "stream=width,height,nb_read_packets", "-of", "default=noprint_wrappers=1", "file:" + path.string()},
      where);
  std::string lines;
  for (char c; lines.size() < 10000 && probe.read(&c, 1);) lines += c;
  const FilmFacts facts{value_of(lines, "width"), value_of(lines, "height"),
                        value_of(lines, "nb_read_packets")};
  if (!probe.finish() || facts.width < 1 || facts.height < 1 || facts.frames < 1)
    fail({where, "this is no film that ffprobe can read", "a video stream with at least one frame", "none",
          "copy the file again"});
  if (facts.width > 65536 || facts.height > 65536 || double(facts.width) * facts.height > double(1 << 28))
    fail({where, "the film's size is out of range", "1 to 65536 pixels a side and at most 2^28 in all",
          std::to_string(facts.width) + " x " + std::to_string(facts.height), ""});
  return facts;
}

void read_film(const std::filesystem::path& path, const FilmFacts& facts, const std::vector<int>& wanted,
               const std::function<void(std::size_t, Image16&&)>& take, const std::string& where) {
  Reader film({"ffmpeg", "-v", "error", "-noautorotate", "-i", "file:" + path.string(), "-map", "0:v:0", "-f",
               "rawvideo", "-pix_fmt", "rgb24", "-fps_mode", "passthrough", "-"},
              where);
  std::vector<char> rgb(std::size_t(facts.width) * facts.height * 3);
  std::size_t next = 0;
  for (int i = 0; next < wanted.size(); ++i) {
    if (!film.read(rgb.data(), rgb.size()))
      fail({where, "the film ends early",
            "frame " + std::to_string(wanted[next]) + " of " + std::to_string(facts.frames),
            std::to_string(i) + " frames that ffmpeg could decode", "copy the file again"});
    if (i != wanted[next]) continue;
    Image16 image{facts.width, facts.height, {}};
    image.rgba.resize(image.pixels() * 4, 65535);
    for (std::size_t p = 0; p < image.pixels(); ++p)
      for (std::size_t c = 0; c < 3; ++c)
        image.rgba[4 * p + c] = std::uint16_t(257 * std::uint8_t(rgb[3 * p + c]));
    take(next++, std::move(image));
  }
}

}  // namespace splinevox::data
