#include "services/platform/recording/idl_types.h"

#include <fmt/format.h>

#include <cctype>
#include <charconv>
#include <limits>
#include <optional>
#include <set>

namespace intaglio::recording {
namespace {

const std::map<std::string, IdlKind, std::less<>> kBuiltIn = {
    {"boolean", IdlKind::kBoolean}, {"octet", IdlKind::kOctet},
    {"int8", IdlKind::kInt8},       {"uint8", IdlKind::kUint8},
    {"int16", IdlKind::kInt16},     {"uint16", IdlKind::kUint16},
    {"int32", IdlKind::kInt32},     {"uint32", IdlKind::kUint32},
    {"int64", IdlKind::kInt64},     {"uint64", IdlKind::kUint64},
    {"float", IdlKind::kFloat},     {"double", IdlKind::kDouble},
    {"char", IdlKind::kChar},       {"string", IdlKind::kString}};

// An array that is larger than its bytes can be is refused where it is read.
constexpr std::uint32_t kMaxDimension = 1u << 20;

/// What is not understood; caught in ParseIdl.
struct SchemaStop {
  ErrorCode code;
  std::string word;
};

bool IsToken(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '@';
}

class Tokens {
 public:
  explicit Tokens(std::string_view text) : text_(text) { Advance(); }

  const std::string& now() const { return word_; }
  bool at_end() const { return word_.empty(); }
  std::string Take() {
    std::string taken = std::move(word_);
    Advance();
    return taken;
  }
  bool Accept(std::string_view word) {
    if (word_ != word) return false;
    Advance();
    return true;
  }
  void Expect(std::string_view word) {
    if (!Accept(word)) throw SchemaStop{ErrorCode::kUnreadable, word_};
  }
  std::string Name() {
    const bool name =
        !word_.empty() &&
        (std::isalpha(static_cast<unsigned char>(word_[0])) != 0 || word_[0] == '_');
    if (!name) throw SchemaStop{ErrorCode::kUnreadable, word_};
    return Take();
  }
  std::int64_t Number() {
    std::int64_t value = 0;
    const bool minus = Accept("-");
    const auto [end, error] =
        std::from_chars(word_.data(), word_.data() + word_.size(), value);
    if (error != std::errc() || end != word_.data() + word_.size()) {
      throw SchemaStop{ErrorCode::kUnreadable, word_};
    }
    Take();
    return minus ? -value : value;
  }

 private:
  void SkipBlanks() {
    for (;;) {
      while (at_ < text_.size() &&
             std::isspace(static_cast<unsigned char>(text_[at_])) != 0)
        ++at_;
      const std::string_view rest = text_.substr(at_);
      if (rest.starts_with("//")) {
        at_ = std::min(text_.find('\n', at_), text_.size());
      } else if (rest.starts_with("/*")) {
        const auto end = text_.find("*/", at_ + 2);
        at_ = end == std::string_view::npos ? text_.size() : end + 2;
      } else {
        return;
      }
    }
  }
  void Advance() {
    SkipBlanks();
    word_.clear();
    if (at_ >= text_.size()) return;
    std::size_t end = at_ + 1;
    if (IsToken(text_[at_])) {
      while (end < text_.size() && IsToken(text_[end])) ++end;
    } else if (text_.substr(at_, 2) == "::") {
      ++end;
    }
    word_ = text_.substr(at_, end - at_);
    at_ = end;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::string word_;
};

struct Annotations {
  bool appendable = false, optional = false;
  std::optional<std::int64_t> value, bit_bound;
};

class Parser {
 public:
  explicit Parser(std::string_view text) : words_(text) {}

  IdlTypes Parse() {
    while (!words_.at_end()) Definition("");
    return std::move(types_);
  }

 private:
  void Definition(const std::string& scope) {
    const Annotations annotations = TakeAnnotations();
    if (words_.Accept("module")) {
      const std::string inner = scope + words_.Name() + "::";
      // A module in a module, each a level of this recursion.
      if (++depth_ > 32) throw SchemaStop{ErrorCode::kUnsupported, inner};
      words_.Expect("{");
      while (!words_.Accept("}")) Definition(inner);
      --depth_;
    } else if (words_.Accept("struct")) {
      Struct(scope, annotations);
    } else if (words_.Accept("enum")) {
      Enum(scope, annotations);
    } else {
      throw SchemaStop{ErrorCode::kUnsupported, words_.now()};
    }
    words_.Expect(";");
  }

