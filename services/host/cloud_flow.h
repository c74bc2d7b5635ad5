#pragma once

// A cloud of points on its way from one stage to the next, under credit. Batch is
// intaglio_PointBatch or intaglio_PathBatch, which have the same members.

#include <chrono>
#include <cstdint>
#include <string>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "services/bus/flow.h"

namespace intaglio::host {

/// 229 kB a batch: large enough for the network, small enough to spread the work.
inline constexpr std::size_t kBatchPoints = 8192;

/// The published machine engraves 2 million points; ten times that is 560 MB.
inline constexpr std::uint64_t kMaxCloudPoints = 20'000'000;

/// Receives the clouds of one stream after another, all in the wait set's thread.
template <typename Batch>
class CloudIntake {
 public:
  CloudIntake(bus::Bus& bus, const std::string& instance, const bus::Topic<Batch>& topic);

  /// Gives the producer of this stream its credit; forgets an earlier stream.
  Status Open(const std::string& job_uid, std::uint32_t attempt);
  /// Takes what has come; true when the cloud is whole. kLinkLost: a batch is missing.
  /// kFault: a batch contradicts itself. kTooLarge: more than kMaxCloudPoints.
  Result<bool> Poll();
  /// Ends the credit; a producer that is still sending hears that nobody listens.
  void Close();
  /// The whole cloud, once.
  PointCloud TakeCloud() { return std::move(cloud_); }
  bus::Reader<Batch>& reader() { return reader_; }

 private:
  Status Accept(const Batch& batch);

  const char* topic_name_;
  bus::Reader<Batch> reader_;
  bus::CreditGrantor credit_;
  std::string job_uid_, stream_;
  std::uint32_t attempt_ = 0;
  std::uint64_t expected_ = 0;  // number of the next batch
  bool complete_ = false;
  PointCloud cloud_;
};

/// Sends one cloud after another, all in the wait set's thread.
template <typename Batch>
class CloudSender {
 public:
  /// A consumer that takes nothing for this long is given up: every stage takes what it
  /// is sent at once, and 60 s are longer than any machine is overloaded.
  static constexpr std::chrono::seconds kPatience{60};

  CloudSender(bus::Bus& bus, const bus::Topic<Batch>& topic);

  void Begin(const std::string& job_uid, std::uint32_t attempt, PointCloud cloud,
             std::chrono::steady_clock::time_point now);
  /// Sends what the consumer allows; true when it has taken everything. kLinkLost: the
  /// consumer is gone or wants no more; kTimedOut: it takes nothing.
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
  PointCloud cloud_;
  std::uint64_t sent_ = 0, consumed_ = 0;
  std::chrono::steady_clock::time_point moved_at_{};  // last time that anything moved
};

extern template class CloudIntake<intaglio_PointBatch>;
extern template class CloudSender<intaglio_PointBatch>;
extern template class CloudSender<intaglio_PathBatch>;

}  // namespace intaglio::host
