// What a device on USB has beyond other lines (endpoint_test.cc): transfers, places, and
// who may open it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "services/platform/link/endpoint.h"
#include "tests/patience.h"
#include "tests/services/platform/link/endpoint_peers.h"

namespace intaglio::link {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class UsbStreamTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::getenv("INTAGLIO_FAKE_USB");
    peer_->Serve();
  }
  std::unique_ptr<ByteStream> Open(const std::string& device) {
    auto opened = OpenEndpoint(device, 0);
    EXPECT_TRUE(opened) << opened.error().message;
    if (!opened) return nullptr;
    EXPECT_TRUE(test::Eventually([&] {
      peer_->Serve();
      return (*opened)->connected();
    }));
    return std::move(*opened);
  }
  std::string WhyNot(const std::string& device) {
    const auto opened = OpenEndpoint(device, 0);
    return opened ? "it was opened" : opened.error().message;
  }

  std::unique_ptr<EndpointPeer> peer_ = MakePeer("usb");
  fs::path folder_;
};

TEST_F(UsbStreamTest, EachWriteIsATransfer) {
  std::ofstream(folder_ / "1-2.3.sent").flush();
  const auto host = Open(peer_->device());
  ASSERT_TRUE(host);
  std::size_t sent = 0;
  for (const std::size_t size : {12, 3072, 12, 3072, 3072, 12}) {
    const std::vector<std::byte> bytes(size, std::byte{0x5A});
    ASSERT_TRUE(test::Eventually([&] { return host->Write(bytes).value_or(0) == size; }));
    sent += size;
  }
  std::size_t came = 0;
  ASSERT_TRUE(
      test::Eventually([&] { return (came += peer_->Read(65536).size()) >= sent; }));
  std::ifstream in(folder_ / "1-2.3.sent");
  const std::vector<int> sizes{std::istream_iterator<int>(in), {}};
  EXPECT_THAT(sizes, ::testing::ElementsAre(12, 3072, 12, 3072, 3072, 12));
}

TEST_F(UsbStreamTest, OneThatThisUserMayNotOpenIsNamedWithTheRule) {
  std::ofstream(folder_ / "1-2.3.denied").flush();
  EXPECT_THAT(WhyNot(peer_->device()), HasSubstr("70-intaglio-usb.rules"));
  EXPECT_THAT(WhyNot(peer_->device()), HasSubstr("9588:9899 at 1-2.3"));
  EXPECT_TRUE(fs::exists(INTAGLIO_SOURCE_DIR "/deploy/udev/70-intaglio-usb.rules"));
}

TEST_F(UsbStreamTest, APlaceChoosesAmongSeveral) {
  EXPECT_TRUE(Open("usb:9588:9899@1-2.3"));
  EXPECT_THAT(WhyNot("usb:9588:9899@1-2"), HasSubstr("9588:9899 at 1-2 "));
  EXPECT_THAT(WhyNot("usb:9588:9899@1-2"), HasSubstr("lsusb"));
}

// Another that nobody serves any more is passed over, too.
TEST_F(UsbStreamTest, WithoutAPlaceEachOpeningComesToTheNext) {
  const auto other = folder_ / "1-1";
  ASSERT_EQ(symlink("1-2.3", other.c_str()), 0);
  std::ofstream(folder_ / "1-1.sent").flush();
  std::ofstream(folder_ / "1-2.3.sent").flush();
  const std::vector<std::byte> bytes(12);
  for (int i = 0; i < 4; ++i) {
    const auto host = Open(peer_->device());
    ASSERT_TRUE(host);
    ASSERT_TRUE(host->Write(bytes));
    ASSERT_TRUE(test::Eventually([&] { return !peer_->Read(12).empty(); }));
  }
  for (const char* place : {"1-1.sent", "1-2.3.sent"}) {
    std::ifstream in(folder_ / place);
    const std::vector<int> sizes{std::istream_iterator<int>(in), {}};
    EXPECT_THAT(sizes, ::testing::ElementsAre(12, 12)) << place;
  }
  fs::remove(other);
}

}  // namespace
}  // namespace intaglio::link
