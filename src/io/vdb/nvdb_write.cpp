// SPDX-License-Identifier: Apache-2.0
#include "io/vdb/nvdb_write.hpp"

#include "core/atomic_file.hpp"
#include "splinevox/core/error.hpp"

#if SPLINEVOX_NANOVDB

#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <openvdb/openvdb.h>

#include <cstring>
#include <sstream>
#include <utility>

#include "io/vdb/openvdb_grid.hpp"

namespace splinevox {
namespace {

/// NanoVDB's buffer, cleared: whatever malloc left in padding would make equal grids unequal files.
class ClearedBuffer : public nanovdb::HostBuffer {
 public:
  ClearedBuffer() = default;
  explicit ClearedBuffer(nanovdb::HostBuffer&& buffer) : nanovdb::HostBuffer(std::move(buffer)) {}
  static ClearedBuffer create(std::uint64_t bytes, const nanovdb::HostBuffer* = nullptr) {
    ClearedBuffer buffer(nanovdb::HostBuffer::create(bytes));
    std::memset(buffer.data(), 0, bytes);
    return buffer;
  }
};

}  // namespace

bool has_nanovdb() { return true; }

FileDigest write_nvdb(const std::string& path, VdbFile file) {
  openvdb::initialize();
  std::string bytes;
  try {
    std::vector<nanovdb::GridHandle<ClearedBuffer>> handles;
    std::size_t room = 0;
    for (VdbGrid& in : file.grids) {
      const VdbGrid grid = std::exchange(in, {});  // gone when the next one is made
      // By type: the call for any grid compiles every kind there is.
      const auto open = to_openvdb(grid);
      if (grid.width != 1) open->setGridClass(openvdb::GRID_UNKNOWN);  // to NanoVDB only numbers can be a fog
      if (const auto floats = openvdb::gridPtrCast<openvdb::FloatGrid>(open))
        handles.push_back(nanovdb::openToNanoVDB<ClearedBuffer>(*floats));
      else
        handles.push_back(
            nanovdb::openToNanoVDB<ClearedBuffer>(*openvdb::gridPtrCast<openvdb::Vec3SGrid>(open)));
      // Head of a segment and of a grid are well below this.
      room += handles.back().size() + 4096 + grid.name.size();
    }
    // The writer seeks beyond the end before it writes, which a string cannot do unless the end is far
    // enough.
    std::ostringstream out(std::string(room + 4096, '\0'), std::ios::binary);
    out.exceptions(std::ios::failbit | std::ios::badbit);
    nanovdb::io::writeGrids<ClearedBuffer, std::vector>(out, handles, nanovdb::io::Codec::NONE);
    const auto size = std::size_t(out.tellp());
    bytes = std::move(out).str();
    bytes.resize(size);
  } catch (const std::exception& e) {
    fail_output({.where = path, .what = "could not be written", .got = e.what()});
  }
  return write_file(path, {bytes});
}

}  // namespace splinevox

#else

namespace splinevox {

bool has_nanovdb() { return false; }

FileDigest write_nvdb(const std::string& path, VdbFile) {
  fail_output({.where = path, .what = "cannot be written", .got = "a build without NanoVDB"});
}

}  // namespace splinevox

#endif
