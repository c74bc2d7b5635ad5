#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::io {

enum class PlyType {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kFloat,
  kDouble,
};

/// Bytes of a value in a binary file.
std::size_t SizeOf(PlyType type);

enum class PlyEncoding { kAscii, kLittleEndian, kBigEndian };

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat;
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  ///< of a list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;  ///< rows; the largest number when the header's is larger
  std::vector<PlyProperty> properties;
};

/// The header of a PLY file (Turk 1994), of points or of a mesh.
struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;
  std::vector<std::string> comments;
  std::size_t size = 0;  ///< bytes up to the first value
};

/// `bytes`: the file, or as much of its beginning as a header may take. kUnreadable,
/// naming the line, when it is not the header of a PLY file.
Result<PlyHeader> ParsePlyHeader(std::string_view bytes);

/// Whether the rows of that element are faces: polygons, triangle strips or a grid.
bool HoldsFaces(const PlyElement& element);

/// Whether it has a list of whole numbers, as faces of any name have.
bool HoldsLists(const PlyElement& element);

}  // namespace intaglio::io
