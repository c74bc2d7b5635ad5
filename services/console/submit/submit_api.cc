#include "services/console/submit/submit_api.h"

#include <charconv>
#include <utility>

#include "engrave/io/whole_file.h"
#include "services/client/refusal_code.h"
#include "services/console/answers/json_response.h"
#include "services/job/files/job_file.h"

namespace intaglio::console {
namespace {

constexpr std::string_view kFiles = "/files/";
constexpr std::string_view kPreview = "/preview";
constexpr std::uint64_t kMaxPictureBytes = 64 << 20;
constexpr char kBusy[] = "too many files come at once: try again";
constexpr int kNoSpace = 507;

web::Response RefusalOf(const Error& error) {
  UploadAnswer answer;
  answer.set_message(error.message);
  answer.set_code(client::RefusalCode(error));
  return JsonResponse(StatusOf(error.code, kNoSpace), answer);
}

/// That of points or of contours.
web::Response PreviewPictureIn(const std::filesystem::path& folder) {
  for (const char* file : kPreviewPictures) {
    const bool is_svg = std::string_view(file).ends_with(".svg");
    auto picture = io::ReadWholeFile(folder / file, kMaxPictureBytes);
    if (picture)
      return web::TextResponse(200, is_svg ? "image/svg+xml" : "image/png",
                               std::move(*picture));
    if (picture.error().code != ErrorCode::kNotFound) return RefusalOf(picture.error());
  }
  return ErrorResponse(404, "there is no preview of this submission yet");
}

/// `fallback` without the name; nullopt: no whole number.
std::optional<std::uint64_t> NumberOf(const web::Request& request, const char* name,
                                      std::uint64_t fallback) {
  const auto found = request.target.query.find(name);
  if (found == request.target.query.end()) return fallback;
  std::uint64_t number = 0;
  const std::string& text = found->second;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), number);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole ? std::optional(number) : std::nullopt;
}

/// A file that comes; each step is in the disk's thread, in its order.
class Receiver : public web::BodySink {
 public:
  struct Wanted {
    SubmissionPath path;
    std::uint64_t offset_bytes, size_bytes;
  };
  Receiver(const UploadFolder& uploads, WorkQueue& disk, Wanted wanted, web::Reply reply)
      : disk_(disk), reply_(std::move(reply)), state_(std::make_shared<State>()) {
    Add([state = state_, &uploads, wanted = std::move(wanted), reply = reply_] {
      uploads.RemoveOld();
      auto opened = uploads.Open(wanted.path.id, wanted.path.file, wanted.offset_bytes,
                                 wanted.size_bytes);
      if (!opened) return reply(RefusalOf(opened.error()));
      state->upload = std::move(*opened);
    });
  }

  void Receive(std::string bytes, std::function<void()> taken) override {
    Add([state = state_, bytes = std::move(bytes), taken = std::move(taken),
         reply = reply_] {
      if (!state->upload) return;
      if (const auto written = state->upload->Write(bytes); !written) {
        state->upload.reset();
        return reply(RefusalOf(written.error()));
      }
      taken();
    });
  }

  void End() override {
    Add([state = state_, reply = reply_] {
      if (!state->upload) return;
      const auto answer = std::exchange(state->upload, nullptr)->Close();
      reply(answer ? JsonResponse(200, *answer) : RefusalOf(answer.error()));
    });
  }

 private:
  struct State {
    std::unique_ptr<OpenUpload> upload;  // null: refused
  };
  void Add(std::function<void()> work) {
    if (!disk_.Add(std::move(work))) reply_(ErrorResponse(503, kBusy));
  }
  WorkQueue& disk_;
  web::Reply reply_;
  std::shared_ptr<State> state_;
};

}  // namespace

/// A job file, which is submitted, or shown before that, when it is whole.
class SubmitApi::JobFileSink : public web::BodySink {
 public:
  JobFileSink(SubmitApi& submit, SubmissionPath path, web::Reply reply)
      : submit_(submit), path_(std::move(path)), reply_(std::move(reply)) {}
  void Receive(std::string bytes, std::function<void()> taken) override {
    text_ += bytes;
    taken();
  }
  void End() override {
    if (path_.is_preview)
      submit_.Preview(path_.id, std::move(text_), std::move(reply_));
    else
      submit_.Submit(path_.id, std::move(text_), std::move(reply_));
  }

