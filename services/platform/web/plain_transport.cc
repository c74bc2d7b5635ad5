#include <boost/asio/post.hpp>

#include "services/platform/web/stream.h"

namespace intaglio::web {
namespace {

class Plain : public Transport {
 public:
  explicit Plain(beast::tcp_stream stream) : stream_(std::move(stream)) {}

  void Open(std::function<void(ErrorOf)> done) override {
    net::post(stream_.get_executor(), [done = std::move(done)] { done({}); });
  }
  void Read(std::vector<net::mutable_buffer> buffers, Done done) override {
    stream_.async_read_some(buffers, std::move(done));
  }
  void Write(std::vector<net::const_buffer> buffers, Done done) override {
    stream_.async_write_some(buffers, std::move(done));
  }
  void End(std::function<void(ErrorOf)> done) override {
    ErrorOf error;
    stream_.socket().shutdown(net::ip::tcp::socket::shutdown_send, error);
    net::post(stream_.get_executor(), [done = std::move(done), error] { done(error); });
  }
  beast::tcp_stream& tcp() override { return stream_; }

 private:
  beast::tcp_stream stream_;
};

}  // namespace

std::unique_ptr<Transport> PlainTransport(beast::tcp_stream stream) {
  return std::make_unique<Plain>(std::move(stream));
}

}  // namespace intaglio::web
