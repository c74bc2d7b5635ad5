#include "services/console/webhooks/signed_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace intaglio::console {
namespace {

using ::testing::ElementsAre;

// printf '1764194400.{"event":"ended"}' | openssl dgst -sha256 -hmac 'correct horse
// battery'
constexpr char kSignature[] =
    "9d857b7ff1af02439a2fa91371a4eec3abb1bcb21e4d58ec65457113c4f8a347";

TEST(SignedRequest, SignsTheTimeOfTheAttemptAndTheBody) {
  const Delivery delivery{"0123456789abcdef-7", "ended",
                          std::make_shared<const std::string>(R"({"event":"ended"})")};
  const std::chrono::system_clock::time_point now{
      std::chrono::milliseconds(1764194400999)};
  EXPECT_THAT(HeadersOf(delivery, "correct horse battery", 3, now),
              ElementsAre("Content-Type: application/json", "Intaglio-Event: ended",
                          "Intaglio-Delivery: 0123456789abcdef-7", "Intaglio-Dropped: 3",
                          "Intaglio-Timestamp: 1764194400",
                          std::string("Intaglio-Signature: v1=") + kSignature));
}

}  // namespace
}  // namespace intaglio::console
