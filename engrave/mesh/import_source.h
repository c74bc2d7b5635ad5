#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "engrave/core/result.h"
#include "engrave/mesh/mesh_import.h"

namespace intaglio::mesh {

/// A model file as named in errors, and its limits.
struct ImportSource {
  std::string name;
  std::string extension;  ///< lower case, without a dot
  ImportOptions options;

  tl::unexpected<Error> Refuse(ErrorCode code,
                               std::string_view problem_and_remedy) const {
    return Fail(code, fmt::format("{}: {}", name, problem_and_remedy), name);
  }
  /// For a file that is damaged, or not of the format of its extension.
  tl::unexpected<Error> RefuseAsUnreadable(std::string_view why) const {
    return Refuse(ErrorCode::kUnreadable,
                  fmt::format("it cannot be read as {} ({}); check that it is complete "
                              "and has this format, or export it again",
                              extension, why));
  }
  tl::unexpected<Error> RefuseTriangleCount() const {
    return Refuse(ErrorCode::kTooLarge,
                  fmt::format("the model has more than the {} triangles allowed; reduce "
                              "the mesh or raise the limit",
                              options.max_triangles));
  }
  tl::unexpected<Error> RefuseEmptyModel() const {
    return Refuse(ErrorCode::kMissing,
                  "it has no triangles; export the model as a surface mesh, not as "
                  "points or lines");
  }
};

}  // namespace intaglio::mesh
