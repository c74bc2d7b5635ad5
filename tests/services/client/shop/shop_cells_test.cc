// Errors of a further machine of a shop name it, once.

#include "services/client/shop/shop_cells.h"

#include <gtest/gtest.h>

namespace intaglio::client {
namespace {

Error Fault(const std::string& message) { return {ErrorCode::kFault, message, ""}; }

TEST(NamedAt, PutsTheMachineBeforeTheSentence) {
  const Error named = NamedAt("els-03-2", Fault("not ready: synchronizer"));
  EXPECT_EQ(named.message, "els-03-2: not ready: synchronizer");
  EXPECT_EQ(named.code, ErrorCode::kFault);
}

TEST(NamedAt, NamesItOnce) {
  for (const char* message : {"els-03-2: not ready", "els-03-2 has no virtual machine"}) {
    EXPECT_EQ(NamedAt("els-03-2", Fault(message)).message, message);
    EXPECT_EQ(NamedAt("els-03-2", NamedAt("els-03-2", Fault(message))).message, message);
  }
}

// els-03-20 is another machine than els-03-2.
TEST(NamedAt, DoesNotTakeALongerNameForTheMachine) {
  EXPECT_EQ(NamedAt("els-03-2", Fault("els-03-20: not ready")).message,
            "els-03-2: els-03-20: not ready");
}

}  // namespace
}  // namespace intaglio::client
