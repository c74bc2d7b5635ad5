#include "services/platform/bus/type_text.h"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_xqos.h>

// After ddsi_xqos.h, which they need and do not include.
#include <dds/ddsi/ddsi_typelib.h>
#include <dds/ddsi/ddsi_xt_impl.h>
#include <fmt/format.h>

#include <cstring>
#include <map>
#include <memory>
#include <vector>

#include "services/platform/bus/samples.h"

namespace intaglio::bus::internal {
namespace {

using Identifier = DDS_XTypes_TypeIdentifier;

/// A part of a type that IDL text is not made of; caught in TextOf.
struct NotDescribed {};

struct ObjectDeleter {
  void operator()(dds_typeobj_t* object) const noexcept { dds_free_typeobj(object); }
};
using Object = std::unique_ptr<dds_typeobj_t, ObjectDeleter>;

const char* PrimitiveName(std::uint8_t kind) {
  switch (kind) {
    case DDS_XTypes_TK_BOOLEAN:
      return "boolean";
    case DDS_XTypes_TK_BYTE:
      return "octet";
    case DDS_XTypes_TK_INT16:
      return "int16";
    case DDS_XTypes_TK_INT32:
      return "int32";
    case DDS_XTypes_TK_INT64:
      return "int64";
    case DDS_XTypes_TK_UINT16:
      return "uint16";
    case DDS_XTypes_TK_UINT32:
      return "uint32";
    case DDS_XTypes_TK_UINT64:
      return "uint64";
    case DDS_XTypes_TK_FLOAT32:
      return "float";
    case DDS_XTypes_TK_FLOAT64:
      return "double";
    case DDS_XTypes_TK_CHAR8:
      return "char";
    default:
      return nullptr;
  }
}

const char* Extensibility(std::uint16_t flags) {
  if ((flags & DDS_XTypes_IS_MUTABLE) != 0) return "@mutable";
  return (flags & DDS_XTypes_IS_APPENDABLE) != 0 ? "@appendable" : "@final";
}

/// How a member is declared: its type, and what follows its name.
struct Declared {
  std::string type;
  std::string suffix;
};

std::string Bound(std::uint32_t bound, const char* before) {
  return bound == 0 ? "" : fmt::format("{}{}", before, bound);
}

class Writer {
 public:
  explicit Writer(dds_entity_t participant) : participant_(participant) {}

  TypeText Write(const Identifier& type) {
    const Object object = Resolve(type);
    const auto& complete = object->x._u.complete;
    if (complete._d != DDS_XTypes_TK_STRUCTURE) throw NotDescribed{};
    Declare(type);
    TypeText text{Text(), ""};
    WriteKey(complete._u.struct_type);
    return text;
  }

  std::string key_text() const { return has_key_ ? Text() : ""; }

 private:
  Object Resolve(const Identifier& type) const {
    const ddsi_typeid id{type};
    dds_typeobj_t* found = nullptr;
    if (type._d != DDS_XTypes_EK_COMPLETE ||
        dds_get_typeobj(participant_, &id, kTypeTimeoutNs, &found) != DDS_RETCODE_OK ||
        found == nullptr) {
      throw NotDescribed{};
    }
    Object object(found);
    if (object->x._d != DDS_XTypes_EK_COMPLETE) throw NotDescribed{};
    return object;
  }

  Declared Declare(const Identifier& type) {
    if (const char* name = PrimitiveName(type._d)) return {name, ""};
    switch (type._d) {
      case DDS_XTypes_TI_STRING8_SMALL:
        return BoundedText(type._u.string_sdefn.bound);
      case DDS_XTypes_TI_STRING8_LARGE:
        return BoundedText(type._u.string_ldefn.bound);
      case DDS_XTypes_TI_PLAIN_SEQUENCE_SMALL:
        return Sequence(*type._u.seq_sdefn.element_identifier, type._u.seq_sdefn.bound);
      case DDS_XTypes_TI_PLAIN_SEQUENCE_LARGE:
        return Sequence(*type._u.seq_ldefn.element_identifier, type._u.seq_ldefn.bound);
      case DDS_XTypes_TI_PLAIN_ARRAY_SMALL:
        return Array(*type._u.array_sdefn.element_identifier,
                     View(type._u.array_sdefn.array_bound_seq));
      case DDS_XTypes_TI_PLAIN_ARRAY_LARGE:
        return Array(*type._u.array_ldefn.element_identifier,
                     View(type._u.array_ldefn.array_bound_seq));
      case DDS_XTypes_EK_COMPLETE:
        return Named(type);
      default:
        throw NotDescribed{};
    }
  }

  static Declared BoundedText(std::uint32_t bound) {
    return {bound == 0 ? "string" : fmt::format("string<{}>", bound), ""};
  }

  Declared Sequence(const Identifier& element, std::uint32_t bound) {
    const Declared inner = Declare(element);
    if (!inner.suffix.empty()) throw NotDescribed{};
    return {fmt::format("sequence<{}{}>", inner.type, Bound(bound, ", ")), ""};
  }

  template <typename Bounds>
  Declared Array(const Identifier& element, const Bounds& bounds) {
    Declared inner = Declare(element);
    std::string suffix;
    for (const auto bound : bounds) suffix += fmt::format("[{}]", bound);
    return {inner.type, suffix + inner.suffix};
  }

