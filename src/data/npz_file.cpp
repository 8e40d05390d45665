// SPDX-License-Identifier: Apache-2.0
#include "data/npz_file.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>

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

/// An entry of the directory at the file's end.
struct Entry {
  std::string name;
  std::uint32_t method, checksum, packed, size, at;
};

std::vector<Entry> read_directory(Bytes bytes, const std::string& where) {
  constexpr std::uint32_t kEnd = 0x06054b50, kEntry = 0x02014b50;
  constexpr std::size_t kEndBytes = 22, kEntryBytes = 46, kLongestComment = 65535;
  std::optional<std::size_t> end;
  for (std::size_t back = kEndBytes; !end && back <= std::min(bytes.size(), kEndBytes + kLongestComment);
       ++back)
    if (number_at(bytes, bytes.size() - back, 4, where) == kEnd) end = bytes.size() - back;
  if (!end) fail_npz(where, "no directory at its end");
  std::vector<Entry> out;
  std::size_t at = number_at(bytes, *end + 16, 4, where);
  for (std::uint32_t left = number_at(bytes, *end + 10, 2, where); left > 0; --left) {
    if (number_at(bytes, at, 4, where) != kEntry) fail_npz(where, "its directory is torn");
    const std::size_t name = number_at(bytes, at + 28, 2, where), more = number_at(bytes, at + 30, 2, where),
                      comment = number_at(bytes, at + 32, 2, where);
    if (bytes.size() - at < kEntryBytes + name) fail_npz(where, "it ends too early");
    out.push_back({std::string(reinterpret_cast<const char*>(bytes.data()) + at + kEntryBytes, name),
                   number_at(bytes, at + 10, 2, where), number_at(bytes, at + 16, 4, where),
                   number_at(bytes, at + 20, 4, where), number_at(bytes, at + 24, 4, where),
                   number_at(bytes, at + 42, 4, where)});
    at += kEntryBytes + name + more + comment;
  }
  return out;
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

/// What numpy calls the entry's array.
std::string array_name(const Entry& entry) { return entry.name.substr(0, entry.name.rfind(".npy")); }

std::vector<std::uint8_t> unpack(Bytes bytes, const Entry& entry, const std::string& where) {
  constexpr std::uint32_t kLocal = 0x04034b50, kStored = 0, kDeflated = 8;
  if (number_at(bytes, entry.at, 4, where) != kLocal)
    fail_npz(where, "an entry is not where the directory says");
  const std::size_t from = std::size_t(entry.at) + 30 + number_at(bytes, entry.at + 26, 2, where) +
                           number_at(bytes, entry.at + 28, 2, where);
  if (from > bytes.size() || bytes.size() - from < entry.packed || entry.size > kLargestNpz)
    fail_npz(where, "an entry is longer than the file");
  const Bytes packed = bytes.subspan(from, entry.packed);
  if (entry.method != kStored && entry.method != kDeflated)
    fail_npz(where, "it is packed in a way that numpy does not use");
  std::vector<std::uint8_t> out = entry.method == kStored
                                      ? std::vector<std::uint8_t>(packed.begin(), packed.end())
                                      : inflated(packed, entry.size, where);
  if (crc32_z(0, out.data(), out.size()) != entry.checksum) fail_npz(where, "a checksum is wrong");
  return out;
}

}  // namespace

std::map<std::string, NpyArray> read_npz(const std::filesystem::path& path, const std::string& where,
                                         const std::vector<std::string>& names) {
  const std::vector<std::uint8_t> bytes = read_bytes(path, where, kLargestNpz);
  const std::vector<Entry> entries = read_directory(bytes, where);
  std::map<std::string, NpyArray> out;
  for (const std::string& name : names) {
    const auto entry =
        std::find_if(entries.begin(), entries.end(), [&](const Entry& e) { return e.name == name + ".npy"; });
    if (entry == entries.end()) {
      std::string all, wanted;
      for (const Entry& e : entries) all += (all.empty() ? "" : ", ") + printable(array_name(e));
      for (const std::string& each : names) wanted += (wanted.empty() ? "" : ", ") + each;
      fail({where, "there is no array '" + name + "' in it", wanted, all, ""});
    }
    out[name] = parse_npy(unpack(bytes, *entry, where), where + ", array '" + name + "'");
  }
  return out;
}

std::map<std::string, NpyArray> read_npz(const std::filesystem::path& path, const std::string& where) {
  const std::vector<std::uint8_t> bytes = read_bytes(path, where, kLargestNpz);
  std::map<std::string, NpyArray> out;
  for (const Entry& e : read_directory(bytes, where))
    out[array_name(e)] = parse_npy(unpack(bytes, e, where), where + ", array " + in_quotes(e.name), true);
  return out;
}

NpyArray read_npz_array(const std::filesystem::path& path, const std::string& where,
                        const std::string& name) {
  const std::vector<std::uint8_t> bytes = read_bytes(path, where, kLargestNpz);
  const std::vector<Entry> entries = read_directory(bytes, where);
  std::string all;
  for (const Entry& e : entries) {
    if (entries.size() == 1 || e.name == name + ".npy")
      return parse_npy(unpack(bytes, e, where), where, true);
    all += (all.empty() ? "" : ", ") + printable(array_name(e));
  }
  fail({where, "it is not clear which array is meant", "one array, or one named '" + name + "'",
        all.empty() ? "none" : all, ""});
}

}  // namespace splinevox::data
