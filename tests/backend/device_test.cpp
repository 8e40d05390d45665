// SPDX-License-Identifier: Apache-2.0
#include "splinevox/backend/device.hpp"

#include <doctest/doctest.h>

#include "splinevox/core/error.hpp"

using namespace splinevox;

TEST_SUITE("backend/device") {
  TEST_CASE(
      "cpu is always there, auto is cuda where it can be had, and cuda is refused with the reason where "
      "not") {
    CHECK(choose_device("cpu") == Device::cpu);
    CHECK(describe(Device::cpu) == "cpu");
    CHECK_THROWS_AS(choose_device("tpu"), Error);
    const CudaFound cuda = find_cuda();
    CHECK(choose_device("auto") == (cuda.usable ? Device::cuda : Device::cpu));
    if (cuda.usable) {
      CHECK(choose_device("cuda") == Device::cuda);
      CHECK(describe(Device::cuda) == "cuda: " + cuda.name);
      return;
    }
    CHECK_FALSE(cuda.reason.empty());
    try {
      choose_device("cuda");
      FAIL("cuda was accepted");
    } catch (const Error& error) {
      CHECK(error.fault == Fault::input);
      CHECK(error.problem.where == "--device");
      CHECK(error.problem.expected == "auto or cpu");
      CHECK_FALSE(error.problem.hint.empty());
      if (cuda.built) CHECK(error.problem.got == cuda.reason);
    }
  }
}
