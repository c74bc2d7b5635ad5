#pragma once

// Drawings, texts and pictures of a job, placed, as sources of points by their method.
// `job` with its defaults filled in; errors do not name the model's file but where its
// reader does.

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "services/job/methods/method.h"
#include "services/job/models/read_limits.h"

namespace intaglio {

/// What a file holds that is not engraved is added to `warnings`.
MadePoints MakeDrawing(const Method& method, const MethodInput& input,
                       std::string_view file, const ReadLimits& limits,
                       std::vector<std::string>& warnings);

/// The model's text in the font, with `text` in place of it.
MadePoints MakeText(const Method& method, const MethodInput& input,
                    const std::string& text, std::string_view font);

MadePoints MakePicture(const Method& method, const MethodInput& input,
                       std::string_view file, const ReadLimits& limits);

}  // namespace intaglio
