// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

/// Entry points of the fuzzers: one per parser. libFuzzer drives them where there is clang
/// (-DSPLINEVOX_FUZZ=ON), the mutator of tests/torture everywhere.
namespace splinevox::fuzz {

struct Target {
  const char* name;
  /// Feeds any bytes to the parser. 0: it took them, 1: it refused them with an input Error. Anything else
  /// that it throws is a bug.
  int (*run)(const std::uint8_t* data, std::size_t size);
  /// Whole files, made by our own writers where there are some.
  std::vector<std::string> (*seeds)();
  /// Puts the checksums of a mutated file right, so that the parser behind them is reached; null: there are
  /// none, or nobody could.
  void (*mend)(std::string& file) = nullptr;
};

/// Every parser of files that other people may have written.
const std::vector<Target>& targets();

/// A folder of this process alone, in memory where possible; the readers take paths.
const std::string& folder();
/// Removes the folder of a process.
void remove_folder(long process);
/// Writes folder()/name in place and returns its path.
std::string put(const std::string& name, const std::uint8_t* data, std::size_t size);
/// The bytes that `write` leaves at the path it is given.
std::string made_by(const std::function<void(const std::string& path)>& write);
/// 0 if `parse` returned, 1 if it threw an input Error; lets everything else through.
int verdict(const std::function<void()>& parse);

void mend_png(std::string& file);
void mend_checkpoint(std::string& file);
void mend_vdb(std::string& file);

int dataset_json(const std::uint8_t*, std::size_t);
int png(const std::uint8_t*, std::size_t);
int jpeg(const std::uint8_t*, std::size_t);
int exr(const std::uint8_t*, std::size_t);
int model_vdb(const std::uint8_t*, std::size_t);
int checkpoint(const std::uint8_t*, std::size_t);
int training_state(const std::uint8_t*, std::size_t);
int manifest(const std::uint8_t*, std::size_t);
int config_toml(const std::uint8_t*, std::size_t);
int camera_path(const std::uint8_t*, std::size_t);
int points_csv(const std::uint8_t*, std::size_t);
int splat_ply(const std::uint8_t*, std::size_t);
/// A target for each file that poses are read from in the layouts of other programs.
std::vector<Target> layout_targets();

}  // namespace splinevox::fuzz
