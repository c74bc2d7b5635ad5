#pragma once

// The untyped half of Reader and Writer: all calls to the DDS library are behind it.

#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <unordered_map>

#include "engrave/core/result.h"
#include "services/platform/bus/topics.h"

namespace intaglio::bus {

class Bus;
struct ReaderEvents;
struct SampleOrigin;
struct SampleWriter;
using Guid = std::array<std::uint8_t, 16>;

namespace internal {

/// Properties of the typed topic, without its type.
struct TopicView {
  const char* name;
  const dds_topic_descriptor* descriptor;
  Profile profile;
  DomainKind domain;
  Scope scope;
};

struct ReaderChoice {
  bool others_only = false;  ///< not what this process writes
  bool keep_all = false;     ///< every sample, also where the profile keeps the newest
};

/// Of its GUID of 16 bytes: as Bus::participant_name().
std::string ParticipantName(const std::uint8_t* guid);

/// Whether the writer has found the reader.
bool IsMatched(std::int32_t writer, const Guid& reader);

class RawReader {
 public:
  using Sink = void (*)(void* context, const void* sample, const SampleOrigin& origin);

  RawReader(Bus& bus, const TopicView& topic, const std::string& partition,
            const ReaderChoice& choice = {});
  ~RawReader();
  RawReader(const RawReader&) = delete;
  RawReader& operator=(const RawReader&) = delete;

  int Take(Sink sink, void* context);
  ReaderEvents events();
  int matched_count() const;
  Guid guid() const;
  /// A condition that holds while samples wait to be taken.
  std::int32_t condition() const { return condition_; }

 private:
  /// Null: the writer was gone before its properties could be read.
  const SampleWriter* WriterOf(std::uint64_t publication);

  bool keyed_ = false;
  std::unordered_map<std::uint64_t, SampleWriter> writers_;
  std::int32_t subscriber_ = 0;
  std::int32_t reader_ = 0;
  std::int32_t condition_ = 0;
};

class RawWriter {
 public:
  RawWriter(Bus& bus, const TopicView& topic, const std::string& partition);
  ~RawWriter();
  RawWriter(const RawWriter&) = delete;
  RawWriter& operator=(const RawWriter&) = delete;

  Status Write(const void* sample);
  Status Dispose(const void* sample);
  int matched_count() const;
  bool IsMatched(const Guid& reader) const;
  Status WaitForAcknowledgements(std::chrono::milliseconds timeout);

 private:
  Status Answer(std::int32_t code, const char* what) const;
  std::int32_t publisher_ = 0;
  std::int32_t writer_ = 0;
  std::string topic_;
};

}  // namespace internal
}  // namespace intaglio::bus
