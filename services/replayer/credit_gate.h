#pragma once

// Lets batches of bulk topics go as their consumers grant credit
// (services/platform/bus/flow.h). A stream that no consumer opens within kPatience is
// sent without credit: its readers then grant none. Once one stream was sent so and no
// consumer has ever opened any, no other stream is waited for.

#include <chrono>
#include <map>
#include <optional>
#include <string>

#include "services/platform/bus/cdr_writer.h"
#include "services/platform/bus/flow.h"
#include "services/platform/recording/mcap_fields.h"

namespace intaglio::replayer {

/// Which batch of which stream a sample of a bulk topic is.
struct BatchPlace {
  std::string stream;
  std::uint64_t number = 0;  ///< from 0
};
/// Nothing for topics without credit, and for what is no such sample.
std::optional<BatchPlace> PlaceOf(const std::string& topic, recording::ByteView cdr);

class CreditGate {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::seconds kPatience{3};

  /// Sees the consumers of other processes and of this one.
  explicit CreditGate(bus::Bus& bus) : book_(bus) {}
  /// Asked again until it is true.
  bool MayGo(const BatchPlace& place, const bus::CdrWriter& writer, TimePoint now);

 private:
  bus::CreditBook book_;
  std::map<std::string, TimePoint> waits_;  // since when, by stream
  bool anybody_ = false, nobody_ = false;
};

}  // namespace intaglio::replayer
