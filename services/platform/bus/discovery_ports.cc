#include "services/platform/bus/discovery_ports.h"

#include <fmt/format.h>

#include <cstdint>

#include "services/platform/bus/role_names.h"

namespace intaglio::bus::internal {
namespace {

// The group is the library's own.
constexpr char kGroup[] = "239.255.0.1";
constexpr int kBase = 7400, kDomainGain = 250;
constexpr int kToCells = 2, kFirstOfCells = 20;
constexpr std::uint32_t kPortsOfCells = 200;

// FNV-1a, 32 bits: the same on every computer.
int PortOfCell(const std::string& role) {
  std::uint32_t hash = 2166136261U;
  for (const char c : role) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  return kFirstOfCells + static_cast<int>(hash % kPortsOfCells);
}

std::string Peer(int domain, int offset) {
  return fmt::format("<Peers><Peer Address=\"{}:{}\"/></Peers>", kGroup,
                     kBase + kDomainGain * domain + offset);
}

}  // namespace

std::string DiscoveryPorts(int domain, const std::string& role) {
  if (!role.starts_with(kCellPrefix)) return Peer(domain, kToCells);
  return fmt::format(
      "<Ports><MulticastMetaOffset>{}</MulticastMetaOffset>"
      "<MulticastDataOffset>{}</MulticastDataOffset></Ports>{}",
      PortOfCell(role), kToCells, Peer(domain, 0));
}

}  // namespace intaglio::bus::internal
