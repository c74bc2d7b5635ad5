#pragma once

// What late readers of the retained (transient-local) topics would be given: the newest
// samples of each instance that lives, as many as its writers keep (keep_last N). An
// instance is a topic in its domain and partition, and the key of its samples; without
// key there is one. What is disposed, or has no writer any more, is forgotten.
//
// Bounded in bytes: beyond the limit the instances that changed last are kept.
//
// From one thread. Streams have the caller's own numbers.

#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "services/platform/recording/conventions.h"
#include "services/platform/recording/idl_types.h"

namespace intaglio::recording {

/// Do late readers of the stream get samples from before?
bool IsRetained(const Stream& stream);

/// By what the key of a stream's samples is read.
struct SampleType {
  std::string name;  ///< of the stream's schema; of its ends: that of the key alone
  std::string idl;   ///< empty: not known
  std::string keys;  ///< entry "keys" of the type's recipe: "name offset index;" each
};

struct RetainedSample {
  std::uint32_t stream = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_time_ns = 0, publish_time_ns = 0;
  Bytes payload;
};

class RetainedState {
 public:
  explicit RetainedState(
      std::uint64_t max_bytes = std::numeric_limits<std::uint64_t>::max())
      : max_bytes_(max_bytes) {}
  RetainedState(RetainedState&&) = default;
  RetainedState& operator=(RetainedState&&) = default;

  /// Before the stream's first sample. False: its key cannot be read, and its samples are
  /// passed over.
  bool Learn(std::uint32_t number, const Stream& stream, const SampleType& type);
  /// Samples in the order of their reception; those of other streams are passed over.
  void Receive(std::uint32_t number, std::uint32_t sequence, std::uint64_t log_time_ns,
               std::uint64_t publish_time_ns, ByteView payload);

  /// In the order of their reception. Valid until the next Take.
  std::vector<const RetainedSample*> Samples() const;
  bool empty() const { return kept_.empty(); }
  std::uint64_t bytes() const { return bytes_; }
  /// How often an instance was forgotten because of the limit.
  std::uint64_t forgotten_count() const { return forgotten_count_; }

 private:
  struct Learned {
    std::string place;  // topic, domain and partition
    SampleKind kind = SampleKind::kValue;
    bool keyed = false;
    std::size_t depth = 1;
    IdlTypes types;
    std::string value_type;
    std::vector<std::string> key_names;  // as "member" or "member.member"
  };
  using Instance = std::pair<std::string, std::string>;  // place; key
  struct Kept {
    std::deque<std::pair<std::uint64_t, RetainedSample>> samples;  // by turn
    std::uint64_t bytes = 0;
    std::uint64_t changed = 0;  // turn of the newest
  };
  static std::string KeyOf(const Learned& learned, ByteView payload);
  void Add(const Learned& learned, Instance&& instance, RetainedSample&& sample);
  void Forget(const Instance& instance);

  std::uint64_t max_bytes_;
  std::map<std::uint32_t, Learned> learned_;  // by number of the stream
  std::map<Instance, Kept> kept_;
  std::map<std::uint64_t, const Instance*> by_change_;  // by turn, into kept_
  std::uint64_t turn_ = 0, bytes_ = 0, forgotten_count_ = 0;
};

}  // namespace intaglio::recording
