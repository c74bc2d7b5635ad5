#pragma once

// Writes serialized samples as they are, of types that need not be compiled in: what a
// recording needs to be played.
//
// The writers have participants of their own in both domains, apart from the process's
// others. They keep the source time stamps that they are given. When one goes, its
// instances lose their writer; they are not disposed.
//
// From one thread.

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>

#include "services/platform/bus/bus.h"
#include "services/platform/bus/type_recipe.h"

namespace intaglio::bus {

struct CdrTopic {
  DomainKind domain = DomainKind::kControl;
  std::string name;
  std::string partition;  ///< empty: none; several are separated by commas
  std::map<std::string, std::string> qos;  ///< by policy, as TapChannel has it
};

enum class CdrKind {
  kValue,
  kDisposed,  ///< ends the instance; the bytes are its key
  kNoWriter,  ///< lets go of the instance; the bytes are its key
};

class CdrWriter {
 public:
  ~CdrWriter();
  CdrWriter(const CdrWriter&) = delete;
  CdrWriter& operator=(const CdrWriter&) = delete;

  /// `cdr`: encapsulation header (4 bytes) and CDR. kTimedOut: not written, try again.
  /// kUnreadable: it is no sample of the type.
  Status Write(CdrKind kind, std::span<const std::byte> cdr, std::int64_t source_ns);
  int matched_count() const;
  bool IsMatched(const Guid& reader) const;
  /// Until all matched reliable readers have it; kTimedOut otherwise.
  Status WaitForAcknowledgements(std::chrono::milliseconds timeout);

 private:
  friend class CdrPublisher;
  CdrWriter(std::string name, std::int32_t publisher, std::int32_t writer)
      : name_(std::move(name)), publisher_(publisher), writer_(writer) {}
  std::string name_;
  std::int32_t publisher_, writer_;
};

class CdrPublisher {
 public:
  explicit CdrPublisher(Bus& bus);
  ~CdrPublisher();
  CdrPublisher(const CdrPublisher&) = delete;
  CdrPublisher& operator=(const CdrPublisher&) = delete;

  /// Goes before the publisher. kUnsupported when the library refuses the type, or has
  /// another one of that topic; NotAllowedError is thrown as everywhere.
  Result<std::unique_ptr<CdrWriter>> MakeWriter(const CdrTopic& topic,
                                                const TypeRecipe& recipe);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace intaglio::bus
