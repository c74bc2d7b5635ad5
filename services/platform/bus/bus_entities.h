#pragma once

// Handles behind a Bus. For services/platform/bus only.

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "services/platform/bus/bus.h"

namespace intaglio::bus {

/// A DDS domain of this process with the configuration it was made with; created by the
/// first Bus that needs it and deleted by the last.
class DomainHold {
 public:
  /// `security`: that part of the library's configuration, or empty.
  DomainHold(int domain, const BusOptions& options, const std::string& security);
  ~DomainHold();
  DomainHold(const DomainHold&) = delete;
  DomainHold& operator=(const DomainHold&) = delete;

 private:
  int domain_;
};

struct Bus::Entities {
  explicit Entities(const BusOptions& bus_options);
  ~Entities();

  /// This process joins the bulk domain at the first call that asks for it: most clients
  /// and the motion bridge never do, and save a participant with its threads and packets.
  std::int32_t participant(DomainKind kind);
  /// One topic entity a name: the library wants no second one.
  std::int32_t TopicOf(const internal::TopicView& view);

  BusOptions options;
  std::chrono::sys_seconds identity_end = std::chrono::sys_seconds::max();
  std::string role;
  std::string security;
  DomainHold control_domain;
  std::int32_t control = 0;
  std::mutex bulk_mutex;
  std::optional<DomainHold> bulk_domain;
  std::int32_t bulk = 0;  ///< 0: not joined
  std::mutex mutex;
  std::map<std::string, std::int32_t> topics;
};

}  // namespace intaglio::bus
