// Runs a fuzz target over the files of a folder: the corpus as an ordinary test, with any compiler. Each file is also
// cut at several lengths, so that a target sees truncated input without a fuzzer.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count);

int main(int argc, char** argv) {
  if (argc != 2 || !std::filesystem::is_directory(argv[1])) {
    std::fprintf(stderr, "usage: %s CORPUS_FOLDER\n", argv[0]);
    return 2;
  }
  constexpr std::size_t kCuts = 64;
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(argv[1])) {
    std::ifstream stream(entry.path(), std::ios::binary);
    const std::vector<char> text(std::istreambuf_iterator<char>(stream), {});
    std::vector<std::size_t> lengths{text.size()};
    for (std::size_t cut = 0; cut < kCuts; ++cut) lengths.push_back(text.size() * cut / kCuts);
    for (const std::size_t length : lengths) {
      // A copy of exactly this length: the address sanitizer sees the first byte read beyond it.
      const std::vector<std::uint8_t> bytes(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(length));
      LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
    }
    ++files;
  }
  std::printf("%d files\n", files);
  return files > 0 ? 0 : 1;
}
