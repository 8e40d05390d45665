// SPDX-License-Identifier: Apache-2.0
#include "data/npz_file.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "data/file_bytes.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

constexpr std::uintmax_t kLargestNpz = std::uintmax_t(2) << 30;  ///< bytes, packed or not
/// Bytes that deflate can make of one: at best two bits, a length and a distance, repeat 258 bytes.
constexpr std::uintmax_t kMostInflation = 1032;

using Bytes = std::span<const std::uint8_t>;

[[noreturn]] void fail_npz(const std::string& where, const std::string& got) {
  fail({where, "this .npz file is damaged", "a file that numpy.savez wrote", got, "copy the file again"});
}

std::uint32_t number_at(Bytes bytes, std::size_t at, int wide, const std::string& where) {
  if (at > bytes.size() || bytes.size() - at < std::size_t(wide)) fail_npz(where, "it ends too early");
  std::uint32_t value = 0;
  for (int i = 0; i < wide; ++i) value |= std::uint32_t(bytes[at + std::size_t(i)]) << (8 * i);
  return value;
}

std::vector<std::uint8_t> inflated(Bytes packed, std::uint32_t size, const std::string& where) {
  if (size > kMostInflation * packed.size()) fail_npz(where, "an entry is said to be larger than it can be");
  std::vector<std::uint8_t> out(size);
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) fail_npz(where, "it cannot be unpacked");
  stream.next_in = const_cast<std::uint8_t*>(packed.data());  // only read
  stream.avail_in = uInt(packed.size());
  stream.next_out = out.data();
  stream.avail_out = uInt(out.size());
  const bool whole = inflate(&stream, Z_FINISH) == Z_STREAM_END && stream.avail_out == 0;
  inflateEnd(&stream);
  if (!whole) fail_npz(where, "it cannot be unpacked");
  return out;
}

constexpr std::string_view kSuffix = ".npy";  ///< of an entry that is an array

std::string listed(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + printable(name);
  return all;
}

}  // namespace

NpzFile::NpzFile(const std::filesystem::path& path, std::string where)
    : where_(std::move(where)), bytes_(read_bytes(path, where_, kLargestNpz)) {
  constexpr std::uint32_t kEnd = 0x06054b50, kEntry = 0x02014b50;
  constexpr std::size_t kEndBytes = 22, kEntryBytes = 46, kLongestComment = 65535;
  const auto number = [&](std::size_t at, int wide) { return number_at(bytes_, at, wide, where_); };
  std::optional<std::size_t> end;
  for (std::size_t back = kEndBytes; !end && back <= std::min(bytes_.size(), kEndBytes + kLongestComment);
       ++back)
    if (number(bytes_.size() - back, 4) == kEnd) end = bytes_.size() - back;
  if (!end) fail_npz(where_, "no directory at its end");
  std::size_t at = number(*end + 16, 4);
  for (std::uint32_t left = number(*end + 10, 2); left > 0; --left) {
    if (number(at, 4) != kEntry) fail_npz(where_, "its directory is torn");
    const std::size_t name = number(at + 28, 2), more = number(at + 30, 2), comment = number(at + 32, 2);
    if (bytes_.size() - at < kEntryBytes + name) fail_npz(where_, "it ends too early");
    entries_.push_back({std::string(reinterpret_cast<const char*>(bytes_.data()) + at + kEntryBytes, name),
                        number(at + 10, 2), number(at + 16, 4), number(at + 20, 4), number(at + 24, 4),
                        number(at + 42, 4)});
    at += kEntryBytes + name + more + comment;
  }
}

std::vector<std::string> NpzFile::names() const {
  std::vector<std::string> out;
  for (const Entry& e : entries_) {
    const std::string_view name = e.name;
    out.emplace_back(name.substr(0, name.size() - (name.ends_with(kSuffix) ? kSuffix.size() : 0)));
  }
  return out;
}

NpyArray NpzFile::array(const std::string& name, bool any) const {
  const auto entry = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) {
    return e.name == name || e.name == name + std::string(kSuffix);
  });
  return parse_npy(unpack(*entry), where_ + ", array " + in_quotes(name), any);
}

std::vector<std::uint8_t> NpzFile::unpack(const Entry& entry) const {
  constexpr std::uint32_t kLocal = 0x04034b50, kStored = 0, kDeflated = 8;
  if (number_at(bytes_, entry.at, 4, where_) != kLocal)
    fail_npz(where_, "an entry is not where the directory says");
  const std::size_t from = std::size_t(entry.at) + 30 + number_at(bytes_, entry.at + 26, 2, where_) +
                           number_at(bytes_, entry.at + 28, 2, where_);
  if (from > bytes_.size() || bytes_.size() - from < entry.packed || entry.size > kLargestNpz)
    fail_npz(where_, "an entry is longer than the file");
  const Bytes packed = Bytes(bytes_).subspan(from, entry.packed);
  if (entry.method != kStored && entry.method != kDeflated)
    fail_npz(where_, "it is packed in a way that numpy does not use");
  std::vector<std::uint8_t> out = entry.method == kStored
                                      ? std::vector<std::uint8_t>(packed.begin(), packed.end())
                                      : inflated(packed, entry.size, where_);
  if (crc32_z(0, out.data(), out.size()) != entry.checksum) fail_npz(where_, "a checksum is wrong");
  return out;
}

std::map<std::string, NpyArray> read_npz(const std::filesystem::path& path, const std::string& where,
                                         const std::vector<std::string>& names) {
  const NpzFile file(path, where);
  const std::vector<std::string> all = file.names();
  std::map<std::string, NpyArray> out;
  for (const std::string& name : names) {
    if (std::find(all.begin(), all.end(), name) == all.end())
      fail({where, "there is no array '" + name + "' in it", listed(names), listed(all), ""});
    out[name] = file.array(name, false);
  }
  return out;
}

NpyArray read_npz_array(const std::filesystem::path& path, const std::string& where,
                        const std::string& name) {
  const NpzFile file(path, where);
  const std::vector<std::string> all = file.names();
  const bool there = std::find(all.begin(), all.end(), name) != all.end();
  if (!there && all.size() != 1)
    fail({where, "it is not clear which array is meant", "one array, or one named '" + name + "'",
          all.empty() ? "none" : listed(all), ""});
  return file.array(there ? name : all[0], true);
}

}  // namespace splinevox::data