  Declared Named(const Identifier& type) {
    const std::string hash(reinterpret_cast<const char*>(type._u.equivalence_hash),
                           sizeof type._u.equivalence_hash);
    if (const auto known = known_.find(hash); known != known_.end()) return known->second;
    const Object object = Resolve(type);
    const auto& complete = object->x._u.complete;
    Declared declared;
    switch (complete._d) {
      case DDS_XTypes_TK_STRUCTURE:
        declared = {WriteStruct(complete._u.struct_type), ""};
        break;
      case DDS_XTypes_TK_UNION:
        declared = {WriteUnion(complete._u.union_type), ""};
        break;
      case DDS_XTypes_TK_ENUM:
        declared = {WriteEnum(complete._u.enumerated_type), ""};
        break;
      case DDS_XTypes_TK_ALIAS:
        declared = Declare(complete._u.alias_type.body.common.related_type);
        break;
      case DDS_XTypes_TK_BITMASK: {
        const auto bits = complete._u.bitmask_type.header.common.bit_bound;
        declared = {bits <= 8    ? "uint8"
                    : bits <= 16 ? "uint16"
                    : bits <= 32 ? "uint32"
                                 : "uint64",
                    ""};
        break;
      }
      default:
        throw NotDescribed{};
    }
    return known_[hash] = declared;
  }

  std::string WriteStruct(const DDS_XTypes_CompleteStructType& type) {
    const std::string name = type.header.detail.type_name;
    std::string base;
    if (type.header.base_type._d != DDS_XTypes_TK_NONE) {
      base = " : " + Declare(type.header.base_type).type;
    }
    Put(name, Extensibility(type.struct_flags), "struct", base, Members(type, false));
    return name;
  }

  std::string Members(const DDS_XTypes_CompleteStructType& type, bool keys_alone) {
    std::string body;
    for (const auto& member : View(type.member_seq)) {
      const auto flags = member.common.member_flags;
      const bool key = (flags & DDS_XTypes_IS_KEY) != 0;
      if (keys_alone && !key) continue;
      const Declared declared = Declare(member.common.member_type_id);
      body += fmt::format("    {}{}{} {}{};\n", key ? "@key " : "",
                          (flags & DDS_XTypes_IS_OPTIONAL) != 0 ? "@optional " : "",
                          declared.type, static_cast<const char*>(member.detail.name),
                          declared.suffix);
    }
    return body;
  }

  void WriteKey(const DDS_XTypes_CompleteStructType& type) {
    parts_.clear();
    known_.clear();
    const std::string body = Members(type, true);
    has_key_ = !body.empty();
    Put(std::string(type.header.detail.type_name) + "_key", "@final", "struct", "", body);
  }

  std::string WriteUnion(const DDS_XTypes_CompleteUnionType& type) {
    const std::string name = type.header.detail.type_name;
    std::string body;
    for (const auto& member : View(type.member_seq)) {
      for (const std::int32_t label : View(member.common.label_seq)) {
        body += fmt::format("    case {}:\n", label);
      }
      if ((member.common.member_flags & DDS_XTypes_IS_DEFAULT) != 0) {
        body += "    default:\n";
      }
      const Declared declared = Declare(member.common.type_id);
      body += fmt::format("      {} {}{};\n", declared.type,
                          static_cast<const char*>(member.detail.name), declared.suffix);
    }
    Put(name, Extensibility(type.union_flags), "union",
        fmt::format(" switch ({})", Declare(type.discriminator.common.type_id).type),
        body);
    return name;
  }

  std::string WriteEnum(const DDS_XTypes_CompleteEnumeratedType& type) {
    const std::string name = type.header.detail.type_name;
    std::string body;
    std::int32_t next = 0;
    for (const auto& literal : View(type.literal_seq)) {
      const std::int32_t value = literal.common.value;
      body += fmt::format("{}    {}{}", body.empty() ? "" : ",\n",
                          value == next ? "" : fmt::format("@value({}) ", value),
                          static_cast<const char*>(literal.detail.name));
      next = value + 1;
    }
    const auto bits = type.header.common.bit_bound;
    Put(name, bits == 32 ? "" : fmt::format("@bit_bound({})", bits), "enum", "",
        body + "\n");
    return name;
  }

  void Put(const std::string& name, const std::string& annotation, const char* keyword,
           const std::string& behind, const std::string& body) {
    const auto colons = name.rfind("::");
    const bool in_module = colons != std::string::npos;
    std::string text;
    if (!annotation.empty()) text += "  " + annotation + "\n";
    text += fmt::format("  {} {}{} {{\n{}  }};\n", keyword,
                        in_module ? name.substr(colons + 2) : name, behind, body);
    parts_.emplace_back(in_module ? name.substr(0, colons) : "", std::move(text));
  }

  /// Types beside each other of one module share its brackets.
  std::string Text() const {
    std::string text, module;
    std::size_t depth = 0;
    const auto close = [&] {
      for (; depth > 0; --depth) text += "};\n";
    };
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      if (i == 0 || parts_[i].first != module) {
        close();
        module = parts_[i].first;
        for (std::size_t at = 0; at < module.size(); ++depth) {
          const auto end = std::min(module.find("::", at), module.size());
          text += fmt::format("module {} {{\n", module.substr(at, end - at));
          at = end + 2;
        }
      }
      text += parts_[i].second;
    }
    close();
    return text;
  }

  dds_entity_t participant_;
  std::map<std::string, Declared> known_;                   // by hash
  std::vector<std::pair<std::string, std::string>> parts_;  // module, text
  bool has_key_ = false;
};

}  // namespace

std::optional<TypeText> TextOf(std::int32_t participant, const ddsi_typeinfo* type) {
  const ddsi_typeid_t* complete = ddsi_typeinfo_complete_typeid(type);
  if (complete == nullptr) return std::nullopt;
  try {
    Writer writer(participant);
    TypeText text = writer.Write(complete->x);
    text.key_idl = writer.key_text();
    return text;
  } catch (const NotDescribed&) {
    return std::nullopt;
  }
}

}  // namespace intaglio::bus::internal
