#pragma once

// Whose turn it is with a queue that several job services may reach: one owns it, by a
// lock of its server, and others that were started with --standby wait. The lock ends
// with the connection of its owner, in whatever way that ends; a file has one job service
// by host::OnlyInstance. Used from one thread.

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "services/job_service/job_store.h"
#include "services/job_service/last_seen.h"
#include "services/sql/connection.h"

namespace intaglio::job_service {

class StoreTurn {
 public:
  /// `address`: of services/sql/address.h.
  StoreTurn(std::string address, bool standby)
      : address_(std::move(address)), standby_(standby) {}

  /// The store, if this process has it now; nullopt: another one has it, and this one
  /// stands by. Throws StoreError: it cannot be reached, or another one has it and this
  /// one was not started to stand by.
  std::optional<JobStore> Try();
  /// What was seen of the owner before this process, while this one stood by; nothing
  /// when none was at work. Of the notes of its own it has seen nothing.
  const std::optional<SeenByStandby>& seen() const { return seen_; }

 private:
  static constexpr std::chrono::nanoseconds kNeverRead{-1};
  void Watch();

  std::string address_;
  bool standby_;
  std::unique_ptr<sql::Connection> connection_;  ///< that does not own it
  std::optional<SeenByStandby> seen_;
  std::string last_note_;
  std::chrono::nanoseconds last_read_ = kNeverRead;  ///< while it stands by
};

}  // namespace intaglio::job_service
