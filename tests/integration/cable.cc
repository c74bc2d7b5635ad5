#include "tests/integration/cable.h"

#include <fcntl.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "tests/own_network.h"

namespace intaglio::testing {
namespace {

constexpr char kHere[] = "/proc/thread-self/ns/net";

[[noreturn]] void GiveUp(const std::string& what) {
  throw std::runtime_error(what + ": " + std::strerror(errno));
}

void Raise(const char* name, const char* address) {
  if (!test::RaiseInterface(name, address)) GiveUp(std::string("cannot raise ") + name);
}

int OpenTap() {
  const int tap = open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (tap < 0) GiveUp("/dev/net/tun");
  ifreq request{};
  std::strncpy(request.ifr_name, "eth0", IFNAMSIZ - 1);
  request.ifr_flags = IFF_TAP | IFF_NO_PI;
  if (ioctl(tap, TUNSETIFF, &request) != 0) {
    close(tap);
    GiveUp("TUNSETIFF");
  }
  return tap;
}

}  // namespace

TestHost::TestHost(const char* address) {
  const int home = open(kHere, O_RDONLY | O_CLOEXEC);
  if (home < 0) GiveUp(kHere);
  if (unshare(CLONE_NEWNET) != 0) {
    close(home);
    GiveUp("a network namespace of its own");
  }
  std::string fault;
  try {
    network_ = open(kHere, O_RDONLY | O_CLOEXEC);
    Raise("lo", nullptr);
    tap_ = OpenTap();
    Raise("eth0", address);
  } catch (const std::runtime_error& error) {
    fault = error.what();
  }
  const bool back = setns(home, CLONE_NEWNET) == 0;
  close(home);
  if (!back) GiveUp("the way back home");
  if (!fault.empty()) throw std::runtime_error(fault);
}

TestHost::~TestHost() {
  if (tap_ >= 0) close(tap_);
  if (network_ >= 0) close(network_);
}

TestHost::Visit::Visit(const TestHost& host) : home_(open(kHere, O_RDONLY | O_CLOEXEC)) {
  if (home_ < 0 || setns(host.network_, CLONE_NEWNET) != 0) GiveUp("a visit");
}

TestHost::Visit::~Visit() {
  [[maybe_unused]] const int back = setns(home_, CLONE_NEWNET);
  close(home_);
}

std::string WhyNoHosts() {
  try {
    const TestHost host("10.77.0.1");
    return {};
  } catch (const std::runtime_error& error) {
    return std::string("network namespaces with TAP devices need root: ") + error.what();
  }
}

Cable::Cable(const TestHost& a, const TestHost& b, std::uint32_t seed)
    : taps_{a.tap(), b.tap()}, random_(seed) {
  thread_ = std::jthread([this](const std::stop_token& stop) { Carry(stop); });
}

Cable::~Cable() = default;

void Cable::Cut(bool a_to_b, bool b_to_a) {
  cut_[0] = a_to_b;
  cut_[1] = b_to_a;
}

bool Cable::Falls(bool from_a) {
  if (cut_[from_a ? 0 : 1]) return true;
  const double loss = loss_;
  return loss > 0 && std::uniform_real_distribution<>(0, 1)(random_) < loss;
}

void Cable::Carry(const std::stop_token& stop) {
  std::array<char, 4096> frame;
  while (!stop.stop_requested()) {
    std::array<pollfd, 2> ready{{{taps_[0], POLLIN, 0}, {taps_[1], POLLIN, 0}}};
    poll(ready.data(), ready.size(), 100);
    for (std::size_t from = 0; from < 2; ++from) {
      if ((ready[from].revents & POLLIN) == 0) continue;
      for (int burst = 0; burst < 64; ++burst) {
        const ssize_t size = read(taps_[from], frame.data(), frame.size());
        if (size <= 0) break;
        if (Falls(from == 0)) {
          ++lost_;
        } else if (write(taps_[1 - from], frame.data(), static_cast<std::size_t>(size)) ==
                   size) {
          ++carried_;
        }
      }
    }
  }
}

}  // namespace intaglio::testing
