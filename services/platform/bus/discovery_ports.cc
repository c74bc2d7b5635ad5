#include "services/platform/bus/discovery_ports.h"

#include <fmt/format.h>

#include <cstdint>
#include <initializer_list>

#include "services/platform/bus/role_names.h"

namespace intaglio::bus::internal {
namespace {

// The group is the library's own.
constexpr char kGroup[] = "239.255.0.1";
constexpr int kBase = 7400, kDomainGain = 250;
constexpr int kToCells = 2, kToJobClients = 4, kFirstOfCells = 20;
constexpr std::uint32_t kPortsOfCells = 200;

// FNV-1a, 32 bits: the same on every computer.
int PortOfCell(const std::string& role) {
  std::uint32_t hash = 2166136261U;
  for (const char c : role) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  return kFirstOfCells + static_cast<int>(hash % kPortsOfCells);
}

std::string Peers(int domain, std::initializer_list<int> offsets) {
  std::string peers;
  for (const int offset : offsets)
    peers += fmt::format("<Peer Address=\"{}:{}\"/>", kGroup,
                         kBase + kDomainGain * domain + offset);
  return "<Peers>" + peers + "</Peers>";
}

/// Where it receives announcements, and all else that is sent to many.
std::string Receiving(int announcements, int others) {
  return fmt::format(
      "<Ports><MulticastMetaOffset>{}</MulticastMetaOffset>"
      "<MulticastDataOffset>{}</MulticastDataOffset></Ports>",
      announcements, others);
}

/// It runs until it is ended, and others search for it.
bool IsService(const std::string& role) {
  return role.starts_with(kCellPrefix) || role == kJobServiceRole ||
         role == kStageWorkerRole || role == kRecorderRole;
}

}  // namespace

std::string DiscoveryPorts(int domain, const std::string& role, bool meets_cells) {
  if (role.starts_with(kCellPrefix))
    return Receiving(PortOfCell(role), kToCells) + Peers(domain, {0});
  if (!meets_cells)
    return Receiving(kToJobClients, kToJobClients + 1) + Peers(domain, {0});
  return Peers(domain, {kToCells, kToJobClients});
}

std::string AnnouncementInterval(const std::string& role, bool on_one_computer) {
  return fmt::format("<SPDPInterval>{}</SPDPInterval>",
                     on_one_computer && IsService(role) ? "1600ms" : "500ms");
}

}  // namespace intaglio::bus::internal
