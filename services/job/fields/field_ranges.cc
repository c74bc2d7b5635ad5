#include "services/job/fields/field_ranges.h"

namespace intaglio {

std::vector<Finding> OutOfRange(const google::protobuf::Message& message,
                                const std::string& path) {
  std::vector<Finding> found;
  for (NumberFault& fault : NumbersOutOfRange(message, path))
    found.emplace_back(std::move(fault.error), std::move(fault.field));
  return found;
}

}  // namespace intaglio
