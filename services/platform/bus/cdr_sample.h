#pragma once

// A serialized sample of a topic that is compiled in, as its C struct: what a recording
// holds of our own topics.

#include <cstddef>
#include <memory>
#include <span>

#include "engrave/core/result.h"
#include "engrave/core/try.h"
#include "services/platform/bus/topics.h"

namespace intaglio::bus {

namespace internal {
/// Into `sample`, zeroed storage of the descriptor's size.
Status ReadCdr(const dds_topic_descriptor& type, std::span<const std::byte> cdr,
               void* sample);
void FreeCdr(const dds_topic_descriptor& type, void* sample);
}  // namespace internal

/// Members may be changed, but for strings and sequences, which are the library's.
template <typename T>
class CdrSample {
 public:
  /// `cdr`: encapsulation header (4 bytes) and CDR. kUnreadable when it is no such
  /// sample.
  static Result<CdrSample> Read(const Topic<T>& topic, std::span<const std::byte> cdr) {
    CdrSample made(topic.descriptor);
    INTAGLIO_TRY(internal::ReadCdr(*topic.descriptor, cdr, made.sample_.get()));
    return made;
  }
  T& operator*() { return *sample_; }
  const T& operator*() const { return *sample_; }
  T* operator->() { return sample_.get(); }
  const T* operator->() const { return sample_.get(); }

 private:
  struct Free {
    const dds_topic_descriptor* type;
    void operator()(T* sample) const {
      internal::FreeCdr(*type, sample);
      delete sample;
    }
  };
  explicit CdrSample(const dds_topic_descriptor* type) : sample_(new T{}, Free{type}) {}
  std::unique_ptr<T, Free> sample_;
};

}  // namespace intaglio::bus
