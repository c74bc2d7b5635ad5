#pragma once

// Listens to every topic of both domains, without compiled types: finds all writers and
// their topics, makes readers from the types that the writers announce, and hands the
// serialized bytes on.
//
// It blocks no other process. Its readers take no part in the flow under credit (flow.h):
// they grant none. They are reliable where the writer is, and keep all without limits, so
// that a sample is acknowledged when it arrives; the thread that calls Take has to do so
// at once and hand the samples over, because samples that wait in a reader take memory.
// Only a process that is stopped altogether makes a writer wait, until its lease of 2 s
// has run out.
//
// Threads: Discover from one thread, Take from one other or the same; the rest from any.

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "services/platform/bus/bus.h"
#include "services/platform/bus/type_recipe.h"

struct ddsi_serdata;

namespace intaglio::bus {

/// All writers of one topic and type in one partition.
struct TapChannel {
  std::uint32_t number = 0;  ///< from 0, in the order of discovery
  DomainKind domain = DomainKind::kControl;
  std::string topic;
  std::string type;       ///< e.g. "intaglio::JobStatus"
  std::string partition;  ///< empty: none; several are separated by commas
  bool keyed = false;
  std::map<std::string, std::string> qos;  ///< of the first writer, by policy, for people
  std::string idl;      ///< the type in IDL; empty when the writer does not announce it
  std::string key_idl;  ///< <type>_key, of the key members alone; empty without key
  TypeRecipe recipe;
};

enum class TapKind {
  kValue,
  kDisposed,  ///< a writer disposed the instance; the bytes are its key
  kNoWriter,  ///< the last writer of the instance is gone; the bytes are its key
};

/// A sample as it was received: its bytes are the library's, kept until this is gone.
class TapSample {
 public:
  TapSample(TapSample&& other) noexcept;
  TapSample& operator=(TapSample&& other) noexcept;
  ~TapSample();

  /// Encapsulation header (4 bytes) and CDR.
  std::span<const std::byte> bytes() const { return bytes_; }
  std::uint32_t channel() const { return channel_; }
  TapKind kind() const { return kind_; }
  std::int64_t source_ns() const { return source_ns_; }      ///< writer's wall clock
  std::int64_t received_ns() const { return received_ns_; }  ///< our wall clock

 private:
  friend class TopicTap;  // and its private parts
  TapSample() = default;
  ddsi_serdata* sample_ = nullptr;
  ddsi_serdata* reference_ = nullptr;
  std::span<const std::byte> bytes_;
  std::uint32_t channel_ = 0;
  TapKind kind_ = TapKind::kValue;
  std::int64_t source_ns_ = 0, received_ns_ = 0;
};

class TopicTap {
 public:
  /// True: a topic is read. Decides by domain, topic, type and partition alone.
  using Filter = std::function<bool(const TapChannel&)>;
  /// A topic that cannot be read, once each: its name and why.
  using Complaint = std::function<void(const std::string& topic, const std::string& why)>;

  TopicTap(Bus& bus, Filter filter, Complaint complaint);
  ~TopicTap();

  /// Waits for new writers, and makes their readers. A type that is asked for over the
  /// network may take half a second.
  void Discover(std::chrono::milliseconds timeout);

  /// Waits for samples and calls sink(sample) for each that is there. How many.
  int Take(std::chrono::milliseconds timeout,
           const std::function<void(TapSample&&)>& sink);
  /// How many writers of this topic are there, the own process's too; nothing: the topic
  /// is not read. From any thread.
  std::optional<std::size_t> WriterCount(const std::string& topic) const;
  /// From any thread: the current or next Take returns.
  void Wake();

  /// Valid as long as the tap; a sample's channel is there before the sample.
  const TapChannel& channel(std::uint32_t number) const;
  std::uint32_t channel_count() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace intaglio::bus
