// What an eavesdropper on the wire sees, and what becomes of an identity that expires
// while its process runs.

#include <arpa/inet.h>
#include <linux/if_packet.h>
#include <net/ethernet.h>
#include <net/if.h>
#include <sys/socket.h>

#include <atomic>
#include <string_view>
#include <thread>

#include "tests/integration/secured_strangers.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Eventually;
using testing::kArrival;
using testing::Now;
using testing::Running;
using testing::Security;
using testing::TwoCells;

/// Counts packets on loopback that have a text in them. Without the right to listen
/// (CAP_NET_RAW) it is not listening.
class Listener {
 public:
  explicit Listener(std::string text) : text_(std::move(text)) {
    socket_ = socket(AF_PACKET, SOCK_DGRAM, htons(ETH_P_ALL));
    sockaddr_ll address = {};
    address.sll_family = AF_PACKET;
    address.sll_protocol = htons(ETH_P_ALL);
    address.sll_ifindex = static_cast<int>(if_nametoindex("lo"));
    if (socket_ < 0 ||
        bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
      return;
    }
    const int megabytes = 16 << 20;
    setsockopt(socket_, SOL_SOCKET, SO_RCVBUFFORCE, &megabytes, sizeof megabytes);
    const timeval patience{0, 50'000};
    setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    thread_ = std::jthread([this](const std::stop_token& stop) { Listen(stop); });
  }
  ~Listener() {
    thread_ = {};
    if (socket_ >= 0) close(socket_);
  }
  bool listening() const { return thread_.joinable(); }
  int found() const { return found_; }
  int packets() const { return packets_; }

 private:
  void Listen(const std::stop_token& stop) {
    std::string packet(65536, '\0');
    while (!stop.stop_requested()) {
      const ssize_t size = recv(socket_, packet.data(), packet.size(), 0);
      if (size <= 0) continue;
      ++packets_;
      const std::string_view seen(packet.data(), static_cast<std::size_t>(size));
      if (seen.find(text_) != std::string_view::npos) ++found_;
    }
  }
  std::string text_;
  int socket_ = -1;
  std::atomic<int> found_{0}, packets_{0};
  std::jthread thread_;
};

class SecurityOnTheWire : public Security {
 protected:
  /// An operator's commands until the listener has them; how many packets showed them.
  int Shown(const fs::path& ear, const fs::path& mouth, const char* name) {
    const std::string secret = "whose-command-this-is-" + std::to_string(getpid());
    Listener listener(secret);
    if (!listener.listening()) return -1;
    const auto source =
        Stranger(std::string("ear-") + name, ear,
                 ear.empty() ? std::vector<std::string>{"read", "JobCommand", ""}
                             : std::vector<std::string>{"hear", "JobCommand", ""});
    const auto sends = Stranger(name, mouth, {"write", "JobCommand", "", secret});
    const std::string sign = ear.empty() ? "read 10\n" : secret;
    EXPECT_TRUE(Eventually(
        [&] { return source->Output().find(sign) != std::string::npos; }, kArrival))
        << source->Output() << sends->Output();
    std::cout << "  " << name << ": " << listener.packets() << " packets, "
              << listener.found() << " of them show what it says\n";
    return listener.found();
  }
};

TEST_F(SecurityOnTheWire, NothingCanBeReadOffIt) {
  const int shown = Shown({}, {}, "plain");
  if (shown < 0) GTEST_SKIP() << "this user may not listen to packets: run as root";
  EXPECT_GT(shown, 0);  // so the listener can receive
  EXPECT_EQ(Shown(Of("job-service"), Of("operator"), "secured"), 0);
}

TEST_F(SecurityOnTheWire, AnIdentityThatEndsIsNotReceivedAnyMore) {
  constexpr auto kLife = 8s;
  constexpr auto kSilence = 3s;
  fs::copy(folder_ / "shop", folder_ / "brief", fs::copy_options::recursive);
  const auto end = Now() + kLife;
  ASSERT_TRUE(security::RenewIdentities(folder_ / "brief", {},
                                        {end - std::chrono::days(365), 365}));
  const auto ear = Stranger("listener", Of("job-service"), {"hear", "JobCommand", ""});
  const auto brief = Stranger("brief", folder_ / "brief" / "operator",
                              {"write", "JobCommand", "", "brief"});
  int received = 0;
  auto last = std::chrono::steady_clock::now();
  const auto listen = [&] {
    const int count = CountOf("brief", *ear);
    if (count > received) last = std::chrono::steady_clock::now();
    received = count;
    return received > 0;
  };
  if (!Eventually(listen, kArrival)) {
    GTEST_SKIP() << "this host took longer than the identity lives, run it alone: "
                 << brief->Output();
  }
  const auto silent = [&] {
    listen();
    return Now() > end && std::chrono::steady_clock::now() - last > kSilence;
  };
  EXPECT_TRUE(Eventually(silent, kArrival));
  std::cout << "  heard " << received << " times, then silence for " << kSilence.count()
            << " s; it writes on: " << brief->running() << "\n";
}

}  // namespace
}  // namespace intaglio
