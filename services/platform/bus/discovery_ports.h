#pragma once

// Who discovers whom. A participant acknowledges the liveliness messages of every other
// one that it has discovered, so what participants send grows with the square of their
// number. The services of one machine exchange nothing with those of another, so cells do
// not discover each other:
//
// clang-format off
//   port (of a domain's 250)   announced to by                received by
//   +0                         everybody                      all but cells and job clients
//   +2                         all but cells and job clients  cells
//   +4                         all but cells                  job clients
//   +20 ... +219, by the cell  the services of the cell       the services of the cell
// clang-format on
//
// A job client (BusOptions::meets_cells false) exchanges nothing with cells either: what
// it asks, the job service answers. It is discovered by all but cells, so its start costs
// the same in a shop of one machine and of thirty. Recorders, consoles, other clients and
// all services without a cell take part as everybody; they and every cell discover each
// other in both directions. The ports are multicast, and job clients and cells have the
// one behind their own for what is not discovery; DDSI (2.5, 9.6.1.1) gives a domain the
// ports from 7400 + 250 * domain on, of which unicast ones are not used here. Two cells
// with the same port discover each other, which costs their packets and nothing else. A
// participant with the library's own settings announces itself at +0, and is discovered
// by a cell or a job client when it answers its announcement.

#include <string>

namespace intaglio::bus::internal {

/// The part of the library's configuration inside <Discovery>. `role`: of the process, as
/// in role_names.h. `meets_cells`: as in BusOptions.
std::string DiscoveryPorts(int domain, const std::string& role, bool meets_cells = true);

/// The same: how often a participant repeats its announcement, which wakes everybody at
/// its ports. 0.5 s: a network heals within a second of a cut, and a client whose first
/// announcement was lost is answered in the time for which it searches. Between the
/// services of one computer there is no network to be cut: 1.6 s, the longest that the
/// library allows for a lease of 2 s, since with thirty machines their announcements made
/// one sample in a hundred late (docs/scale.md).
std::string AnnouncementInterval(const std::string& role, bool on_one_computer);

}  // namespace intaglio::bus::internal
