#pragma once

// Who discovers whom. A participant acknowledges the liveliness messages of every other
// one that it has discovered, so what participants send grows with the square of their
// number. The services of one machine exchange nothing with those of another, so cells do
// not discover each other:
//
// clang-format off
//   port (of a domain's 250)   announced to by                   received by
//   +0                         everybody                         all but cells
//   +2                         all but cells                     cells
//   +20 ... +219, by the cell  the services of the cell          the services of the cell
// clang-format on
//
// Clients, recorders, consoles and all services without a cell take part as everybody;
// they and every cell discover each other in both directions, as before. The ports are
// multicast; DDSI (2.5, 9.6.1.1) gives a domain the ports from 7400 + 250 * domain on, of
// which unicast ones are not used here. Two cells with the same port discover each other,
// which costs their packets and nothing else. A participant with the library's own
// settings announces itself at +0, and is discovered by a cell when it answers the cell's
// announcement.

#include <string>

namespace intaglio::bus::internal {

/// The part of the library's configuration inside <Discovery>. `role`: of the process, as
/// in role_names.h.
std::string DiscoveryPorts(int domain, const std::string& role);

}  // namespace intaglio::bus::internal
