// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <zlib.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace splinevox::test {

/// A file as numpy.save writes it. @param kind  such as "<f4". @param shape  such as "(2, 3)"
inline std::string numpy(const std::string& kind, const std::string& shape, const std::string& values) {
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", kind, shape);
  header.resize((header.size() + 10) / 64 * 64 + 54, ' ');
  std::string out("\x93NUMPY\x01\x00", 8);
  out += char(header.size() & 255);
  out += char(header.size() >> 8);
  return out + header + values;
}

template <class T>
inline std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// A container as numpy.savez writes it, or savez_compressed.
inline std::string npz(const std::vector<std::pair<std::string, std::string>>& arrays, bool packed) {
  std::string out, directory;
  const auto put = [](std::string& to, std::uint32_t value, int wide) {
    for (int i = 0; i < wide; ++i) to += char(value >> (8 * i) & 255);
  };
  for (const auto& [name, bytes] : arrays) {
    std::string body = bytes;
    if (packed) {
      z_stream stream{};
      deflateInit2(&stream, 6, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
      body.resize(deflateBound(&stream, uLong(bytes.size())));
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
      stream.avail_in = uInt(bytes.size());
      stream.next_out = reinterpret_cast<Bytef*>(body.data());
      stream.avail_out = uInt(body.size());
      deflate(&stream, Z_FINISH);
      body.resize(stream.total_out);
      deflateEnd(&stream);
    }
    const auto at = std::uint32_t(out.size());
    std::string common;
    put(common, packed ? 8 : 0, 4);  // method, time
    put(common, 0, 2);               // date
    put(common, std::uint32_t(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size())), 4);
    put(common, std::uint32_t(body.size()), 4);
    put(common, std::uint32_t(bytes.size()), 4);
    put(common, std::uint32_t(name.size()), 4);  // and no more fields
    put(out, 0x04034b50, 4);
    put(out, 20, 4);  // version, flags
    out += common + name + body;
    put(directory, 0x02014b50, 4);
    put(directory, 20 << 16 | 20, 4);
    put(directory, 0, 2);
    directory += common;
    put(directory, 0, 4);
    put(directory, 0, 4);
    put(directory, 0, 2);
    put(directory, at, 4);
    directory += name;
  }
  const auto start = std::uint32_t(out.size());
  out += directory;
  put(out, 0x06054b50, 4);
  put(out, 0, 4);
  put(out, std::uint32_t(arrays.size() << 16 | arrays.size()), 4);
  put(out, std::uint32_t(directory.size()), 4);
  put(out, start, 4);
  put(out, 0, 2);
  return out;
}

}  // namespace splinevox::test
