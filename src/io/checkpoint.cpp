// SPDX-License-Identifier: Apache-2.0
#include "io/checkpoint.hpp"

#include <cstring>
#include <limits>
#include <string_view>

#include "core/hash.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

// magic (8) | framing version (4) | format (4) | config (8) | dataset (8) | step (8) | length of kind (8) |
// length of bytes (8) | kind | bytes | XXH64 of everything before (8).
// The magic, the version after it and the checksum at the very end are the same in every version to come, so
// that a newer file is told from a damaged one.
constexpr std::string_view kMagic = "SPVXCKPT";
constexpr std::uint32_t kFraming = 1;
constexpr std::size_t kFixed = 56, kHash = 8;
constexpr std::uint64_t kAny =
    std::numeric_limits<std::uint64_t>::max();  ///< bytes: what was written is read

template <class T>
void put(std::string& out, T v) {
  out.append(reinterpret_cast<const char*>(&v), sizeof v);
}
template <class T>
T get(std::string_view bytes, std::size_t at) {
  T v;
  std::memcpy(&v, bytes.data() + at, sizeof v);
  return v;
}

/// A checkpoint by a newer program: never a reason to fall back to older state.
struct Newer : Error {
  using Error::Error;
};

Checkpoint parse(const std::string& path, std::string_view file) {
  const auto damaged = [&](std::string expected, std::string got) {
    fail({.where = path,
          .what = "is damaged or not complete",
          .expected = std::move(expected),
          .got = std::move(got)});
  };
  if (file.substr(0, kMagic.size()) != kMagic)
    fail({.where = path,
          .what = "is not a checkpoint of splinevox",
          .expected = "a file that begins with " + std::string(kMagic),
          .got = file.empty() ? "an empty file" : "other bytes"});
  if (file.size() < kMagic.size() + 4 + kHash)
    damaged("a whole header", std::to_string(file.size()) + " bytes");
  const std::string_view body = file.substr(0, file.size() - kHash);
  if (hash64(body) != get<std::uint64_t>(file, body.size()))
    damaged("a checksum that fits the content", "another one");
  const auto version = get<std::uint32_t>(file, 8);
  if (version > kFraming)
    throw Newer({.where = path,
                 .what = "was written by a newer version of splinevox",
                 .expected = "checkpoint version " + std::to_string(kFraming) + " or older",
                 .got = std::to_string(version),
                 .hint = "resume with the version that wrote it, or train into another folder"},
                Fault::input);
  if (version != kFraming || body.size() < kFixed)
    damaged("a whole header", std::to_string(file.size()) + " bytes");
  Checkpoint out;
  out.header.format = get<std::uint32_t>(file, 12);
  out.header.config = get<std::uint64_t>(file, 16);
  out.header.dataset = get<std::uint64_t>(file, 24);
  out.header.step = get<std::uint64_t>(file, 32);
  const auto kind = get<std::uint64_t>(file, 40), bytes = get<std::uint64_t>(file, 48);
  const std::uint64_t rest = body.size() - kFixed;
  if (kind > rest || bytes != rest - kind) damaged("lengths that add up to the file's", "others");
  out.header.kind = body.substr(kFixed, kind);
  out.bytes.assign(body.begin() + std::ptrdiff_t(kFixed + kind), body.end());
  return out;
}

}  // namespace

PendingCheckpoint::PendingCheckpoint(const std::string& path, const CheckpointHeader& header,
                                     std::span<const std::string_view> pieces)
    : file_(path, kFixed + header.kind.size() + total_size(pieces) + kHash), previous_(path + ".prev") {
  std::string head(kMagic);
  put(head, kFraming);
  put(head, header.format);
  put(head, header.config);
  put(head, header.dataset);
  put(head, header.step);
  put(head, std::uint64_t(header.kind.size()));
  put(head, total_size(pieces));
  head += header.kind;
  Hash64 hash;
  const auto add = [&](std::string_view piece) {
    hash.add(piece);
    file_.add(piece);
  };
  add(head);
  for (const std::string_view piece : pieces) add(piece);
  std::string tail;
  put(tail, hash.value());
  file_.add(tail);
}

FileDigest PendingCheckpoint::commit() { return file_.commit(previous_); }

FileDigest write_checkpoint(const std::string& path, const CheckpointHeader& header,
                            const std::vector<char>& bytes) {
  const std::string_view whole(bytes.data(), bytes.size());
  return PendingCheckpoint(path, header, {&whole, 1}).commit();
}

Checkpoint read_checkpoint(const std::string& path) {
  try {
    return parse(path, read_file(path, kAny));
  } catch (const Newer&) {
    throw;
  } catch (const Error& error) {
    const std::string previous = path + ".prev";
    try {
      Checkpoint out = parse(previous, read_file(previous, kAny));
      const Problem& p = error.problem;
      out.note = p.where + " " + p.what + (p.got.empty() ? "" : " (" + p.got + ")") +
                 "; the one before it, " + previous + " at step " + std::to_string(out.header.step) +
                 ", is used instead";
      return out;
    } catch (const Error&) {
    }
    throw;
  }
}

}  // namespace splinevox
