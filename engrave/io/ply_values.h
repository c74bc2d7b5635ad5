#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include "engrave/io/ply_header.h"

namespace intaglio::io {

/// The values behind the header, one after another. Every PLY type fits in a double.
class PlyValues {
 public:
  virtual ~PlyValues() = default;
  /// Nothing at the end of the bytes or where there is no value of that type.
  virtual std::optional<double> Next(PlyType type) = 0;
  /// Whether something but blanks has not been taken: more rows than the header declares,
  /// or rows with more values than it has properties, which were taken for others.
  virtual bool has_more() const = 0;
};

/// `rest`: the file behind its header, which must outlive the values.
std::unique_ptr<PlyValues> PlyValuesOf(PlyEncoding encoding, std::string_view rest);

}  // namespace intaglio::io
