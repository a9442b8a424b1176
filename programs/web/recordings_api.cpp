#include "programs/web/recordings_api.h"

#include <fmt/format.h>

#include <utility>

#include "programs/web/tar_stream.h"

namespace ninedot {
namespace {

constexpr std::size_t kPiece_bytes = std::size_t{64} * 1024;

struct Download {
  TarStream archive;
  std::function<void()> on_progress;
  int& count;
};

ssize_t read_piece(void* self, std::uint64_t /*position*/, char* to, std::size_t room) {
  auto& download = *static_cast<Download*>(self);
  download.on_progress();
  const ssize_t count = download.archive.read({to, room});
  return count > 0 ? count : count == 0 ? MHD_CONTENT_READER_END_OF_STREAM : MHD_CONTENT_READER_END_WITH_ERROR;
}

void end_download(void* self) {
  const std::unique_ptr<Download> download(static_cast<Download*>(self));
  --download->count;
}

const char* type_of(std::string_view file) {
  return file.ends_with(".png") ? "image/png" : file.ends_with(".json") ? kJsonText : "text/csv; charset=utf-8";
}

}  // namespace

MHD_Result RecordingsApi::answer(MHD_Connection* connection, std::string_view path, std::function<void()> on_progress) {
  if (path == kRecordingsPath) return send_text(connection, MHD_HTTP_OK, recorder_.state_json(), kJsonText);
  const auto asked = parse_recording_path(path.substr(kRecordingsPath.size() + 1));
  const std::string folder = asked ? recorder_.folder_of(asked->name) : std::string();
  if (folder.empty())
    return send_text(connection, MHD_HTTP_NOT_FOUND, "There is no such recording, or it is not over yet.\n",
                     kPlainText);
  if (asked->file.empty()) return send_archive(connection, asked->name, folder, std::move(on_progress));
  return send_disk_file(connection, fmt::format("{}/{}", folder, asked->file), type_of(asked->file),
                        "This recording has no such file.\n");
}

MHD_Result RecordingsApi::send_archive(MHD_Connection* connection, std::string_view name, const std::string& folder,
                                       std::function<void()> on_progress) {
  if (downloads_ >= kMostDownloads)
    return send_text(connection, MHD_HTTP_SERVICE_UNAVAILABLE,
                     "Two recordings are being downloaded already: try again when one is through.\n", kPlainText, true);
  auto download =
      std::make_unique<Download>(Download{TarStream(folder, std::string(name)), std::move(on_progress), downloads_});
  Answer answer(connection, MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, kPiece_bytes, &read_piece,
                                                              download.get(), &end_download));
  if (!answer) return MHD_NO;
  ++downloads_;
  static_cast<void>(download.release());  // end_download's
  const std::string disposition = fmt::format("attachment; filename=\"{}.tar\"", name);
  answer.header("Content-Type", "application/x-tar")
      .header("Content-Disposition", disposition.c_str())
      .header("Cache-Control", "no-store");
  return answer.send(MHD_HTTP_OK);
}

}  // namespace ninedot
