#pragma once

// A network of its own for a test that starts services: loopback, up, and nothing else.
// In one domain of DDS on one loopback the participants of all tests that run at a time
// discover each other and acknowledge each other's announcements, and what they send
// grows with the square of their number: beside four shops a computer of two processors
// received 9000 datagrams a second and did little else.

#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

namespace intaglio::test {

/// Takes this process, and the children that it will have, out of the network that it is
/// in; false where the system does not permit that: then it stays there. Before any
/// thread is started. A child that calls it stays in the network of its parent.
inline bool EnterOwnNetwork() {
  constexpr char kEntered[] = "INTAGLIO_TEST_NETWORK";
  if (std::getenv(kEntered) != nullptr) return true;
  if (unshare(CLONE_NEWNET) != 0) return false;
  const int socket_fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq request{};
  std::strncpy(request.ifr_name, "lo", IFNAMSIZ - 1);
  bool is_up = ioctl(socket_fd, SIOCGIFFLAGS, &request) == 0;
  request.ifr_flags |= IFF_UP;
  is_up = is_up && ioctl(socket_fd, SIOCSIFFLAGS, &request) == 0;
  close(socket_fd);
  return is_up && setenv(kEntered, "1", 0) == 0;
}

/// In every program that includes this.
inline const bool kHasOwnNetwork = EnterOwnNetwork();

}  // namespace intaglio::test
