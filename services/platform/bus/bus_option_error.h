#pragma once

#include "engrave/core/result.h"
#include "services/platform/bus/bus.h"

namespace intaglio::bus {

/// The options or the environment name what this computer does not have, or what is not
/// allowed together: wrong input of a person, and no fault of a program.
class BusOptionError : public BusError {
 public:
  explicit BusOptionError(const Error& error) : BusError(error.message), error_(error) {}
  const Error& error() const { return error_; }

 private:
  Error error_;
};

}  // namespace intaglio::bus
