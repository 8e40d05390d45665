// SPDX-License-Identifier: Apache-2.0
#include "fuzz/targets.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <filesystem>

#include "core/atomic_file.hpp"
#include "fuzz/seeds.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::fuzz {
namespace fs = std::filesystem;

namespace {

std::string folder_of(long process) {
  const fs::path memory = "/dev/shm";
  return ((fs::is_directory(memory) ? memory : fs::temp_directory_path()) /
          ("splinevox_fuzz_" + std::to_string(process)))
      .string();
}

}  // namespace

const std::string& folder() {
  static long owner = 0;
  static std::string path;
  if (owner != ::getpid()) {  // a fork has its own
    owner = ::getpid();
    path = folder_of(owner);
    fs::create_directories(path);
  }
  return path;
}

void remove_folder(long process) {
  std::error_code ignored;
  fs::remove_all(folder_of(process), ignored);
}

std::string put(const std::string& name, const std::uint8_t* data, std::size_t size) {
  const std::string path = folder() + "/" + name;
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  bool good = file >= 0;
  while (good && size > 0) {
    const ssize_t n = ::write(file, data, size);
    good = n > 0;
    if (good) {
      data += n;
      size -= std::size_t(n);
    }
  }
  if (file >= 0) ::close(file);
  if (!good) throw std::runtime_error("set-up: cannot write " + path);
  return path;
}

std::string made_by(const std::function<void(const std::string&)>& write) {
  const std::string path = folder() + "/seed";
  fs::remove(path);
  write(path);
  return read_file(path);
}

int verdict(const std::function<void()>& parse) {
  try {
    parse();
    return 0;
  } catch (const Error& error) {
    if (error.fault != Fault::input) throw;
    return 1;
  }
}

const std::vector<Target>& targets() {
  static const std::vector<Target> all = [] {
    std::vector<Target> list = {
        {"dataset_json", dataset_json, dataset_seeds},
        {"png", png, png_seeds, mend_png},
        {"jpeg", jpeg, jpeg_seeds},
        {"exr", exr, exr_seeds},
        {"model_vdb", model_vdb, model_seeds},
        {"sealed_vdb", model_vdb, model_seeds, mend_vdb},
        {"checkpoint", checkpoint, checkpoint_seeds, mend_checkpoint},
        {"training_state", training_state, state_seeds},
        {"manifest", manifest, manifest_seeds},
        {"config_toml", config_toml, config_seeds},
        {"camera_path", camera_path, camera_seeds},
        {"points_csv", points_csv, points_seeds},
        {"splat_ply", splat_ply, splat_seeds},
    };
    for (const Target& layout : layout_targets()) list.push_back(layout);
    return list;
  }();
  return all;
}

}  // namespace splinevox::fuzz
