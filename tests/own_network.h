#pragma once

// A network of its own for a test that starts services: loopback, up, and nothing else.
// In one domain of DDS on one loopback the participants of all tests that run at a time
// discover each other and acknowledge each other's announcements, and what they send
// grows with the square of their number: beside four shops a computer of two processors
// received 9000 datagrams a second and did little else.

#include <arpa/inet.h>
#include <fcntl.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

namespace intaglio::test {

/// Raises an interface of this process's network, with an IPv4 address of a /24 or, for
/// nullptr, the one that it has. Needs CAP_NET_ADMIN. False with errno.
inline bool RaiseInterface(const char* name, const char* address) {
  const int control = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq request{};
  std::strncpy(request.ifr_name, name, IFNAMSIZ - 1);
  auto* internet = reinterpret_cast<sockaddr_in*>(&request.ifr_addr);
  internet->sin_family = AF_INET;
  bool good = control >= 0;
  if (address != nullptr) {
    inet_pton(AF_INET, address, &internet->sin_addr);
    good = good && ioctl(control, SIOCSIFADDR, &request) == 0;
    inet_pton(AF_INET, "255.255.255.0", &internet->sin_addr);
    good = good && ioctl(control, SIOCSIFNETMASK, &request) == 0;
  }
  request.ifr_flags = IFF_UP | IFF_RUNNING | IFF_MULTICAST;
  good = good && ioctl(control, SIOCSIFFLAGS, &request) == 0;
  if (control >= 0) close(control);
  return good;
}

/// Takes this process, and the children that it will have, out of the network that it is
/// in; false where the system does not permit that: then it stays there. Before any
/// thread is started. A child that calls it stays in the network of its parent.
inline bool EnterOwnNetwork() {
  constexpr char kEntered[] = "INTAGLIO_TEST_NETWORK";
  if (std::getenv(kEntered) != nullptr) return true;
  const int home = open("/proc/self/ns/net", O_RDONLY | O_CLOEXEC);
  bool is_alone = home >= 0 && unshare(CLONE_NEWNET) == 0;
  if (is_alone && !RaiseInterface("lo", nullptr)) {
    setns(home, CLONE_NEWNET);
    is_alone = false;
  }
  if (home >= 0) close(home);
  if (is_alone) setenv(kEntered, "1", 0);
  return is_alone;
}

/// In every program that includes this.
inline const bool kHasOwnNetwork = EnterOwnNetwork();

}  // namespace intaglio::test
