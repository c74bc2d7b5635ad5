#include "services/platform/host/peers/process_instances.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace intaglio::host {
namespace {

TEST(ProcessInstances, AreBoundedByProcessAndThoseThatEndMakeRoom) {
  ProcessInstances instances;
  const auto name = [](std::size_t i, const char* process) {
    return fmt::format("discretizer-host-a-{}-{}", i, process);
  };
  for (std::size_t i = 0; i < ProcessInstances::kMaxOfProcess; ++i)
    EXPECT_TRUE(instances.Admit(name(i, "aa")));
  EXPECT_FALSE(instances.Admit(name(9999, "aa")));
  EXPECT_TRUE(instances.Admit(name(0, "aa"))) << "it is known";
  EXPECT_TRUE(instances.Admit(name(9999, "bb"))) << "another process";
  instances.End(name(9999, "aa"));
  EXPECT_FALSE(instances.Admit(name(9999, "aa")));
  instances.End(name(3, "aa"));
  EXPECT_TRUE(instances.Admit(name(9999, "aa")));
  EXPECT_FALSE(instances.Admit(name(3, "aa")));
}

}  // namespace
}  // namespace intaglio::host
