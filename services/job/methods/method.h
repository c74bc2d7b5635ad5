#pragma once

// A method of discretization as a job names it: a row of the table of methods
// (method_table.h). From the rows follow the defaults of a job (job_defaults.h), the
// ranges of its numbers (field_ranges.h), which method suits which model (model_kind.h),
// the options of the command line and the table in docs/jobs.md. How it makes points is
// in a table of its own (point_maker.h), which only a program that makes points links.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/geometry.h"
#include "proto/job.pb.h"

namespace intaglio {

enum class ModelKind { kMesh, kDrawing, kText, kImage, kCloud, kCode };

/// What an absent field of a method becomes.
struct FieldDefault {
  enum class Of {
    kNothing,  ///< it stays absent; one without presence is 0, false or its first name
    kNumber,   ///< `factor`; 1 is true; of a Vector3 each component, of a list its only
               ///< element
    kMinSpacing,  ///< factor * Discretization.min_spacing_mm
    kField,       ///< factor * the number in `field`, a row above in the same method
  };
  Of of = Of::kNothing;
  double factor = 0;
  std::string_view field = {};
};

constexpr FieldDefault Number(double value) {
  return {FieldDefault::Of::kNumber, value, {}};
}
constexpr FieldDefault MinSpacing() { return {FieldDefault::Of::kMinSpacing, 1, {}}; }
constexpr FieldDefault Times(double factor, std::string_view field) {
  return {FieldDefault::Of::kField, factor, field};
}

/// Both ends are allowed.
struct NumberRange {
  double min = 0;
  double max = 0;
};

/// Of the distance of points that a method takes.
inline constexpr NumberRange kPointDistanceMm{0.01, 100};

struct MethodField {
  std::string_view name = {};  ///< in the message of the method; ends in its unit
  /// Of numbers; of a Vector3 each component, of a list each element.
  std::optional<NumberRange> range = {};
  FieldDefault by_default = {};
  /// On the command line, "--layer". Methods share an option for what means the same.
  std::string_view option = {};
  std::string_view meaning = {};  ///< a phrase, for docs/jobs.md and --help
  bool names_image = false;       ///< the field is the name of an image file
};

/// A field that contradicts another field of the job.
struct MethodFault {
  std::string field;  ///< path from the method's message, "curve[2].from"
  std::string value;
  std::string what;  ///< follows the value in the sentence
};

struct Method {
  int number = 0;                     ///< of its field in Model.method
  std::vector<ModelKind> kinds = {};  ///< that it makes points of
  std::vector<ModelKind> default_of =
      {};                                ///< that it is the method of where none is named
  std::string_view meaning = {};         ///< a phrase, for docs/jobs.md
  std::vector<MethodField> fields = {};  ///< every field of its message, each once
  /// The field with the distance of its layers, when an order by layers must not be
  /// thinner than that; else empty.
  std::string_view layer_field = {};
  /// The field with the number of its layers, where one layer has no distance; else
  /// empty.
  std::string_view layer_count_field = {};
  /// From layer to layer where the model gives an axis, length 1, glass frame; nothing:
  /// the normal of its sheet. `rotation`: of its placement. nullptr: none can be given.
  std::optional<Vec3> (*layer_axis)(const Model& model, const Mat3& rotation) = nullptr;
  /// nullptr: nothing can contradict. `job` with its defaults filled in.
  std::vector<MethodFault> (*faults)(const JobSpec& job, const Model& model) = nullptr;

  const google::protobuf::FieldDescriptor& field() const;  ///< in Model
  const google::protobuf::Descriptor& message() const;     ///< its type
  const std::string& name() const;                         ///< "sections"
  bool Suits(ModelKind kind) const;
};

}  // namespace intaglio
