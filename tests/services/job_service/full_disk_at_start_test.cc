// The real process on a disk that is full before it starts.

#include <gmock/gmock.h>

#include <fstream>

#include "tests/engrave/io/small_disk.h"
#include "tests/services/job/test_job.h"
#include "tests/services/job_service/fake_shop.h"
#include "tests/test_folder.h"

namespace intaglio::job_service {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

void Fill(const fs::path& file) {
  std::ofstream out(file, std::ios::binary | std::ios::app);
  const std::string block(4096, 'x');
  while (out.write(block.data(), static_cast<std::streamsize>(block.size())).flush()) {
  }
}

class FullDiskAtStart : public testing::Test {
 protected:
  void SetUp() override {
    if (!io::MountSmallDisk(folder_, 4 << 20)) GTEST_SKIP() << "it takes root";
  }
  bool Waits() {
    return shop_.Until(
        [&] { return shop_.JobServiceHealth().state == intaglio_HEALTH_FAULT; });
  }
  bool Serves() {
    if (!shop_.Until(
            [&] { return shop_.JobServiceHealth().state == intaglio_HEALTH_READY; })) {
      return false;
    }
    shop_.Submit("one", GoodJob());
    return shop_.Until([&] { return !shop_.Status("one").uid.empty(); });
  }

  fs::path folder_ = test::FreshFolder();
  FakeShop shop_{test::PrivateBusOptions()};
};

TEST_F(FullDiskAtStart, OfAShopThatIsNew) {
  Fill(folder_ / "full");
  ServiceProcess service(folder_, test::PrivateTag());
  ASSERT_TRUE(Waits());
  EXPECT_THAT(shop_.JobServiceHealth().message, HasSubstr("jobs.db"));
  EXPECT_THAT(shop_.JobServiceHealth().message, HasSubstr("free space"));
  int exit_code = 0;
  EXPECT_FALSE(service.Exited(exit_code)) << exit_code;
  fs::remove(folder_ / "full");
  EXPECT_TRUE(Serves()) << shop_.JobServiceHealth().message;
  EXPECT_EQ(service.Stop(), 0);
}

TEST_F(FullDiskAtStart, OfAShopThatHasAQueue) {
  {
    ServiceProcess service(folder_, test::PrivateTag());
    ASSERT_TRUE(Serves());
    EXPECT_EQ(service.Stop(), 0);
  }
  Fill(folder_ / "full");
  ServiceProcess service(folder_, test::PrivateTag());
  ASSERT_TRUE(Waits());
  EXPECT_THAT(shop_.JobServiceHealth().message, HasSubstr("jobs.db"));
  fs::remove(folder_ / "full");
  ASSERT_TRUE(shop_.Until(
      [&] { return shop_.JobServiceHealth().state == intaglio_HEALTH_READY; }));
  EXPECT_EQ(service.Stop(), 0);
}

// A client that comes while there is no queue sees what was published last.
TEST_F(FullDiskAtStart, TheJobsOfAQueueThatIsGivenUpStayOnTheBus) {
  ServiceProcess service(folder_, test::PrivateTag());
  ASSERT_TRUE(Serves());
  Fill(folder_ / "full");
  shop_.Submit("two", GoodJob());
  ASSERT_TRUE(Waits());
  FakeShop late(test::PrivateBusOptions());
  EXPECT_TRUE(late.Until([&] { return !late.Status("one").uid.empty(); }));
  EXPECT_TRUE(late.Status("two").uid.empty());
  fs::remove(folder_ / "full");
  ASSERT_TRUE(shop_.Until(
      [&] { return shop_.JobServiceHealth().state == intaglio_HEALTH_READY; }));
  EXPECT_TRUE(late.Until([&] { return !late.Status("two").uid.empty(); }))
      << "its client still asks for it";
  EXPECT_EQ(service.Stop(), 0);
}

TEST_F(FullDiskAtStart, AServiceThatWaitsEndsWhenItIsAsked) {
  Fill(folder_ / "full");
  ServiceProcess service(folder_, test::PrivateTag());
  ASSERT_TRUE(Waits());
  EXPECT_EQ(service.Stop(), 0);
}

}  // namespace
}  // namespace intaglio::job_service
