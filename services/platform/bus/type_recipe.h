#pragma once

// What the DDS library has to know of a type to make a topic of it, as text: a recording
// keeps it, so that topics whose types were never compiled here can be played again.
//
// Entries: name, size, align, flags, representations, op_count, ops (32-bit words of the
// library's serializer), keys (name offset index; ...), type_information and type_mapping
// (XTypes, serialized). Words and bytes are hexadecimal, little endian. Good for the
// library's version that wrote it (entry library, "cyclonedds 0.10"): other versions are
// refused.

#include <map>
#include <memory>
#include <string>

#include "engrave/core/result.h"

struct dds_topic_descriptor;

namespace intaglio::bus {

using TypeRecipe = std::map<std::string, std::string>;

namespace internal {
TypeRecipe RecipeOf(const dds_topic_descriptor& descriptor);
}  // namespace internal

/// A descriptor with storage of its own. Lives longer than the topics made of it.
class RecipeDescriptor {
 public:
  /// kUnreadable or kUnsupported, with the entry that is wrong.
  static Result<RecipeDescriptor> Parse(const TypeRecipe& recipe);
  RecipeDescriptor(RecipeDescriptor&&) noexcept;
  RecipeDescriptor& operator=(RecipeDescriptor&&) noexcept;
  ~RecipeDescriptor();
  const dds_topic_descriptor& descriptor() const;

 private:
  struct Parts;
  explicit RecipeDescriptor(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace intaglio::bus
