#include "services/platform/host/peers/role_refusal.h"

#include <gtest/gtest.h>

namespace intaglio::host {
namespace {

TEST(RoleRefusal, NamesTheRoleWhatItMayNotDoAndWhoMay) {
  EXPECT_EQ(
      RoleRefusal("observer", "submit jobs", "operator or a submitter", "no writer"),
      "the role observer may not submit jobs: use the identity of an operator or a "
      "submitter (no writer)");
  EXPECT_EQ(RoleRefusal("", "move", "operator", "no writer"),
            "this identity may not move: use the identity of an operator (no writer)");
}

}  // namespace
}  // namespace intaglio::host
