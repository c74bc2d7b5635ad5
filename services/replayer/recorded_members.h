#pragma once

// The members of a decoded sample by their names.

#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "services/platform/recording/cdr_value.h"
#include "services/replayer/recorded_samples.h"

namespace intaglio::replayer {

/// Reads members by name; good() is false once one was not there or of another kind.
class Members {
 public:
  explicit Members(const recording::Value& value) : value_(value) {}

  template <typename T>
  requires std::is_unsigned_v<T>
  void Get(const char* name, T& out) {
    if constexpr (std::is_same_v<T, bool>) {
      if (const bool* held = As<bool>(name)) out = *held;
    } else if (const auto* held = As<std::uint64_t>(name)) {
      out = static_cast<T>(*held);
    }
  }
  void Get(const char* name, std::string& out) {
    if (const auto* held = As<std::string>(name)) out = *held;
  }
  void Get(const char* name, double& out) {
    if (const auto* held = As<double>(name)) out = *held;
  }
  void Get(const char* name, std::vector<double>& out) {
    if (const auto* held = As<std::vector<double>>(name)) out = *held;
  }
  template <typename T>
  requires std::is_unsigned_v<T>
  void Get(const char* name, std::vector<T>& out) {
    if (const auto* held = As<std::vector<std::uint64_t>>(name)) {
      out.reserve(held->size());
      for (const std::uint64_t number : *held) out.push_back(static_cast<T>(number));
    }
  }
  void Get(StreamId& id) {
    Get("job_uid", id.job_uid);
    Get("attempt", id.attempt);
    Get("part", id.part);
    Get("part_attempt", id.part_attempt);
  }
  bool good() const { return good_; }

 private:
  template <typename T>
  const T* As(const char* name) {
    const recording::Value* member = value_.Find(name);
    const T* held = member == nullptr ? nullptr : member->As<T>();
    good_ = good_ && held != nullptr;
    return held;
  }
  const recording::Value& value_;
  bool good_ = true;
};

}  // namespace intaglio::replayer
