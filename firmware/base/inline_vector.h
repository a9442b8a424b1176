#pragma once
/// A vector whose storage is inside it: no heap, a capacity in the type, and a push that says when it is full.
#include <array>
#include <cstddef>
#include <span>
#include <type_traits>

#include "base/contract.h"

namespace ninedot {

/// T must be trivially destructible and default constructible; elements beyond size() hold stale values.
template <typename T, std::size_t Capacity>
class InlineVector {
  static_assert(std::is_trivially_destructible_v<T>);

 public:
  [[nodiscard]] bool try_push_back(const T& value) noexcept {
    if (size_ == Capacity) return false;
    items_[size_++] = value;
    return true;
  }
  void pop_back() noexcept {
    EXPECTS(size_ > 0);
    --size_;
  }
  void clear() noexcept { size_ = 0; }
  /// Shrinks to the first `count` elements. \param count <= size() (contract)
  void truncate(std::size_t count) noexcept {
    EXPECTS(count <= size_);
    size_ = count;
  }

  T& operator[](std::size_t i) noexcept {
    EXPECTS(i < size_);
    return items_[i];
  }
  const T& operator[](std::size_t i) const noexcept {
    EXPECTS(i < size_);
    return items_[i];
  }
  std::size_t size() const noexcept { return size_; }
  bool empty() const noexcept { return size_ == 0; }
  bool full() const noexcept { return size_ == Capacity; }
  static constexpr std::size_t capacity() noexcept { return Capacity; }

  T* begin() noexcept { return items_.data(); }
  T* end() noexcept { return items_.data() + size_; }
  const T* begin() const noexcept { return items_.data(); }
  const T* end() const noexcept { return items_.data() + size_; }
  std::span<const T> span() const noexcept { return {items_.data(), size_}; }

 private:
  std::array<T, Capacity> items_{};
  std::size_t size_ = 0;
};

}  // namespace ninedot
