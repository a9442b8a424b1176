#pragma once
/// Objects with memory of their own, from an ordinary thread to a real-time one and back to be freed: the real-time
/// thread neither waits nor allocates nor frees. One at most is on its way in each direction.
#include <atomic>
#include <memory>
#include <utility>

#include "base/contract.h"

namespace ninedot {

/// Memory: two pointers. Threads: see each method.
template <typename T>
class ObjectHandoff {
 public:
  ObjectHandoff() = default;
  ObjectHandoff(const ObjectHandoff&) = delete;
  ObjectHandoff& operator=(const ObjectHandoff&) = delete;
  ~ObjectHandoff() {
    delete offered_.load();
    delete returned_.load();
  }

  /// Newest wins: one that was not taken yet is freed. Threads: any ordinary one.
  void put(std::unique_ptr<T> object) noexcept {
    delete offered_.exchange(object.release(), std::memory_order_acq_rel);
    free_returned();
  }

  /// Frees what was given back. Without it nothing further is taken. Threads: any ordinary one.
  void free_returned() noexcept { delete returned_.exchange(nullptr, std::memory_order_acquire); }

  /// The newest object; null: there is none, or what was given back has not been freed yet. Wait-free.
  /// Threads: one, the taker.
  std::unique_ptr<T> take() noexcept {
    if (offered_.load(std::memory_order_relaxed) == nullptr) return nullptr;
    if (returned_.load(std::memory_order_acquire) != nullptr) return nullptr;
    return std::unique_ptr<T>(offered_.exchange(nullptr, std::memory_order_acq_rel));
  }

  /// \param object  that is no longer used; one for each that was taken (contract). Wait-free. Threads: the taker.
  void give_back(std::unique_ptr<T> object) noexcept {
    const T* before = returned_.exchange(object.release(), std::memory_order_acq_rel);
    EXPECTS(before == nullptr);
  }

 private:
  std::atomic<T*> offered_{nullptr}, returned_{nullptr};
};

}  // namespace ninedot