  Annotations TakeAnnotations() {
    Annotations found;
    while (words_.now().starts_with("@")) {
      const std::string name = words_.Take();
      std::optional<std::int64_t> number;
      if (words_.Accept("(")) {
        number = words_.Number();
        words_.Expect(")");
      }
      if (name == "@mutable") throw SchemaStop{ErrorCode::kUnsupported, name};
      found.appendable = found.appendable || name == "@appendable";
      found.optional = found.optional || name == "@optional";
      if (name == "@value") found.value = number;
      if (name == "@bit_bound") found.bit_bound = number;
    }
    return found;
  }

  void Struct(const std::string& scope, const Annotations& annotations) {
    const std::string name = scope + words_.Name();
    if (words_.now() == ":")
      throw SchemaStop{ErrorCode::kUnsupported, "inheritance of " + name};
    IdlStruct made;
    made.appendable = annotations.appendable;
    words_.Expect("{");
    while (!words_.Accept("}")) {
      const Annotations of_member = TakeAnnotations();
      IdlMember member = Type(scope);
      member.optional = of_member.optional;
      // Several names may share a type, each with dimensions of its own.
      do {
        IdlMember one = member;
        one.name = words_.Name();
        while (words_.Accept("[")) {
          one.dimensions.push_back(Size());
          words_.Expect("]");
        }
        made.members.push_back(std::move(one));
      } while (words_.Accept(","));
      words_.Expect(";");
    }
    if (!types_.structs.emplace(name, std::move(made)).second) {
      throw SchemaStop{ErrorCode::kUnreadable, name};
    }
  }

  std::uint32_t Size() {
    const std::int64_t size = words_.Number();
    if (size < 0 || size > kMaxDimension) {
      throw SchemaStop{ErrorCode::kUnsupported, std::to_string(size)};
    }
    return static_cast<std::uint32_t>(size);
  }

  IdlMember Type(const std::string& scope) {
    if (words_.Accept("sequence")) {
      words_.Expect("<");
      // Before going into it: otherwise the text would decide the depth of the stack.
      if (words_.now() == "sequence")
        throw SchemaStop{ErrorCode::kUnsupported, "sequence of sequences"};
      IdlMember element = Type(scope);
      if (words_.Accept(",")) (void)words_.Number();
      words_.Expect(">");
      element.sequence = true;
      return element;
    }
    std::string name = words_.Name();
    while (words_.Accept("::")) name += "::" + words_.Name();
    IdlMember member;
    if (const auto found = kBuiltIn.find(name); found != kBuiltIn.end()) {
      member.kind = found->second;
      if (member.kind == IdlKind::kString && words_.Accept("<")) {
        (void)words_.Number();
        words_.Expect(">");
      }
      return member;
    }
    for (const std::string& full : {name, scope + name}) {
      member.type = full;
      member.kind = types_.enums.contains(full) ? IdlKind::kEnum : IdlKind::kStruct;
      if (member.kind == IdlKind::kEnum || types_.structs.contains(full)) return member;
    }
    throw SchemaStop{ErrorCode::kUnsupported, name};
  }

  void Enum(const std::string& scope, const Annotations& annotations) {
    const std::string name = scope + words_.Name();
    IdlEnum made;
    made.bit_bound = static_cast<std::uint32_t>(annotations.bit_bound.value_or(32));
    words_.Expect("{");
    std::int64_t next = 0;
    do {
      next = TakeAnnotations().value.value_or(next);
      made.names.emplace(next, words_.Name());
      if (next == std::numeric_limits<std::int64_t>::max()) break;
      ++next;
    } while (words_.Accept(","));
    words_.Expect("}");
    if (!types_.enums.emplace(name, std::move(made)).second) {
      throw SchemaStop{ErrorCode::kUnreadable, name};
    }
  }

  Tokens words_;
  IdlTypes types_;
  int depth_ = 0;
};

}  // namespace

Result<IdlTypes> ParseIdl(std::string_view text) {
  try {
    return Parser(text).Parse();
  } catch (const SchemaStop& stop) {
    return Fail(stop.code,
                fmt::format("the schema's IDL cannot be parsed at \"{}\"", stop.word),
                stop.word);
  }
}

}  // namespace intaglio::recording
