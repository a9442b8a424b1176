#pragma once
/// The page's own files, built into the program (embed.cmake).
#include <cstdint>
#include <span>
#include <string_view>

namespace ninedot {

struct PageFile {
  std::string_view name;  ///< "index.html"
  const char* tag;        ///< ETag, with its quotes
  std::span<const std::uint8_t> bytes;
};

/// Those of programs/web/page. Threads: any.
std::span<const PageFile> page_files() noexcept;

/// By the name's ending; text/plain where nothing is known of it.
const char* content_type_of(std::string_view name) noexcept;

}  // namespace ninedot
