#pragma once

// The thin layer over the DDS library's C interface: participants and domains, readers
// and writers of typed topics, and waiting. No dds_ name is used outside this folder.
//
//   bus::Bus bus(options);                                  // both domains
//   bus::Writer<intaglio_JobStatus> status(bus, bus::kJobStatus);
//   bus::Reader<intaglio_StageTask> tasks(bus, bus::kSortTask);
//   bus::WaitSet wait(bus);
//   wait.Attach(tasks);
//   while (wait.Wait(50ms)) tasks.Take([&](const intaglio_StageTask& t) { ... });
//
// Threads: a Writer may be used from any thread; a Reader and a WaitSet from one.
// Errors: creating an entity throws BusError (a service cannot start without it);
// writing returns a Status. Bulk, motion and event readers have no resource limits
// (a full reader stops its process); their producers stay within Credit: flow.h.

#include <chrono>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "engrave/core/result.h"
#include "services/platform/bus/raw_entities.h"
#include "services/platform/bus/topics.h"

namespace intaglio::bus {

class BusError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The access control does not permit this to the identity of this process.
class NotAllowedError : public BusError {
 public:
  using BusError::BusError;
};

struct BusOptions {
  int control_domain = 40;       ///< 0..100; bulk is the next one
  std::string interface = "lo";  ///< network interface; "lo" stays on this machine
  std::string tag;   ///< participants of another tag are not seen; empty: none
  std::string cell;  ///< partition of the cell topics; empty: sees every cell
  /// False: a job client, which the job service alone answers; cells and this process do
  /// not discover each other (discovery_ports.h). A cell meets its own services always.
  bool meets_cells = true;
  /// Folder of this process's identity (identity.h), or of several: then the first of
  /// `roles` that is there. Empty: nothing is protected, and the interface has to be lo.
  /// Then the first of `roles` is that of this process all the same.
  std::string security;
  std::vector<std::string> roles = {};
};

/// Both domains of a process. Lives longer than its readers and writers.
class Bus {
 public:
  explicit Bus(const BusOptions& options);
  ~Bus();
  const BusOptions& options() const;
  /// Participants that already exist are discovered within this time, on a host that is
  /// not overloaded. Identities are checked first, one participant after the other.
  std::chrono::milliseconds discovery_time() const;
  /// When the identity ends; max() without one.
  std::chrono::sys_seconds identity_end() const;
  /// The role of this process, that of its identity where it has one; empty: none.
  const std::string& role() const;
  /// 24 hex digits, of the control domain; no other process has the same.
  std::string participant_name() const;
  /// Sends and receives nothing for this duration, in both domains; then rejoins by
  /// itself.
  void Leave(std::chrono::milliseconds duration);

  struct Entities;  // handles; services/platform/bus only
  Entities& entities() { return *entities_; }

 private:
  std::unique_ptr<Entities> entities_;
};

/// What happened to a reader besides samples, since the last check. Does not wake a wait
/// set. A writer that is gone also ends its instances, and that wakes it.
struct ReaderEvents {
  int alive_writers = 0;     ///< matched writers with a held lease
  int lost_leases = 0;       ///< writers whose lease ran out
  int missed_deadlines = 0;  ///< instances that were not written in time
};

/// Who wrote a sample. On a secured bus both were checked by the access control, and no
/// field of the sample can change them.
struct SampleWriter {
  std::string participant;  ///< as Bus::participant_name()
  std::string partition;    ///< several are separated by commas
};

/// Where a sample came from.
struct SampleOrigin {
  bool alive = true;           ///< false: the instance's writer is gone or disposed it;
                               ///< read only the key fields of the sample
  std::int64_t source_ns = 0;  ///< writer's wall clock, for people only
  bool disposed = false;       ///< not alive because a writer disposed it
  /// Null when it is not known any more. Of an instance that ended: the writer that
  /// disposed it, or wrote it last.
  const SampleWriter* writer = nullptr;
};

namespace internal {
template <typename T>
TopicView ViewOf(const Topic<T>& topic) {
  return {topic.name, topic.descriptor, topic.profile, topic.domain, topic.scope};
}
}  // namespace internal

enum class Source { kEverybody, kOtherProcesses };
/// Of an instance between two takes: what its profile keeps, or every sample, so that no
/// writer's sample takes the place of another's. A reader that keeps every sample has to
/// take them.
enum class Keeps { kAsItsProfile, kEverySample };

template <typename T>
class Reader {
 public:
  /// `partition`: the cell of a cell topic, instead of the options' one; the partition of
  /// the role whose samples are read (role_names.h), instead of all roles'.
  Reader(Bus& bus, const Topic<T>& topic, const std::string& partition = {},
         Source source = Source::kEverybody, Keeps keeps = Keeps::kAsItsProfile)
      : raw_(std::make_unique<internal::RawReader>(
            bus, internal::ViewOf(topic), partition,
            internal::ReaderChoice{source == Source::kOtherProcesses,
                                   keeps == Keeps::kEverySample})) {}

  /// Takes what is there, up to a bound, and calls sink(sample) for each live sample; the
  /// sample is valid during the call only. Returns how many were taken.
  template <typename Sink>
  int Take(Sink&& sink) {
    return TakeAll([&sink](const T& sample, const SampleOrigin& origin) {
      if (origin.alive) sink(sample);
    });
  }
  /// The same with sink(sample, origin), also for instances that ended. The last sample
  /// of an instance that ended before it was taken comes first, alive, and then its end.
  template <typename Sink>
  int TakeAll(Sink&& sink) {
    using Callable = std::remove_reference_t<Sink>;
    return raw_->Take(
        [](void* context, const void* sample, const SampleOrigin& origin) {
          (*static_cast<Callable*>(context))(*static_cast<const T*>(sample), origin);
        },
        &sink);
  }

  ReaderEvents events() { return raw_->events(); }
  int matched_count() const { return raw_->matched_count(); }
  Guid guid() const { return raw_->guid(); }
  internal::RawReader& raw() { return *raw_; }

 private:
  std::unique_ptr<internal::RawReader> raw_;
};

template <typename T>
class Writer {
 public:
  /// `partition`: the cell of a cell topic, instead of the options' one; that of a role,
  /// instead of this process's.
  Writer(Bus& bus, const Topic<T>& topic, const std::string& partition = {})
      : raw_(std::make_unique<internal::RawWriter>(bus, internal::ViewOf(topic),
                                                   partition)) {}

  /// kTimedOut: not written, try again. Safety topics: also renews the lease.
  Status Write(const T& sample) { return raw_->Write(&sample); }
  /// Ends the instance with this sample's key.
  Status Dispose(const T& sample) { return raw_->Dispose(&sample); }
  int matched_count() const { return raw_->matched_count(); }
  bool IsMatched(const Guid& reader) const { return raw_->IsMatched(reader); }
  /// Until all matched reliable readers have it; kTimedOut otherwise.
  Status WaitForAcknowledgements(std::chrono::milliseconds timeout) {
    return raw_->WaitForAcknowledgements(timeout);
  }

 private:
  std::unique_ptr<internal::RawWriter> raw_;
};

/// Wakes one thread for samples and events of its readers, or when Wake is called.
class WaitSet {
 public:
  explicit WaitSet(Bus& bus);
  ~WaitSet();
  template <typename T>
  void Attach(Reader<T>& reader) {
    AttachRaw(reader.raw());
  }
  /// True when something is there, false after the timeout.
  bool Wait(std::chrono::milliseconds timeout);
  /// From any thread: the next or current Wait returns true.
  void Wake();

 private:
  void AttachRaw(internal::RawReader& reader);
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace intaglio::bus
