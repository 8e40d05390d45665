// SPDX-License-Identifier: Apache-2.0
#include "io/vdb/vdb_scan.hpp"

#include <cstring>

#include "core/hash.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

constexpr std::string_view kSealMagic = "SPVXSEAL";
constexpr std::int64_t kVdbMagic = 0x56444220;
constexpr std::uint32_t kOldestVersion = 222, kNewestVersion = 224;  // the layouts that this scan knows

/// Reads fields in file order; any field that would pass the end throws.
class Cursor {
 public:
  Cursor(const std::string& path, std::string_view bytes, const VdbLimits& limits)
      : path_(path), bytes_(bytes), limits_(limits) {}

  template <class T>
  T take(const char* what) {
    need(sizeof(T), what);
    T v;
    std::memcpy(&v, bytes_.data() + at_, sizeof v);
    at_ += sizeof v;
    return v;
  }
  void skip(std::uint64_t n, const char* what) {
    need(n, what);
    at_ += n;
  }
  /// A length and as many bytes.
  void text(const char* what) {
    const std::uint32_t n = take<std::uint32_t>(what);
    if (n > limits_.max_text)
      bad(std::string("the length of ") + what + " is out of range",
          "at most " + std::to_string(limits_.max_text) + " bytes", std::to_string(n));
    skip(n, what);
  }
  /// A metadata table: count, then name, type and sized value of each entry.
  void metadata() {
    const std::uint32_t n = take<std::uint32_t>("the metadata count");
    for (std::uint32_t i = 0; i < n; ++i) {
      text("a metadata name");
      text("a metadata type");
      text("a metadata value");
    }
  }
  std::uint64_t at() const { return at_; }
  void move_to(std::uint64_t at) { at_ = at; }
  [[noreturn]] void bad(std::string what, std::string expected = "", std::string got = "") const {
    fail({.where = path_ + ", byte " + std::to_string(at_),
          .what = std::move(what),
          .expected = std::move(expected),
          .got = std::move(got),
          .hint = "the file is damaged or not complete: copy or export it again"});
  }

 private:
  void need(std::uint64_t n, const char* what) const {
    const std::uint64_t left = bytes_.size() - at_;
    if (n > left)
      bad(std::string("the file ends inside ") + what, std::to_string(n) + " more bytes",
          std::to_string(left));
  }

  const std::string& path_;
  std::string_view bytes_;
  const VdbLimits& limits_;
  std::uint64_t at_ = 0;
};

/// What stands before a grid's voxels.
void scan_grid(Cursor& cursor) {
  cursor.skip(4, "a grid's compression flags");
  cursor.metadata();
  cursor.text("a transform's type");
}

void scan_grids(Cursor& cursor, std::uint64_t size, bool offsets, const VdbLimits& limits) {
  const auto grids = cursor.take<std::int32_t>("the number of grids");
  if (grids < 0 || grids > limits.max_grids)
    cursor.bad("the number of grids is out of range", "0 to " + std::to_string(limits.max_grids),
               std::to_string(grids));
  for (int g = 0; g < grids; ++g) {
    for (const char* what : {"a grid's name", "a grid's type", "a grid's instance parent"}) cursor.text(what);
    const auto start = cursor.take<std::int64_t>("a grid's offset");
    cursor.skip(8, "a grid's offset");
    const auto end = cursor.take<std::int64_t>("a grid's offset");
    if (!offsets) {  // a stream: where the second grid begins is known only after parsing the first
      scan_grid(cursor);
      return;
    }
    if (start != std::int64_t(cursor.at()) || end < start || std::uint64_t(end) > size)
      cursor.bad("a grid's offsets are out of order",
                 "begin " + std::to_string(cursor.at()) + ", end within " + std::to_string(size),
                 std::to_string(start) + " and " + std::to_string(end));
    scan_grid(cursor);
    cursor.move_to(std::uint64_t(end));
  }
  if (cursor.at() != size)
    cursor.bad("there are bytes after the last grid", "a file of " + std::to_string(cursor.at()) + " bytes",
               std::to_string(size));
}

}  // namespace

std::string vdb_seal(std::uint64_t bytes_before, std::uint64_t hash_before) {
  std::string seal(kSealMagic);
  seal.append(reinterpret_cast<const char*>(&bytes_before), 8);
  seal.append(reinterpret_cast<const char*>(&hash_before), 8);
  return seal;
}

VdbScan scan_vdb(const std::string& path, std::string_view bytes, const VdbLimits& limits) {
  VdbScan scan{bytes, false};
  if (bytes.size() > kVdbSealBytes &&
      bytes.substr(bytes.size() - kVdbSealBytes, kSealMagic.size()) == kSealMagic) {
    scan.payload = bytes.substr(0, bytes.size() - kVdbSealBytes);
    scan.sealed = true;
    if (bytes.substr(scan.payload.size()) != vdb_seal(scan.payload.size(), hash64(scan.payload)))
      fail({.where = path,
            .what = "the checksum does not fit the content",
            .got = "damaged bytes",
            .hint = "copy or export the file again"});
  }
  Cursor cursor(path, scan.payload, limits);
  if (cursor.take<std::int64_t>("the header") != kVdbMagic)
    fail({.where = path,
          .what = "is not a VDB file",
          .expected = "the magic number of OpenVDB at the beginning"});
  const auto version = cursor.take<std::uint32_t>("the header");
  if (version < kOldestVersion || version > kNewestVersion)
    fail({.where = path,
          .what = "this version of the VDB format is not supported",
          .expected = std::to_string(kOldestVersion) + " to " + std::to_string(kNewestVersion),
          .got = std::to_string(version),
          .hint = "save the file again with a current VDB program"});
  cursor.skip(8, "the header");
  const auto offsets = cursor.take<char>("the header");
  cursor.skip(kVdbIdBytes, "the header");
  cursor.metadata();
  scan_grids(cursor, scan.payload.size(), offsets != 0, limits);
  return scan;
}

}  // namespace splinevox
