#pragma once

// What a stage hands to the next one (points, a path, marks) on its way over the bus: in
// batches, under credit. One receiver and one sender serve every kind of content; what is
// special about a kind is its codec (point_batch.h, mark_batch.h).
//
// The whole comes in parts, each a stream of its own under a credit of its own, in any
// order and side by side. A part may be begun again by another producer, with the same
// content: the newest attempt at it counts, and once it is whole it stays so; a producer
// that still sends it once more is acknowledged, so that it can finish.
//
// A codec has
//   Batch, Content    the type of the topic, and what is carried
//   kWindowBatches    batches that may be on their way
//   kItems            what is counted, in plural, for messages
//   PartOf(batch)     the TaskPart that it is of
//   FirstOf(batch), CountOf(batch)   place of its first item in the part; its items
//   SizeOf(content)                  items
//   CheckTotal(batch, others)   whether so many items of this part may come beside those
//                               of the others
//   Receiver          what has come of one part: Append(batch) takes all of a batch or,
//                     with an error, nothing; size(), content
//   Join(parts)       the whole, the parts in their order
//   CountAt(content, first)     items of the batch that begins there: 0 at the end alone
//   Columns(content, first, count)   the arrays of a batch, which borrows them from it
//   SetPlace(batch, part, first)     part and first item, where the topic has them
//
// All in the wait set's thread.

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "services/platform/bus/flow.h"
#include "services/platform/host/stage/mark_batch.h"
#include "services/platform/host/stage/point_batch.h"
#include "services/platform/host/stage/task_part.h"

namespace intaglio::host {

/// Receives one content after another. Its reader has no limit, for a full one stops the
/// receive thread of the whole process; instead the intake enforces the credit.
template <typename Codec>
class Intake {
 public:
  using Batch = typename Codec::Batch;

  Intake(bus::Bus& bus, const std::string& instance, const bus::Topic<Batch>& topic);

  /// Gives the producers of these parts (1..kMaxParts) their credit, for every attempt at
  /// them; forgets an earlier content.
  Status Open(const std::string& job_uid, std::uint32_t attempt,
              std::uint32_t part_count = 1);
  /// Receives what has come and drops what is not for the open content, also when there
  /// is none; true while the content is whole and was not taken. kLinkLost: a batch is
  /// missing. kFault: a batch contradicts itself or those before it, or exceeds the
  /// credit. kTooLarge: more than may come. The streams are closed after an error.
  Result<bool> Poll();
  /// Ends the credit; a producer that is still sending sees that its stream has ended.
  void Close();
  /// The whole content, once.
  typename Codec::Content TakeContent();
  bus::Reader<Batch>& reader() { return reader_; }

 private:
  struct Part {
    std::uint32_t attempt = 0;
    std::uint64_t expected = 0;     ///< number of the next batch
    std::uint64_t reported = 0;     ///< batches below it were reported as consumed
    std::uint64_t total_count = 0;  ///< of items; 0 before the first batch
    bool whole = false;
    typename Codec::Receiver received;
  };
  std::string StreamOf(std::uint32_t part, std::uint32_t part_attempt) const;
  Status Accept(const Batch& batch);
  Status AcceptPart(const Batch& batch, const TaskPart& which);
  Status Check(const Batch& batch, const TaskPart& which) const;
  Status CheckCounts(const Batch& batch, const Part& part) const;
  std::string NameOf(std::uint64_t number, std::uint32_t part) const;
  void BeginAgain(const TaskPart& which);
  Status GrantMore();

  const char* topic_name_;
  bus::Reader<Batch> reader_;
  bus::CreditGrantor credit_;
  std::string job_uid_;
  std::uint32_t attempt_ = 0;
  std::vector<Part> parts_;  ///< none: closed
  bool taken_ = false;
};

/// Sends one content after another.
template <typename Codec>
class Sender {
 public:
  using Batch = typename Codec::Batch;
  /// A consumer that takes nothing for this long is given up: every stage takes what it
  /// is sent at once, and 60 s are longer than any machine is overloaded.
  static constexpr std::chrono::seconds kPatience{60};

  /// `consumers`: the partition of the roles that may grant credit (role_names.h).
  Sender(bus::Bus& bus, const bus::Topic<Batch>& topic, const std::string& consumers);

  /// `content` is this part of the whole.
  void Begin(const std::string& job_uid, std::uint32_t attempt, TaskPart part,
             typename Codec::Content content, std::chrono::steady_clock::time_point now);
  /// Sends what the consumer allows; true when it has taken everything, and when there is
  /// nothing to send. kLinkLost: the consumer is gone or wants no more; kTimedOut: it
  /// takes nothing.
  Result<bool> Advance(std::chrono::steady_clock::time_point now);
  void End();
  bus::Reader<intaglio_Credit>& reader() { return credit_.reader(); }

 private:
  Status SendNext();

  const char* topic_name_;
  bus::Writer<Batch> writer_;
  bus::CreditBook credit_;
  std::string job_uid_, stream_;
  std::uint32_t attempt_ = 0;
  TaskPart part_;
  typename Codec::Content content_;
  std::size_t next_item_ = 0;
  bool all_sent_ = false;  ///< an empty content is one empty batch
  std::uint64_t sent_ = 0, consumed_ = 0;
  std::chrono::steady_clock::time_point moved_at_{};  ///< last time that anything moved
};

using PointIntake = Intake<PointCodec<intaglio_PointBatch>>;
using PointSender = Sender<PointCodec<intaglio_PointBatch>>;
using PathIntake = Intake<PointCodec<intaglio_PathBatch>>;
using MarkIntake = Intake<MarkCodec>;
using MarkSender = Sender<MarkCodec>;

extern template class Intake<PointCodec<intaglio_PointBatch>>;
extern template class Sender<PointCodec<intaglio_PointBatch>>;
extern template class Intake<PointCodec<intaglio_PathBatch>>;
extern template class Sender<PointCodec<intaglio_PathBatch>>;
extern template class Intake<MarkCodec>;
extern template class Sender<MarkCodec>;

}  // namespace intaglio::host
