#include "services/console/photo_api.h"

#include <fmt/format.h>

#include <array>
#include <system_error>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/whole_file.h"
#include "services/console/answers/json_response.h"

namespace intaglio::console {
namespace {

namespace fs = std::filesystem;

/// What browsers show.
struct PhotoKind {
  std::string_view begin;  ///< first bytes
  const char* file;
  const char* content_type;
};
constexpr std::array<PhotoKind, 2> kPhotoKinds = {
    {{"\xff\xd8\xff", "block_photo.jpg", "image/jpeg"},
     {"\x89PNG\r\n", "block_photo.png", "image/png"}}};

const PhotoKind* PhotoKindOf(std::string_view bytes) {
  for (const PhotoKind& kind : kPhotoKinds) {
    if (bytes.starts_with(kind.begin)) return &kind;
  }
  return nullptr;
}

image::ImageLimits PhotoLimits() {
  image::ImageLimits limits;
  limits.max_file_bytes = kMaxPhotoBytes;
  limits.max_pixels = 12'000'000;
  limits.max_decoder_bytes = std::uint64_t{48} << 20;
  return limits;
}

web::Response Refused(const Error& error) {
  return ErrorResponse(StatusOf(error.code, 422), error);
}

}  // namespace

std::optional<std::string> JobOfPhotoPath(std::string_view path) {
  constexpr std::string_view kBegin = kPhotosPath;
  if (!path.starts_with(kBegin)) return std::nullopt;
  return std::string(path.substr(kBegin.size()));
}

Status SavePhoto(const fs::path& folder, const std::string& name, std::string_view bytes,
                 const reading::PictureProcess& reader) {
  const PhotoKind* kind = PhotoKindOf(bytes);
  if (kind == nullptr) {
    return Fail(ErrorCode::kUnsupported,
                name + ": is no JPEG or PNG file: save the photo as one of these", name);
  }
  INTAGLIO_TRY(reading::CheckPictureBy(reader, bytes, PhotoLimits(), name));
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    return Fail(ErrorCode::kNotFound,
                fmt::format("{}: the folder of the job is not here: it is made with its "
                            "points, on the computer of its machine; send the photo then",
                            name),
                name);
  }
  INTAGLIO_TRY(io::WriteFileAtomically(folder / kind->file, bytes));
  for (const PhotoKind& other : kPhotoKinds) {
    if (&other != kind) fs::remove(folder / other.file, error);
  }
  return {};
}

class PhotoApi::Sink : public web::BodySink {
 public:
  Sink(PhotoApi& api, std::string job, std::string name, web::Reply reply)
      : api_(api),
        job_(std::move(job)),
        name_(std::move(name)),
        reply_(std::move(reply)) {}
  void Receive(std::string bytes, std::function<void()> taken) override {
    bytes_ += bytes;
    taken();
  }
  void End() override { api_.Save(job_, std::move(name_), std::move(bytes_), reply_); }

 private:
  PhotoApi& api_;
  std::string job_, name_, bytes_;
  web::Reply reply_;
};

void PhotoApi::Ask(const std::string& job, const web::Reply& reply,
                   std::function<void(const FoundJob& found)> work) {
  find_job_(job, [this, reply, work = std::move(work)](Result<FoundJob> found) {
    if (!found) return reply(ErrorResponse(404, found.error()));
    if (!files_.Ask([work, found = *found] { work(found); }))
      reply(ErrorResponse(503, "too many files are being read: try again"));
  });
}

void PhotoApi::AnswerGet(const std::string& job, const web::Reply& reply) {
  Ask(job, reply, [reply](const FoundJob& found) {
    for (const PhotoKind& kind : kPhotoKinds) {
      auto bytes = io::ReadWholeFile(found.folder / kind.file, kMaxPhotoBytes);
      if (bytes)
        return reply(web::TextResponse(200, kind.content_type, std::move(*bytes)));
    }
    reply(ErrorResponse(404, "nobody has added a photo to this job here"));
  });
}

std::shared_ptr<web::BodySink> PhotoApi::Receive(const std::string& job,
                                                 const web::Request& request,
                                                 std::uint64_t body_bytes,
                                                 const web::Reply& reply) {
  const auto found = request.target.query.find("name");
  const std::string name = found == request.target.query.end() ? "photo" : found->second;
  if (body_bytes > kMaxPhotoBytes) {
    reply(ErrorResponse(413,
                        name + ": has more than 8 MB: save the photo with fewer pixels"));
    return nullptr;
  }
  return std::make_shared<Sink>(*this, job, name, reply);
}

void PhotoApi::Save(const std::string& job, std::string name, std::string bytes,
                    const web::Reply& reply) {
  Ask(job, reply,
      [reply, name = std::move(name), bytes = std::move(bytes),
       reader = reader_](const FoundJob& found) {
        if (const auto saved = SavePhoto(found.folder, name, bytes, reader); !saved)
          return reply(Refused(saved.error()));
        CommandAnswer answer;
        answer.set_job(found.number);
        answer.set_taken(true);
        answer.set_code("taken");
        reply(JsonResponse(200, answer));
      });
}

}  // namespace intaglio::console
