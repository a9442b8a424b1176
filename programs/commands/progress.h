#pragma once
/// How far a long command has come.
#include <string_view>

#include "base/mono_time.h"

namespace ninedot {

/// One line on standard error that is written over and over, ten times a second at most; on a terminal only.
/// Threads: one.
class Progress {
 public:
  Progress();
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// \return  whether it would be shown now; spares whoever makes the words
  bool is_due() const noexcept;
  void show(std::string_view words);
  void clear();

 private:
  bool terminal_;
  MonoTime shown_at_{};
};

}  // namespace ninedot
