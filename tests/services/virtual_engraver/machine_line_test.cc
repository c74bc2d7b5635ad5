// A plug of the machine, of either kind, and hosts that come and go.

#include "services/virtual_engraver/lines/machine_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "services/platform/link/endpoint.h"
#include "tests/patience.h"
#include "tests/test_folder.h"

namespace intaglio::virtual_engraver {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using namespace std::chrono_literals;
using Bytes = std::vector<std::byte>;

class EveryMachineLine : public ::testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    const std::string device = GetParam() ? std::string("tcp:127.0.0.1:0")
                                          : (test::FreshFolder() / "line").string();
    Open(device);
  }
  void Open(const std::string& device) {
    auto opened = OpenMachineLine(device, "test line");
    ASSERT_TRUE(opened) << opened.error().message;
    line = std::move(*opened);
    end = line->MachineEnd();
  }
  std::unique_ptr<link::ByteStream> Host() {
    return link::OpenEndpoint(line->device(), 115200).value();
  }
  /// The host's bytes come to the machine, and the machine's to the host.
  bool Talk(link::ByteStream& host) {
    const Bytes question(3, std::byte{'q'}), answer(5, std::byte{'a'});
    Bytes asked, answered;
    const bool asked_it = test::Eventually([&] {
      if (asked.empty() && host.connected()) (void)host.Write(question);
      if (!host.connected()) (void)host.Read({});
      asked = ReadFrom(*end);
      return asked == question;
    });
    return asked_it && end->Write(answer) == answer.size() &&
           test::Eventually([&] { return (answered = ReadFrom(host)) == answer; });
  }
  static Bytes ReadFrom(link::ByteStream& stream) {
    Bytes buffer(100);
    const auto got = stream.Read(buffer);
    buffer.resize(got.value_or(0));
    return buffer;
  }
  bool HostHasGone() {
    return test::Eventually([&] { return ReadFrom(*end), line->HostHasGone(); }, 1s);
  }

  std::unique_ptr<MachineLine> line;
  std::unique_ptr<link::ByteStream> end;
};

TEST_P(EveryMachineLine, CarriesBytesBothWays) {
  const auto host = Host();
  EXPECT_TRUE(Talk(*host));
  EXPECT_FALSE(line->HostHasGone());
}

TEST_P(EveryMachineLine, WithoutAHostItIsSilentAndTakesWhatIsWritten) {
  const Bytes bytes(100, std::byte{7});
  for (int i = 0; i < 1000; ++i) {
    EXPECT_TRUE(ReadFrom(*end).empty());
    ASSERT_EQ(end->Write(bytes), bytes.size());
  }
  EXPECT_FALSE(line->HostHasGone());
}

TEST_P(EveryMachineLine, NoticesOnceThatItsHostHasGoneAndTakesTheNext) {
  for (int i = 0; i < 3; ++i) {
    auto host = Host();
    ASSERT_TRUE(Talk(*host)) << i;
    ASSERT_FALSE(line->HostHasGone());
    host.reset();
    ASSERT_TRUE(HostHasGone()) << i;
    EXPECT_FALSE(line->HostHasGone());
    end = line->MachineEnd();
  }
}

TEST_P(EveryMachineLine, TakesOneHostAtATime) {
  const auto host = Host();
  ASSERT_TRUE(Talk(*host));
  auto second = link::OpenEndpoint(line->device(), 115200);
  Bytes buffer(10);
  EXPECT_TRUE(test::Eventually(
      [&] {
        ReadFrom(*end);
        return !second || !(*second)->Read(buffer);
      },
      2s));
  EXPECT_TRUE(Talk(*host)) << "the first goes on";
  EXPECT_FALSE(line->HostHasGone());
}

TEST_P(EveryMachineLine, ClosedItIsLostAndCanBeOpenedUnderTheSameName) {
  const std::string device = line->device();
  const auto host = Host();
  ASSERT_TRUE(Talk(*host));
  end.reset();
  line.reset();
  Bytes buffer(10);
  EXPECT_TRUE(test::Eventually([&] { return !host->Read(buffer); }, 2s));
  Open(device);
  EXPECT_EQ(line->device(), device);
  const auto next = Host();
  EXPECT_TRUE(Talk(*next));
}

TEST_P(EveryMachineLine, LosesTheShareOfBytesThatItIsGiven) {
  const auto host = Host();
  ASSERT_TRUE(Talk(*host));
  line->DropBytes(0.3, 5);
  std::size_t sent = 0, received = 0;
  const Bytes bytes(1000, std::byte{1});
  (void)test::Eventually([&] {
    if (sent < 20000) sent += host->Write(bytes).value_or(0);
    received += ReadFrom(*end).size();
    return sent >= 20000 && received > 13500;
  });
  // Three standard deviations of 20000 draws are 195.
  EXPECT_NEAR(static_cast<double>(received), 0.7 * static_cast<double>(sent), 500);
}

INSTANTIATE_TEST_SUITE_P(Of, EveryMachineLine, ::testing::Bool(),
                         [](const auto& tcp) { return tcp.param ? "tcp" : "pty"; });

TEST(TcpLine, ChoosesAPortAndNamesIt) {
  const auto line = OpenMachineLine("tcp:127.0.0.1:0", "test line");
  ASSERT_TRUE(line);
  EXPECT_THAT((*line)->device(), StartsWith("tcp:127.0.0.1:"));
  EXPECT_NE((*line)->device(), "tcp:127.0.0.1:0");
}

TEST(TcpLine, AnAddressThatCannotBeIsNamed) {
  const auto taken = OpenMachineLine("tcp:127.0.0.1:0", "test line");
  ASSERT_TRUE(taken);
  for (const std::string& device :
       {std::string("tcp:engraver:5000"), std::string("tcp:127.0.0.1"),
        std::string("tcp:192.0.2.1:0"), (*taken)->device()}) {
    const auto line = OpenMachineLine(device, "test line");
    ASSERT_FALSE(line) << device;
    EXPECT_THAT(line.error().message, HasSubstr(device));
  }
}

}  // namespace
}  // namespace intaglio::virtual_engraver
