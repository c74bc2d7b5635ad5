#pragma once

// A small model of every kind that methods make points of, for tests of all methods.

#include <string>

#include "services/job/methods/method.h"
#include "services/job/models/model_sources.h"

namespace intaglio {

struct SmallModel {
  std::string file;  ///< a name with the ending; there is no such file
  FileBytes bytes;   ///< what it would hold
};

/// A text has that of a drawing, which its methods take as well.
SmallModel SmallModelOf(ModelKind kind);

}  // namespace intaglio
