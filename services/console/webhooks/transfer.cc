#include "services/console/webhooks/transfer.h"

#include <curl/curl.h>
#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "engrave/core/check.h"

namespace intaglio::console {

struct Transfer::Impl {
  std::unique_ptr<CURL, void (*)(CURL*)> easy{nullptr, curl_easy_cleanup};
  std::unique_ptr<curl_slist, void (*)(curl_slist*)> headers{nullptr,
                                                             curl_slist_free_all};
  std::shared_ptr<const std::string> body;
  std::array<char, CURL_ERROR_SIZE> error{};
  std::string kept;          ///< the beginning of the answer's body
  std::size_t received = 0;  ///< bytes of the answer's body
};

namespace {

/// Programs that the console starts get no connection of it.
int CloseOnExec(void*, curl_socket_t socket, curlsocktype) {
  fcntl(socket, F_SETFD, FD_CLOEXEC);
  return CURL_SOCKOPT_OK;
}

void StartCurl() {
  static const CURLcode kStarted = curl_global_init(CURL_GLOBAL_DEFAULT);
  Require(kStarted == CURLE_OK, "libcurl does not start");
}

template <typename Value>
void Set(CURL* easy, CURLoption option, Value value) {
  const CURLcode code = curl_easy_setopt(easy, option, value);
  Require(code == CURLE_OK, "libcurl refuses option {}: {}", static_cast<int>(option),
          curl_easy_strerror(code));
}

void SetRules(CURL* easy, const Receiver& receiver) {
  Set(easy, CURLOPT_URL, receiver.url.c_str());
  Set(easy, CURLOPT_PROTOCOLS_STR, "http,https");
  Set(easy, CURLOPT_FOLLOWLOCATION, 0L);
  Set(easy, CURLOPT_PROXY, "");  // also none of the environment
  Set(easy, CURLOPT_HTTP_VERSION, static_cast<long>(CURL_HTTP_VERSION_1_1));
  Set(easy, CURLOPT_USERAGENT, "intaglio-console");
  Set(easy, CURLOPT_POST, 1L);
  const std::chrono::milliseconds max_time = Transfer::kMaxTime;
  Set(easy, CURLOPT_TIMEOUT_MS, static_cast<long>(max_time.count()));
  Set(easy, CURLOPT_NOSIGNAL, 1L);
  // Without it the end of a transfer waits for a name server that does not answer, and
  // with it every receiver does.
  Set(easy, CURLOPT_QUICK_EXIT, 1L);
  Set(easy, CURLOPT_SSL_VERIFYPEER, 1L);
  Set(easy, CURLOPT_SSL_VERIFYHOST, 2L);
  Set(easy, CURLOPT_SSLVERSION, static_cast<long>(CURL_SSLVERSION_TLSv1_2));
  if (receiver.ca_file.empty()) return;
  Set(easy, CURLOPT_CAINFO, receiver.ca_file.c_str());
  Set(easy, CURLOPT_CAPATH, static_cast<const char*>(nullptr));  // the system's
}

}  // namespace

DeliveryOutcome WebhookAnswer::outcome() const {
  if (status >= 200 && status < 300) return DeliveryOutcome::kDelivered;
  return status == 410 ? DeliveryOutcome::kGone : DeliveryOutcome::kFailed;
}

std::string WebhookAnswer::Sentence() const {
  if (status == 0) return fmt::format("no answer: {}", reason);
  if (status >= 300 && status < 400)
    return fmt::format(
        "answered {}: redirects are not followed, put the new address in "
        "url",
        status);
  return fmt::format("answered {}", status);
}

Transfer::Transfer(const Receiver& receiver) : impl_(std::make_unique<Impl>()) {
  StartCurl();
  impl_->easy.reset(curl_easy_init());
  CURL* easy = impl_->easy.get();
  Require(easy != nullptr, "no memory for a transfer");
  SetRules(easy, receiver);
  Set(easy, CURLOPT_SOCKOPTFUNCTION, &CloseOnExec);
  Set(easy, CURLOPT_ERRORBUFFER, impl_->error.data());
  Set(easy, CURLOPT_PRIVATE, static_cast<void*>(this));
  Set(easy, CURLOPT_WRITEDATA, static_cast<void*>(impl_.get()));
  // Less than it was given ends the transfer.
  using Take = std::size_t (*)(char*, std::size_t, std::size_t, void*);
  const Take take = [](char* bytes, std::size_t, std::size_t count, void* data) {
    Impl& impl = *static_cast<Impl*>(data);
    impl.received += count;
    impl.kept.append(bytes,
                     std::min(count, WebhookAnswer::kMaxKeptBytes - impl.kept.size()));
    return impl.received > kMaxAnswerBytes ? std::size_t{0} : count;
  };
  Set(easy, CURLOPT_WRITEFUNCTION, take);
}

Transfer::~Transfer() = default;

void* Transfer::handle() const { return impl_->easy.get(); }

void Transfer::Prepare(const std::vector<std::string>& headers,
                       std::shared_ptr<const std::string> body) {
  curl_slist* list = nullptr;
  for (const std::string& header : headers)
    list = curl_slist_append(list, header.c_str());
  list = curl_slist_append(list, "Expect:");  // the body follows at once
  impl_->headers.reset(list);
  impl_->body = std::move(body);
  impl_->error = {};
  impl_->kept.clear();
  impl_->received = 0;
  CURL* easy = impl_->easy.get();
  Set(easy, CURLOPT_HTTPHEADER, list);
  Set(easy, CURLOPT_POSTFIELDS, impl_->body->data());
  Set(easy, CURLOPT_POSTFIELDSIZE, static_cast<long>(impl_->body->size()));
}

WebhookAnswer Transfer::Finish(int code) {
  WebhookAnswer answer;
  answer.body = impl_->kept;
  const bool is_cut = code == CURLE_WRITE_ERROR && impl_->received > kMaxAnswerBytes;
  if (code == CURLE_OK || is_cut) {
    curl_easy_getinfo(impl_->easy.get(), CURLINFO_RESPONSE_CODE, &answer.status);
  } else {
    answer.reason = impl_->error[0] != '\0'
                        ? impl_->error.data()
                        : curl_easy_strerror(static_cast<CURLcode>(code));
  }
  return answer;
}

}  // namespace intaglio::console
