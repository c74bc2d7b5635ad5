// What byte_stream.h guarantees, for every kind of line that endpoint.h lists, with the
// system's own clock and devices: there is no other oracle of what a kernel does.

#include "services/platform/link/endpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <optional>
#include <random>

#include "tests/patience.h"
#include "tests/services/platform/link/endpoint_peers.h"

namespace intaglio::link {
namespace {

using ::testing::HasSubstr;
using namespace std::chrono_literals;
using Bytes = std::vector<std::byte>;

Bytes RandomBytes(std::size_t count) {
  std::mt19937 random(3);
  Bytes bytes(count);
  for (std::byte& b : bytes) b = std::byte(random());
  return bytes;
}

Bytes TextBytes(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

class EveryEndpoint : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    peer = MakePeer(GetParam());
    ASSERT_NE(peer, nullptr) << "endpoint_peers.cc has no peer for " << GetParam();
  }
  Result<std::unique_ptr<ByteStream>> TryOpen() {
    return OpenEndpoint(peer->device(), 115200);
  }
  /// Open and connected.
  void Open() {
    auto opened = TryOpen();
    ASSERT_TRUE(opened) << opened.error().message;
    host = std::move(*opened);
    ASSERT_TRUE(test::Eventually([&] {
      peer->Serve();
      const auto got = host->Read({});
      EXPECT_TRUE(got) << got.error().message;
      return host->connected();
    }));
  }
  /// At most `count` of what has come to the host.
  Bytes ReadHost(std::size_t count) {
    Bytes bytes(count);
    const auto got = host->Read(bytes);
    EXPECT_TRUE(got) << got.error().message;
    bytes.resize(got ? *got : 0);
    return bytes;
  }
  /// The error that a stream comes to, from its opening on, while the peer serves.
  std::optional<Error> ErrorOf(Result<std::unique_ptr<ByteStream>> opened) {
    if (!opened) return opened.error();
    std::optional<Error> error;
    Bytes buffer(10);
    (void)test::Eventually(
        [&] {
          peer->Serve();
          const auto got = (*opened)->Read(buffer);
          if (!got) error = got.error();
          return error.has_value();
        },
        4s);
    return error;
  }

