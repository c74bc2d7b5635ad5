#pragma once

// Flow under credit. The consumer of a bulk stream reports how many batches it has
// finished and how far the producer may be ahead; nothing is dropped and no reader
// overflows. Stream name: <job_uid>/<attempt>/<topic>; of a part
// .../<part>.<part_attempt>.

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <string>

#include "services/platform/bus/bus.h"

namespace intaglio::bus {

std::string StreamName(const std::string& job_uid, std::uint32_t attempt,
                       const char* topic);
std::string PartStreamName(const std::string& job_uid, std::uint32_t attempt,
                           const char* topic, std::uint32_t part,
                           std::uint32_t part_attempt);

/// Consumer's side: one for a process, any number of streams, one after another.
class CreditGrantor {
 public:
  /// `partition`: of the role that grants, instead of this process's.
  CreditGrantor(Bus& bus, std::string instance, const std::string& partition = {});
  /// Opens a stream read by the reader with this GUID: window batches may come.
  Status Open(const std::string& stream, const Guid& reader, std::uint32_t window);
  /// Batches 0 .. consumed-1 are finished. Published at a quarter of the window, and at
  /// once when `now` is set.
  Status Consumed(const std::string& stream, std::uint64_t consumed, bool now = false);
  /// kFault: batch `number` was not granted: the stream is not open, or its consumer has
  /// published no credit for so many. Every consumer asks it of every batch that it
  /// keeps.
  Status CheckGranted(const std::string& stream, std::uint64_t number) const;
  /// Publishes the grants of every stream again, once a second at most; to be called
  /// while one is waited for. A producer that was away for longer than a lease (stopped,
  /// or cut off) takes all of its streams for ended, and nothing else would correct that.
  void Repeat(std::chrono::steady_clock::time_point now);
  /// The consumer wants no more of it.
  Status Cancel(const std::string& stream);
  /// The stream is over: its instance is disposed.
  Status Close(const std::string& stream);

 private:
  struct Stream {
    Guid reader;
    std::uint32_t window = 0;
    std::uint64_t consumed = 0, published = 0;
    bool cancelled = false;
  };
  Status Publish(const std::string& name, const Stream& stream);
  std::string instance_;
  Writer<intaglio_Credit> writer_;
  std::map<std::string, Stream> streams_;
  std::chrono::steady_clock::time_point repeated_at_{};
};

/// Producer's side: knows how far each stream's consumer has come.
class CreditBook {
 public:
  /// `partition`: of the role that consumes (role_names.h); empty: any consumer.
  explicit CreditBook(Bus& bus, const std::string& partition = {});
  /// Takes what came in; call when the wait set woke.
  void Poll();
  Reader<intaglio_Credit>& reader() { return reader_; }

  struct Grant {
    bool open = false;       ///< the consumer has granted credit for the stream: it is
                             ///< ready
    bool cancelled = false;  ///< it wants no more, or it died
    Guid reader{};
    std::uint64_t consumed = 0;
    std::uint64_t limit = 0;  ///< batches with a number below this may be sent
  };
  Grant Find(const std::string& stream) const;

 private:
  Reader<intaglio_Credit> reader_;
  std::map<std::string, Grant> grants_;
  // Streams that ended, oldest first. The newest are remembered as cancelled, so that a
  // producer that checks a little late does not wait for a consumer that has died.
  std::deque<std::string> ended_;
};

}  // namespace intaglio::bus