 private:
  SubmitApi& submit_;
  SubmissionPath path_;
  std::string text_;
  web::Reply reply_;
};

std::optional<SubmissionPath> ParseSubmissionPath(std::string_view path) {
  constexpr std::string_view kBegin = kSubmissionsPath;
  if (!path.starts_with(kBegin)) return std::nullopt;
  path.remove_prefix(kBegin.size());
  const auto slash = path.find('/');
  SubmissionPath parsed{std::string(path.substr(0, slash)), {}};
  if (slash == std::string_view::npos) return parsed;
  path.remove_prefix(slash);
  parsed.is_preview = path == kPreview;
  if (parsed.is_preview) return parsed;
  if (!path.starts_with(kFiles)) return std::nullopt;
  parsed.file = path.substr(kFiles.size());
  return parsed;
}

void SubmitApi::AnswerGet(const SubmissionPath& path, web::Reply reply) {
  const bool taken = disk_.Add([this, path, reply] {
    if (path.is_preview) {
      const auto folder = uploads_.FolderOf(path.id);
      if (!folder) return reply(RefusalOf(folder.error()));
      return reply(PreviewPictureIn(*folder));
    }
    const auto answer = uploads_.Find(path.id, path.file);
    reply(answer ? JsonResponse(200, *answer) : RefusalOf(answer.error()));
  });
  if (!taken) reply(ErrorResponse(503, kBusy));
}

void SubmitApi::AnswerChoices(web::Reply reply) {
  const bool taken = disk_.Add([this, reply] {
    const auto choices = ListJobChoices(machines_(), materials_);
    reply(choices ? JsonResponse(200, *choices)
                  : ErrorResponse(StatusOf(choices.error().code), choices.error()));
  });
  if (!taken) reply(ErrorResponse(503, kBusy));
}

std::shared_ptr<web::BodySink> SubmitApi::Receive(const SubmissionPath& path,
                                                  const web::Request& request,
                                                  std::uint64_t body_bytes,
                                                  web::Reply reply) {
  if (path.file.empty() && body_bytes > kMaxJobFileBytes) {
    reply(ErrorResponse(413, "a job file has at most 1 MB"));
    return nullptr;
  }
  if (path.file.empty())
    return std::make_shared<JobFileSink>(*this, path, std::move(reply));
  const auto offset = NumberOf(request, "offset", 0);
  const auto size = NumberOf(request, "size", offset.value_or(0) + body_bytes);
  if (!offset || !size) {
    reply(ErrorResponse(400, "offset, size: give whole numbers"));
    return nullptr;
  }
  return std::make_shared<Receiver>(
      uploads_, disk_, Receiver::Wanted{path, *offset, *size}, std::move(reply));
}

void SubmitApi::Submit(const std::string& id, std::string job_file, web::Reply reply) {
  Run([this, id,
       job_file = std::move(job_file)] { return submissions_.Submit(id, job_file); },
      reply);
}

void SubmitApi::SubmitWritten(const std::string& id, Submissions::Writer writer,
                              web::Reply reply) {
  Run([this, id,
       writer = std::move(writer)] { return submissions_.SubmitWritten(id, writer); },
      reply);
}

void SubmitApi::Run(std::function<SubmissionAnswer()> submit, const web::Reply& reply) {
  const bool taken = runs_.Add([submit = std::move(submit), reply] {
    const SubmissionAnswer submitted = submit();
    reply(JsonResponse(submitted.status, submitted.answer));
  });
  if (!taken) reply(ErrorResponse(503, "too many jobs are submitted at once: try again"));
}

void SubmitApi::Preview(const std::string& id, std::string job_file, web::Reply reply) {
  const bool taken = previews_.Add([this, id, job_file = std::move(job_file), reply] {
    const PreviewAnswer made = submissions_.Preview(id, job_file);
    reply(made.preview ? JsonResponse(200, *made.preview)
                       : JsonResponse(made.status, made.refusal));
  });
  if (!taken) reply(ErrorResponse(503, "too many previews are made at once: try again"));
}

}  // namespace intaglio::console
