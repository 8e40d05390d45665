// SPDX-License-Identifier: Apache-2.0
#include "core/group_memory.hpp"

#include <doctest/doctest.h>
#include <sys/resource.h>

#include <cmath>

#include "core/process.hpp"
#include "support/tiny_dataset.hpp"

using namespace splinevox;
using namespace splinevox::test;

TEST_SUITE("core/group_memory") {
  TEST_CASE("version 2: the tightest of the groups that lie within each other; cache is no use") {
    const TempFolder folder;
    write_text(folder.path() / "a/memory.max", "1000000\n");
    write_text(folder.path() / "a/memory.current", "600000\n");
    write_text(folder.path() / "a/memory.stat", "anon 5\ninactive_file 100000\nfile 7\n");
    write_text(folder.path() / "a/b/memory.max", "max\n");
    write_text(folder.path() / "a/b/memory.current", "1\n");
    const GroupMemory inner = group_memory("0::/a/b\n", folder.str());
    CHECK(inner.most == 1e6);
    CHECK(inner.left == 5e5);
    CHECK(std::isinf(group_memory("0::/\n", folder.str()).most));
    write_text(folder.path() / "memory.max", "2000\n");  // a container sees its own group as the root
    write_text(folder.path() / "memory.current", "3000\n");
    CHECK(group_memory("0::/not/there\n", folder.str()).most == 2000);
    CHECK(group_memory("0::/\n", folder.str()).left == 0);
  }

  TEST_CASE("version 1: of the line that names memory alone") {
    const TempFolder folder;
    write_text(folder.path() / "memory/docker/x/memory.limit_in_bytes", "5000\n");
    write_text(folder.path() / "memory/docker/x/memory.usage_in_bytes", "1500\n");
    write_text(folder.path() / "memory/docker/x/memory.stat", "inactive_file 9\ntotal_inactive_file 500\n");
    write_text(folder.path() / "memory/memory.limit_in_bytes", "9223372036854771712\n");
    const GroupMemory memory = group_memory("12:cpu,cpuacct:/other\n7:memory:/docker/x\n", folder.str());
    CHECK(memory.most == 5000);
    CHECK(memory.left == 4000);
    CHECK(std::isinf(group_memory("3:cpu:/docker/x\n", folder.str()).most));
    CHECK(std::isinf(group_memory("", folder.str()).left));
    CHECK(std::isinf(group_memory("nonsense\n::\n", folder.str()).left));
  }

  TEST_CASE("this process's own limit counts as well") {
    rlimit before{};
    ::getrlimit(RLIMIT_AS, &before);
    const double machine = total_memory();
    CHECK(machine >= free_memory());
    const rlimit little{rlim_t(std::min(machine / 2, 3e9)), before.rlim_max};
    ::setrlimit(RLIMIT_AS, &little);
    const double total = total_memory(), left = free_memory();
    ::setrlimit(RLIMIT_AS, &before);
    CHECK(total == double(little.rlim_cur));
    CHECK(left < total);
  }
}
