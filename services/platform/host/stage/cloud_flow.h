#pragma once

// A cloud of points on its way from one stage to the next, under credit. Batch is
// intaglio_PointBatch or intaglio_PathBatch, which have the same members.

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "services/platform/bus/flow.h"
#include "services/platform/host/stage/task_part.h"

namespace intaglio::host {

/// 229 kB a batch: large enough for the network, small enough to spread the work.
inline constexpr std::size_t kBatchPoints = 8192;

/// The published machine engraves 2 million points; ten times that is 560 MB.
inline constexpr std::uint64_t kMaxCloudPoints = 20'000'000;

/// Receives one cloud after another, all in the wait set's thread. A cloud comes in
/// parts, each a stream of its own under a credit of its own, in any order and side by
/// side. A part may be begun again by another producer, with the same points: the newest
/// attempt at it counts, and once it is whole it stays so; a producer that still sends it
/// once more is acknowledged, so that it can finish.
template <typename Batch>
class CloudIntake {
 public:
  CloudIntake(bus::Bus& bus, const std::string& instance, const bus::Topic<Batch>& topic);

  /// Gives the producers of these parts (1..kMaxParts) their credit, for every attempt at
  /// them; forgets an earlier cloud.
  Status Open(const std::string& job_uid, std::uint32_t attempt,
              std::uint32_t part_count = 1);
  /// Takes what has come and drops what is not for the open cloud, also when there is
  /// none; true when the cloud is whole. kLinkLost: a batch is missing. kFault: a batch
  /// contradicts itself. kTooLarge: more than kMaxCloudPoints.
  Result<bool> Poll();
  /// Ends the credit; a producer that is still sending sees that its stream has ended.
  void Close();
  /// The whole cloud, its parts in their order, once.
  PointCloud TakeCloud();
  bus::Reader<Batch>& reader() { return reader_; }

 private:
  struct Part {
    std::uint32_t attempt = 0;
    std::uint64_t expected = 0;  // number of the next batch
    bool whole = false;
    std::uint64_t total_count = 0;  // of points; 0 before the first batch
    PointCloud cloud;
  };
  std::string StreamOf(std::uint32_t part, std::uint32_t part_attempt) const;
  Status Accept(const Batch& batch);
  Status Check(const Batch& batch, const Part& part) const;
  void BeginAgain(std::uint32_t part, std::uint32_t part_attempt);

  const char* topic_name_;
  bus::Reader<Batch> reader_;
  bus::CreditGrantor credit_;
  std::string job_uid_;
  std::uint32_t attempt_ = 0;
  std::vector<Part> parts_;  // none: closed
};

/// Sends one cloud after another, all in the wait set's thread.
template <typename Batch>
class CloudSender {
 public:
  /// A consumer that takes nothing for this long is given up: every stage takes what it
  /// is sent at once, and 60 s are longer than any machine is overloaded.
  static constexpr std::chrono::seconds kPatience{60};

  /// `consumers`: the partition of the roles that may grant credit (role_names.h).
  CloudSender(bus::Bus& bus, const bus::Topic<Batch>& topic,
              const std::string& consumers);

  /// `cloud` is this part of the whole.
  void Begin(const std::string& job_uid, std::uint32_t attempt, TaskPart part,
             PointCloud cloud, std::chrono::steady_clock::time_point now);
  /// Sends what the consumer allows; true when it has taken everything, and when there is
  /// nothing to send. kLinkLost: the consumer is gone or wants no more; kTimedOut: it
  /// takes nothing.
  Result<bool> Advance(std::chrono::steady_clock::time_point now);
  void End();
  bus::Reader<intaglio_Credit>& reader() { return credit_.reader(); }

 private:
  std::uint64_t batch_count() const;
  Status SendNext();

  const char* topic_name_;
  bus::Writer<Batch> writer_;
  bus::CreditBook credit_;
  std::string job_uid_, stream_;
  std::uint32_t attempt_ = 0;
  TaskPart part_;
  PointCloud cloud_;
  std::uint64_t sent_ = 0, consumed_ = 0;
  std::chrono::steady_clock::time_point moved_at_{};  // last time that anything moved
};

extern template class CloudIntake<intaglio_PointBatch>;
extern template class CloudSender<intaglio_PointBatch>;
extern template class CloudSender<intaglio_PathBatch>;

}  // namespace intaglio::host
