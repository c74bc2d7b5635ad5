#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/mesh/mesh_formats.h"

namespace intaglio::mesh {

/// A model file as named in errors, and its limits.
struct ImportSource {
  std::string name;
  std::string extension;  ///< lower case, without a dot
  ImportOptions options;
  double unit_mm = 1;  ///< by which coordinates of the library's scene are multiplied

  tl::unexpected<Error> Refuse(ErrorCode code,
                               std::string_view problem_and_remedy) const {
    return Fail(code, fmt::format("{}: {}", name, problem_and_remedy), name);
  }
  /// For a file that is damaged, or not of the format of its extension. A library may
  /// give as its reason what the file has there: only the beginning of `why` is printed.
  tl::unexpected<Error> RefuseAsUnreadable(std::string_view why) const {
    return Refuse(
        ErrorCode::kUnreadable,
        fmt::format("it cannot be read as {} ({:.200}); check that it is complete "
                    "and has this format, or export it again",
                    extension, why));
  }
  tl::unexpected<Error> RefuseTriangleCount() const {
    return Refuse(ErrorCode::kTooLarge,
                  fmt::format("the model has more than the {} triangles allowed; reduce "
                              "the mesh or raise the limit",
                              options.max_triangles));
  }
  /// For a name of `options.objects` that is none of the file's.
  tl::unexpected<Error> RefuseObject(const std::string& asked,
                                     const std::vector<std::string>& names) const {
    const std::string known =
        names.empty() ? "it names none; remove the field objects"
                      : fmt::format("its objects are \"{}\"", fmt::join(names, "\", \""));
    return Fail(ErrorCode::kMissing,
                fmt::format("{}: objects: the file has no object \"{}\" with faces; {}",
                            name, asked, known),
                asked);
  }
  tl::unexpected<Error> RefuseEmptyModel() const {
    return Refuse(ErrorCode::kMissing,
                  "it has no triangles; export the model as a surface mesh, not as "
                  "points or lines");
  }
};

}  // namespace intaglio::mesh
