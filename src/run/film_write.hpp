// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <string>

#include "splinevox/core/image.hpp"

namespace splinevox::run {

/// An mp4 file written by the system's ffmpeg through a pipe. Ctrl-C in the terminal is for this process
/// alone to hear.
class Film {
 public:
  /// Throws Error (input) if there is no ffmpeg.
  Film(const std::string& path, int width, int height, double fps);
  ~Film();
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;

  /// One picture of 3 channels in [0, 1]. Throws Error (output).
  void add(const Image& picture);
  /// Closes the pipe, waits, and looks whether all pictures are in the film. Throws Error (output) if ffmpeg
  /// was not content or they are not.
  void finish();

 private:
  void check_draft() const;
  std::string path_, draft_;  ///< what ffmpeg writes takes its name when it is whole
  pid_t process_ = -1;
  int pipe_ = -1, width_ = 0, height_ = 0;
  std::size_t frames_ = 0;  ///< that were added
};

/// Removes drafts of films from a folder. @pre no other process writes films into it
void remove_film_drafts(const std::string& folder);

}  // namespace splinevox::run
