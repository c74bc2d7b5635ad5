#pragma once

// Marks on their way from one stage to the next, under credit: from the discretizer to
// the sorter (bus::kMarkBatch), from there to the marker (bus::kOrderedMarkBatch). Unlike
// a cloud of points they come in one part. All in the wait set's thread.

#include <chrono>
#include <cstdint>
#include <string>

#include "engrave/mark/mark.h"
#include "services/platform/bus/flow.h"
#include "services/platform/host/stage/mark_batch.h"
#include "services/platform/host/stage/task_part.h"

namespace intaglio::host {

/// Receives the marks of one job after another. Its reader has no limit, for a full one
/// stops the receive thread of the whole process; instead the intake enforces the credit.
/// Another producer may begin anew, with the same marks: the newest attempt counts.
class MarkIntake {
 public:
  MarkIntake(bus::Bus& bus, const std::string& instance,
             const bus::Topic<intaglio_MarkBatch>& topic);

  /// Gives the producer its credit; forgets what came of another job.
  Status Open(const std::string& job_uid, std::uint32_t attempt);
  /// Takes what has come and drops what is not for the open job, also when there is none;
  /// true when all marks are there. kLinkLost: a batch is missing. kFault: a batch
  /// contradicts itself or those before it, or exceeds the credit; the stream is closed
  /// then.
  Result<bool> Poll();
  /// Ends the credit; a producer that is still sending sees that its stream has ended.
  void Close();
  /// All of them, once.
  mark::MarkSet TakeMarks();
  bus::Reader<intaglio_MarkBatch>& reader() { return reader_; }

 private:
  Status Accept(const intaglio_MarkBatch& batch);
  Status Check(const intaglio_MarkBatch& batch) const;
  Status CheckCounts(const intaglio_MarkBatch& batch) const;
  void BeginAgain(std::uint32_t part_attempt);
  std::string StreamOf(std::uint32_t part_attempt) const;

  const char* topic_name_;
  bus::Reader<intaglio_MarkBatch> reader_;
  bus::CreditGrantor credit_;
  std::string job_uid_;
  std::uint32_t attempt_ = 0, part_attempt_ = 0;
  bool open_ = false, complete_ = false;
  std::uint64_t expected_ = 0;  ///< number of the next batch
  std::uint64_t granted_ = 0;   ///< batches below this number may have been sent
  std::uint64_t total_count_ = 0, place_count_ = 0;
  mark::MarkSet marks_;
};

/// Sends the marks of one job after another.
class MarkSender {
 public:
  /// As of CloudSender.
  static constexpr std::chrono::seconds kPatience{60};

  /// `consumers`: the partition of the roles that may grant credit (role_names.h).
  MarkSender(bus::Bus& bus, const bus::Topic<intaglio_MarkBatch>& topic,
             const std::string& consumers);

  void Begin(const std::string& job_uid, std::uint32_t attempt,
             std::uint32_t part_attempt, mark::MarkSet marks,
             std::chrono::steady_clock::time_point now);
  /// Sends what the consumer allows; true when it has taken everything, and when there is
  /// nothing to send. kLinkLost: the consumer is gone or wants no more; kTimedOut: it
  /// takes nothing.
  Result<bool> Advance(std::chrono::steady_clock::time_point now);
  void End();
  bus::Reader<intaglio_Credit>& reader() { return credit_.reader(); }

 private:
  Status SendNext();

  const char* topic_name_;
  bus::Writer<intaglio_MarkBatch> writer_;
  bus::CreditBook credit_;
  std::string job_uid_, stream_;
  std::uint32_t attempt_ = 0, part_attempt_ = 0;
  mark::MarkSet marks_;
  std::size_t next_mark_ = 0;
  bool all_sent_ = false;  ///< an empty set is one empty batch
  std::uint64_t sent_ = 0, consumed_ = 0;
  std::chrono::steady_clock::time_point moved_at_{};  ///< last time that anything moved
};

}  // namespace intaglio::host
