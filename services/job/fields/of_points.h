#pragma once

// What the points of a job have by their model, for each point.

#include <fmt/format.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio {

/// `of_models` by model; `source`: the number of the model of each point. kFault: there
/// is no such model.
template <typename Value>
Result<std::vector<Value>> OfPoints(const std::vector<Value>& of_models,
                                    std::span<const std::uint32_t> source) {
  std::vector<Value> values;
  values.reserve(source.size());
  for (const std::uint32_t model : source) {
    if (model >= of_models.size()) {
      return Fail(
          ErrorCode::kFault,
          fmt::format("point {} is of model {}, but the job has {}: restart the task",
                      values.size(), model, of_models.size()),
          std::to_string(model));
    }
    values.push_back(of_models[model]);
  }
  return values;
}

}  // namespace intaglio
