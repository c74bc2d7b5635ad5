#include "services/platform/link/tcp_stream.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <optional>
#include <vector>

#include "tests/patience.h"

namespace intaglio::link {
namespace {

using ::testing::HasSubstr;
using namespace std::chrono_literals;

class Listening : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto made = ListenTcp({"127.0.0.1", 0});
    ASSERT_TRUE(made) << made.error().message;
    listener = *made;
    address = TcpAddressOf(listener);
    ASSERT_NE(address.port, 0);
  }
  void TearDown() override {
    if (listener >= 0) close(listener);
  }
  std::unique_ptr<ByteStream> Open() {
    return OpenTcp(address, [this] { return now; }).value();
  }
  /// The error that reading comes to without more time.
  std::optional<Error> ErrorOf(ByteStream& stream) {
    std::array<std::byte, 10> buffer;
    std::optional<Error> error;
    (void)test::Eventually(
        [&] {
          const auto got = stream.Read(buffer);
          if (!got) error = got.error();
          return error.has_value();
        },
        1s);
    return error;
  }

  int listener = -1;
  TcpAddress address;
  std::chrono::nanoseconds now = 3h;
};

TEST_F(Listening, AConnectionSendsAtOnceAndIsKeptAlive) {
  const auto stream = Open();
  const auto option = [&](int level, int name) {
    int value = -1;
    socklen_t size = sizeof value;
    getsockopt(stream->fd(), level, name, &value, &size);
    return value;
  };
  EXPECT_EQ(option(IPPROTO_TCP, TCP_NODELAY), 1);
  EXPECT_EQ(option(SOL_SOCKET, SO_KEEPALIVE), 1);
  EXPECT_EQ(option(IPPROTO_TCP, TCP_USER_TIMEOUT), kTcpSilentMs);
  // An idle connection, too, ends soon: the first probe, and as many as go unanswered.
  EXPECT_LE(option(IPPROTO_TCP, TCP_KEEPIDLE) +
                option(IPPROTO_TCP, TCP_KEEPCNT) * option(IPPROTO_TCP, TCP_KEEPINTVL),
            4);
}

TEST_F(Listening, ARefusedConnectionReportsIt) {
  close(listener);
  listener = -1;
  const auto stream = Open();
  const auto error = ErrorOf(*stream);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code, ErrorCode::kLinkLost);
  EXPECT_EQ(error->message,
            "cannot connect to " + address.text() +
                ": Connection refused; check that the device is switched on and listens "
                "on this port, the network cable, and the profile's device");
}

// As a computer that is switched off: the kernel itself would try for two minutes.
TEST_F(Listening, AConnectionThatIsNotMadeInTimeIsGivenUp) {
  ASSERT_EQ(listen(listener, 0), 0);
  std::vector<std::unique_ptr<ByteStream>> streams;
  const auto connecting = [&] {
    streams.push_back(Open());
    return !test::Eventually(
        [&] { return streams.back()->Read({}) && streams.back()->connected(); }, 200ms);
  };
  bool waits = false;
  for (int i = 0; i < 5 && !waits; ++i) waits = connecting();
  ASSERT_TRUE(waits) << "nobody accepts, and the queue of the kernel is full";
  ByteStream& stream = *streams.back();
  std::array<std::byte, 10> buffer{};
  now += std::chrono::milliseconds(kTcpSilentMs) - 1ns;
  EXPECT_EQ(stream.Read(buffer), 0u);
  EXPECT_EQ(stream.Write(buffer), 0u);
  EXPECT_FALSE(stream.connected());
  now += 1ns;
  const auto got = stream.Read(buffer);
  ASSERT_FALSE(got);
  EXPECT_EQ(got.error().code, ErrorCode::kLinkLost);
  EXPECT_THAT(got.error().message, HasSubstr(address.text()));
  EXPECT_THAT(got.error().message, HasSubstr("no answer within 2000 ms"));
}

TEST_F(Listening, ADeviceThatClosesAtOnceMayHaveAnotherHost) {
  const auto stream = Open();
  const int accepted = accept(listener, nullptr, nullptr);
  ASSERT_GE(accepted, 0);
  close(accepted);
  const auto error = ErrorOf(*stream);
  ASSERT_TRUE(error);
  EXPECT_THAT(error->message, HasSubstr("another host"));
}

TEST_F(Listening, APortThatIsTakenIsNamed) {
  const auto second = ListenTcp(address);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kIo);
  EXPECT_THAT(second.error().message, HasSubstr(address.text()));
}

// The resolver would read the host up to the zero byte, and "*" as no host.
TEST(TcpAddress, HasNoHostThatTheResolverReadsOtherwise) {
  using namespace std::string_literals;
  EXPECT_FALSE(ParseTcpAddress("0\0000:40033:40"s));
  EXPECT_FALSE(ParseTcpAddress("127.0.0.1\0:40"s));
  EXPECT_FALSE(ParseTcpAddress("[*]:4"));
  EXPECT_FALSE(ParseTcpAddress("*:4"));
}

TEST(TcpAddress, IsItsText) {
  for (const char* text : {"127.0.0.1:5000", "[::1]:80", "10.1.2.3:0"})
    EXPECT_EQ(ParseTcpAddress(text).value().text(), std::string("tcp:") + text);
  EXPECT_EQ(ParseTcpAddress("localhost:7").value().text(), "tcp:127.0.0.1:7");
}

}  // namespace
}  // namespace intaglio::link
