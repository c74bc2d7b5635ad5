#include "services/platform/text_format/text_format.h"

#include <fmt/format.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/text_format.h>

#include "engrave/core/try.h"
#include "engrave/io/byte_order_mark.h"
#include "services/platform/text_format/field_suggestion.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;

class FirstError : public pb::io::ErrorCollector {
 public:
  void AddError(int line, pb::io::ColumnNumber column,
                const std::string& message) override {
    if (!text_.empty()) return;
    text_ = line < 0 ? " " + message
                     : fmt::format("{}:{}: {}", line + 1, column + 1, message);
  }
  void AddWarning(int, pb::io::ColumnNumber, const std::string&) override {}
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace

Status CheckTextSize(std::string_view text, const std::string& name,
                     std::size_t max_bytes, const char* what) {
  if (text.size() <= max_bytes) return {};
  return Fail(ErrorCode::kTooLarge,
              fmt::format("{}: is larger than {} bytes; give {}", name, max_bytes, what));
}

Status CheckTextCode(std::string_view text, const std::string& name) {
  if (!text.starts_with("\xFF\xFE") && !text.starts_with("\xFE\xFF")) return {};
  return Fail(ErrorCode::kUnreadable,
              fmt::format("{}: is in UTF-16; save it as UTF-8", name));
}

Status ParseTextFormat(std::string_view text, const std::string& name, int max_depth,
                       pb::Message& message) {
  INTAGLIO_TRY(CheckTextCode(text, name));
  text = io::WithoutByteOrderMark(text);
  FirstError first;
  pb::TextFormat::Parser parser;
  parser.RecordErrorsTo(&first);
  parser.SetRecursionLimit(max_depth);
  pb::io::ArrayInputStream stream(text.data(), static_cast<int>(text.size()));
  if (parser.Parse(&stream, &message)) return {};
  return Fail(ErrorCode::kUnreadable,
              fmt::format("{}:{}{}", name, first.text(),
                          SuggestionFor(*message.GetDescriptor(), first.text())));
}

}  // namespace intaglio
