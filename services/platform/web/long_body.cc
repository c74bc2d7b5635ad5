#include <boost/asio/post.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/rfc7230.hpp>
#include <boost/beast/http/write.hpp>
#include <limits>
#include <optional>

#include "services/platform/web/sessions.h"

namespace intaglio::web {
namespace {

constexpr std::size_t kPieceBytes = 65536;
/// Read after a refusal: a client that still sends would not read the answer.
constexpr std::uint64_t kMaxDiscardedBytes = 1 << 20;
constexpr char kContinue[] = "HTTP/1.1 100 Continue\r\n\r\n";

class LongBody : public std::enable_shared_from_this<LongBody> {
 public:
  LongBody(CountedPtr counted, Stream stream, beast::flat_buffer buffer,
           HeadParser&& head)
      : counted_(std::move(counted)),
        core_(counted_->core()),
        stream_(std::move(stream)),
        buffer_(std::move(buffer)),
        parser_(std::move(head)),
        piece_(kPieceBytes, '\0'),
        answer_timer_(core_.io) {
    parser_.body_limit(std::numeric_limits<std::uint64_t>::max());
    awaits_continue_ = beast::iequals(parser_.get()[http::field::expect], "100-continue");
  }

  void Start(const Request& request) {
    const std::uint64_t length = parser_.content_length().value_or(0);
    sink_ = core_.handlers.body(
        request, length, [weak = weak_from_this(), &io = core_.io](Response response) {
          net::post(io, [weak, response = std::move(response)] {
            if (const auto self = weak.lock()) self->Answer(response);
          });
        });
    if (!sink_) return AwaitAnswer();
    if (length == 0) return End();
    if (awaits_continue_) return Continue();
    Read();
  }

 private:
  void Continue() {
    awaits_continue_ = false;
    is_busy_ = true;
    stream_.expires_after(core_.options.limits.write_time);
    net::async_write(stream_, net::buffer(kContinue, sizeof kContinue - 1),
                     [self = shared_from_this()](ErrorOf error, std::size_t) {
                       if (error) return;
                       self->is_busy_ = false;
                       if (self->answer_) return self->Discard(0);
                       self->Read();
                     });
  }

  void Read() {
    is_busy_ = true;
    parser_.get().body() = {piece_.data(), piece_.size(), true};
    stream_.expires_after(core_.options.limits.request_time);
    http::async_read_some(stream_, buffer_, parser_,
                          [self = shared_from_this()](ErrorOf error, std::size_t) {
                            self->Receive(error);
                          });
  }

  void Receive(ErrorOf error) {
    if (error && error != http::error::need_buffer) return;  // the connection broke
    is_busy_ = false;
    const std::size_t count = piece_.size() - parser_.get().body().size;
    if (answer_) return Discard(count);
    if (count == 0) return parser_.is_done() ? End() : Read();
    keeps_itself_ = shared_from_this();
    sink_->Receive(piece_.substr(0, count), [weak = weak_from_this(), &io = core_.io] {
      net::post(io, [weak] {
        if (const auto self = weak.lock()) self->Taken();
      });
    });
  }

  void Taken() {
    const auto self = std::move(keeps_itself_);
    if (answer_ || !self) return;
    if (parser_.is_done()) return End();
    Read();
  }

  void End() {
    AwaitAnswer();
    sink_->End();
  }

  void AwaitAnswer() {
    keeps_itself_ = shared_from_this();
    answer_timer_.expires_after(core_.options.limits.answer_time);
    answer_timer_.async_wait([self = shared_from_this()](ErrorOf error) {
      if (!error)
        self->Answer(
            TextResponse(504, "text/plain; charset=utf-8", "no answer in time\n"));
    });
  }

  void Answer(const Response& response) {
    if (answer_) return;
    answer_ = response;
    answer_timer_.cancel();
    const auto self = std::exchange(keeps_itself_, nullptr);
    sink_.reset();
    if (!is_busy_) Discard(0);
  }

  void Discard(std::size_t count) {
    discarded_bytes_ += count;
    const bool ends =
        parser_.is_done() || awaits_continue_ || discarded_bytes_ > kMaxDiscardedBytes;
    return ends ? Write() : Read();
  }

  void Write() {
    Fill(message_, *answer_, core_, false);
    stream_.expires_after(core_.options.limits.write_time);
    http::async_write(
        stream_, message_,
        [self = shared_from_this()](ErrorOf, std::size_t) { self->stream_.close(); });
  }

  CountedPtr counted_;
  Core& core_;
  Stream stream_;
  beast::flat_buffer buffer_;
  http::request_parser<http::buffer_body> parser_;
  std::string piece_;
  net::steady_timer answer_timer_;
  std::shared_ptr<BodySink> sink_;
  /// While nothing of the connection is under way: the sink or the handler is.
  std::shared_ptr<LongBody> keeps_itself_;
  std::optional<Response> answer_;
  http::response<http::buffer_body> message_;
  std::uint64_t discarded_bytes_ = 0;
  bool awaits_continue_ = false;
  bool is_busy_ = false;  ///< something is read or written
};

}  // namespace

void StartLongBody(CountedPtr counted, Stream stream, beast::flat_buffer buffer,
                   HeadParser&& head, Request request) {
  std::make_shared<LongBody>(std::move(counted), std::move(stream), std::move(buffer),
                             std::move(head))
      ->Start(request);
}

}  // namespace intaglio::web
