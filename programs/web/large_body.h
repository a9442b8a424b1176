#pragma once
/// Room for one long request at a time: 256 guests with a configuration each would be 64 MB.
#include <string>
#include <string_view>

#include "programs/web/access.h"

namespace ninedot {

/// Memory: fixed, kMostLargeBody_bytes. Threads: one at a time.
class LargeBody {
 public:
  LargeBody() { text_.reserve(kMostLargeBody_bytes); }

  /// \param owner  the connection \return  false: another one has it
  bool take(const void* owner) noexcept {
    if (owner_ != nullptr) return false;
    owner_ = owner;
    return true;
  }
  bool is_of(const void* owner) const noexcept { return owner_ == owner && owner != nullptr; }
  /// \return  false: more than fits
  bool append(std::string_view part) {
    if (part.size() > kMostLargeBody_bytes - text_.size()) return false;
    text_ += part;
    return true;
  }
  /// Lifetime: until it is given back.
  std::string_view text() const noexcept { return text_; }
  /// Of whoever has it; others may say it as well.
  void give_back(const void* owner) noexcept {
    if (!is_of(owner)) return;
    owner_ = nullptr;
    text_.clear();
  }

 private:
  const void* owner_ = nullptr;
  std::string text_;
};

}  // namespace ninedot