  std::unique_ptr<EndpointPeer> peer;
  std::unique_ptr<ByteStream> host;
};

TEST_P(EveryEndpoint, E1BytesArriveInOrderBothWays) {
  Open();
  const Bytes sent = RandomBytes(300000);
  Bytes at_peer, at_host;
  std::size_t by_host = 0, by_peer = 0;
  const auto append = [](Bytes& all, const Bytes& more) {
    all.insert(all.end(), more.begin(), more.end());
  };
  ASSERT_TRUE(test::Eventually([&] {
    for (int i = 0; i < 50; ++i) {
      const auto taken = host->Write(std::span(sent).subspan(by_host));
      EXPECT_TRUE(taken);
      by_host += taken.value_or(0);
      by_peer += peer->Write(std::span(sent).subspan(by_peer));
      append(at_peer, peer->Read(1000));
      append(at_host, ReadHost(1000));
    }
    return at_peer.size() >= sent.size() && at_host.size() >= sent.size();
  }));
  EXPECT_EQ(at_peer, sent);
  EXPECT_EQ(at_host, sent);
}

TEST_P(EveryEndpoint, E2E3NoCallBlocksAndWriteTakesAPrefix) {
  Open();
  EXPECT_TRUE(ReadHost(100).empty());
  const Bytes sent = RandomBytes(20'000'000);
  std::size_t taken = 0, more = 1;
  for (int i = 0; i < 1000 && more > 0; ++i) {
    const auto now = host->Write(std::span(sent).subspan(taken));
    ASSERT_TRUE(now);
    taken += more = *now;
  }
  EXPECT_EQ(more, 0u) << "the peer reads nothing";
  EXPECT_GT(taken, 0u);
  ASSERT_LT(taken, sent.size());
  Bytes received;
  (void)test::Eventually([&] {
    const Bytes part = peer->Read(65536);
    received.insert(received.end(), part.begin(), part.end());
    return received.size() >= taken;
  });
  EXPECT_EQ(received, Bytes(sent.begin(), sent.begin() + static_cast<long>(taken)));
}

TEST_P(EveryEndpoint, E4ARemovedDeviceIsALostLineThatIsNamed) {
  Open();
  ASSERT_EQ(peer->Write(TextBytes("hello")), 5u);
  ASSERT_TRUE(test::Eventually([&] { return !ReadHost(10).empty(); }));
  peer->Remove();
  Bytes buffer(10);
  ASSERT_TRUE(test::Eventually([&] { return !host->Read(buffer); }, 2s));
  for (int i = 0; i < 3; ++i) {
    const auto got = host->Read(buffer);
    const auto taken = host->Write(buffer);
    ASSERT_FALSE(got);
    ASSERT_FALSE(taken);
    EXPECT_EQ(got.error().code, ErrorCode::kLinkLost);
    EXPECT_EQ(taken.error().code, ErrorCode::kLinkLost);
    EXPECT_THAT(got.error().message, HasSubstr(peer->name()));
    EXPECT_THAT(got.error().message, HasSubstr("check"));
  }
}

TEST_P(EveryEndpoint, E4E9SoItIsForAHostThatOnlyWrites) {
  Open();
  ASSERT_TRUE(host->Write(TextBytes("hello")));
  peer->Serve();
  peer->Remove();
  EXPECT_TRUE(test::Eventually([&] { return !host->Write(TextBytes("x")); }, 2s));
}

TEST_P(EveryEndpoint, E5AnAbsentDeviceIsNamedWithTheRemedy) {
  peer->Remove();
  const auto error = ErrorOf(TryOpen());
  ASSERT_TRUE(error);
  EXPECT_THAT(error->message, HasSubstr(peer->name()));
  EXPECT_THAT(error->message, HasSubstr("check"));
}

TEST_P(EveryEndpoint, E6ASecondHostIsTurnedAwayAndTheFirstGoesOn) {
  Open();
  const auto error = ErrorOf(TryOpen());
  ASSERT_TRUE(error) << "two hosts on one line";
  EXPECT_THAT(error->message, HasSubstr(peer->name()));
  EXPECT_THAT(error->message, HasSubstr("another"));
  const Bytes sent = TextBytes("still here");
  ASSERT_EQ(host->Write(sent), sent.size());
  Bytes received;
  EXPECT_TRUE(test::Eventually([&] {
    const Bytes part = peer->Read(100);
    received.insert(received.end(), part.begin(), part.end());
    return received == sent;
  }));
  EXPECT_EQ(peer->Write(sent), sent.size());
  EXPECT_TRUE(test::Eventually([&] { return ReadHost(100) == sent; }));
}

TEST_P(EveryEndpoint, E7ThePeerNoticesThatTheHostHasClosed) {
  Open();
  EXPECT_FALSE(peer->HostIsGone());
  host.reset();
  EXPECT_TRUE(test::Eventually([&] { return peer->HostIsGone(); }, 1s));
}

TEST_P(EveryEndpoint, E7ThePeerNoticesThatTheHostWasKilled) {
  std::array<int, 2> opened{};
  ASSERT_EQ(pipe(opened.data()), 0);
  const pid_t child = fork();
  if (child == 0) {
    auto stream = TryOpen();
    for (int i = 0; i < 2000 && stream && !(*stream)->connected(); ++i) {
      (void)(*stream)->Read({});
      usleep(1000);
    }
    const char open = stream && (*stream)->connected() ? 'o' : 'x';
    if (write(opened[1], &open, 1) == 1) pause();
    _exit(1);
  }
  char open = 0;
  ASSERT_EQ(read(opened[0], &open, 1), 1);
  peer->Serve();
  EXPECT_EQ(open, 'o');
  EXPECT_FALSE(peer->HostIsGone());
  kill(child, SIGKILL);
  EXPECT_TRUE(test::Eventually([&] { return peer->HostIsGone(); }, 1s));
  waitpid(child, nullptr, 0);
  close(opened[0]);
  close(opened[1]);
  Open();  // free again
}

TEST_P(EveryEndpoint, E8OpenedAgainItDeliversNothingOfTheTimeBefore) {
  Open();
  ASSERT_EQ(peer->Write(TextBytes("old")), 3u);
  host.reset();
  (void)test::Eventually([&] { return peer->HostIsGone(); }, 1s);
  (void)peer->Write(TextBytes("older"));
  Open();
  ASSERT_EQ(peer->Write(TextBytes("new")), 3u);
  Bytes received;
  ASSERT_TRUE(test::Eventually([&] { return !(received = ReadHost(100)).empty(); }));
  EXPECT_EQ(received, TextBytes("new"));
}

TEST_P(EveryEndpoint, E8ARemovedDeviceThatComesBackIsOpenedAgain) {
  Open();
  peer->Remove();
  Bytes buffer(10);
  ASSERT_TRUE(test::Eventually([&] { return !host->Read(buffer); }, 2s));
  host.reset();
  peer->ComeBack();
  Open();
  EXPECT_EQ(host->Write(TextBytes("new")), 3u);
  EXPECT_TRUE(test::Eventually([&] { return peer->Read(10) == TextBytes("new"); }));
}

std::vector<std::string> Schemes() {
  std::vector<std::string> schemes;
  for (const EndpointKind& kind : EndpointKinds()) schemes.emplace_back(kind.scheme);
  return schemes;
}
INSTANTIATE_TEST_SUITE_P(Of, EveryEndpoint, ::testing::ValuesIn(Schemes()),
                         [](const auto& kind) { return kind.param; });

TEST(CheckDevice, TakesEveryFormAndAPathAlone) {
  for (const EndpointKind& kind : EndpointKinds())
    EXPECT_TRUE(CheckDevice(std::string(kind.form))) << kind.form;
  for (const char* device :
       {"/dev/ttyUSB0", "laser", "/dev/serial/by-id/usb-FTDI:1", "tcp:127.0.0.1:1",
        "tcp:localhost:65535", "tcp:[::1]:5000", "serial:/dev/ttyUSB0"})
    EXPECT_TRUE(CheckDevice(device)) << device;
}

TEST(CheckDevice, NamesWhatIsWrongAndTheForms) {
  for (const auto& [device, why] : {std::pair("udp:10.0.0.1:5", "no known kind"),
                                    std::pair("serial:", "path"),
                                    std::pair("tcp:", "port is missing"),
                                    std::pair("tcp:10.0.0.1", "port is missing"),
                                    std::pair("tcp:10.0.0.1:0", "port 0"),
                                    std::pair("tcp:10.0.0.1:65536", "port"),
                                    std::pair("tcp:10.0.0.1:5x", "port"),
                                    std::pair("tcp:10.0.0.1:", "port"),
                                    std::pair("tcp:10.0.0.256:5", "10.0.0.256"),
                                    std::pair("tcp::5", "host"),
                                    std::pair("tcp:laser-box:5000", "getent hosts"),
                                    std::pair("tcp:::1:5", "host"),
                                    std::pair("tcp:[10.0.0.1]:5", "host"),
                                    std::pair("usb:", "hexadecimal"),
                                    std::pair("usb:9588", "hexadecimal"),
                                    std::pair("usb:9588:98990", "hexadecimal"),
                                    std::pair("usb:1234:5678", "9588:9899 (BJJCZ board)"),
                                    std::pair("usb:9588:9899@", "no place"),
                                    std::pair("usb:9588:9899@2", "no place"),
                                    std::pair("usb:9588:9899@1-a", "no place")}) {
    const auto checked = CheckDevice(device);
    ASSERT_FALSE(checked) << device;
    EXPECT_EQ(checked.error().code, ErrorCode::kInvalidValue);
    EXPECT_EQ(checked.error().value, device);
    EXPECT_THAT(checked.error().message, HasSubstr(why));
    EXPECT_THAT(checked.error().message, HasSubstr("serial:/dev/ttyUSB0"));
    EXPECT_THAT(checked.error().message, HasSubstr("tcp:192.168.7.20:5000"));
    const auto opened = OpenEndpoint(device, 115200);
    ASSERT_FALSE(opened) << device;
    EXPECT_EQ(opened.error().message, checked.error().message);
  }
}

TEST(Endpoint, OnlyASerialPortHasARate) {
  const auto peer = MakePeer("tcp");
  EXPECT_TRUE(OpenEndpoint(peer->device(), 0));
  const auto serial = MakePeer("serial");
  EXPECT_FALSE(OpenEndpoint(serial->device(), 0));
}

}  // namespace
}  // namespace intaglio::link
