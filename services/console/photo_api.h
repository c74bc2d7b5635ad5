#pragma once

// Photographs of blocks: one a job, in the job's folder, that a person adds.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "engrave/core/result.h"
#include "services/console/answers/find_job.h"
#include "services/console/cloud_reader.h"
#include "services/job/reading/picture_process.h"
#include "services/platform/web/server.h"

namespace intaglio::console {

inline constexpr char kPhotosPath[] = "/api/v1/photos/";
inline constexpr std::uint64_t kMaxPhotoBytes = 8 << 20;

/// "7" of "/api/v1/photos/7"; nullopt: another path.
std::optional<std::string> JobOfPhotoPath(std::string_view path);

/// Saves a photograph in place of the one before, when `reader` can decode it: a file
/// that crashes its decoder costs that process alone. `name`: of the file, for errors.
/// kUnsupported: it is no JPEG or PNG file; kUnreadable: it is damaged; kTooLarge: it has
/// more than 12 million pixels; kNotFound: there is no such folder yet; kIo.
Status SavePhoto(const std::filesystem::path& folder, const std::string& name,
                 std::string_view bytes, const reading::PictureProcess& reader);

/// In the server's thread; files have a thread of their own.
class PhotoApi {
 public:
  /// `files` lives longer.
  PhotoApi(FindJob find_job, CloudReader& files, reading::PictureProcess reader)
      : find_job_(std::move(find_job)), files_(files), reader_(std::move(reader)) {}

  void AnswerGet(const std::string& job, const web::Reply& reply);
  /// Its bytes; `name` of the query is that of the file.
  std::shared_ptr<web::BodySink> Receive(const std::string& job,
                                         const web::Request& request,
                                         std::uint64_t body_bytes,
                                         const web::Reply& reply);

 private:
  class Sink;
  void Save(const std::string& job, std::string name, std::string bytes,
            const web::Reply& reply);
  void Ask(const std::string& job, const web::Reply& reply,
           std::function<void(const FoundJob& found)> work);

  FindJob find_job_;
  CloudReader& files_;
  reading::PictureProcess reader_;
};

}  // namespace intaglio::console
