// SPDX-License-Identifier: Apache-2.0
// fuzz_corpus DIR: writes the seeds of every target to DIR/TARGET/, the corpora that libFuzzer starts from.
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "fuzz/targets.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "fuzz_corpus DIR\n");
    return 2;
  }
  for (const splinevox::fuzz::Target& target : splinevox::fuzz::targets()) {
    const std::filesystem::path folder = std::filesystem::path(argv[1]) / target.name;
    std::filesystem::create_directories(folder);
    int n = 0;
    for (const std::string& seed : target.seeds())
      std::ofstream(folder / ("seed_" + std::to_string(n++)), std::ios::binary) << seed;
  }
  splinevox::fuzz::remove_folder(::getpid());
}
